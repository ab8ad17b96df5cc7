"""The exact delay system against independent values, a plain reference of itself, and starts meant to break it."""

import numpy as np
import pytest

from reduced.delay.alike import Delay
from slipwave import read
from slipwave.errors import NumericsError, SceneError
from slipwave.observe import EventObserver, summarise
from slipwave.solve import follow

JUMP = {"start.kind": "jump", "start.size": 0.05}


def paper(log10_r, **keys):
    overrides = [f"{key}={value!r}".replace("'", '"') for key, value in {"slab.log10_r": log10_r, **keys}.items()]
    return read("paper", overrides)


@pytest.mark.parametrize(
    ("log10_r", "transits", "psi", "tolerance", "allowed"),
    [
        (-2.68, 400, -4.5206736325264, 1e-10, 1e-12),
        (-2.68, 2000, -4.82021523090, 1e-10, 1e-10),
        (-2.68, 6000, -2.87971286869, 1e-10, 1e-10),
        (-2.30, 400, -1.50117901395, 1e-10, 2e-9),
    ],
)
@pytest.mark.parametrize("emit", [True, False])
def test_jump_start_reaches_the_converged_state(log10_r, transits, psi, tolerance, allowed, emit):
    solver = Delay(paper(log10_r, **JUMP), tolerance=tolerance, emit=emit)
    assert abs(follow(solver, transits).psi - psi) < allowed
    assert solver.failures == 0


def test_a_march_that_shows_its_end_only_shows_the_last_transit():
    every, end = Delay(paper(-2.6), nodes=8, steps=8), Delay(paper(-2.6), nodes=8, steps=8, emit=False)
    assert end.advance(40.0).time == pytest.approx(39.0 + np.arange(8) / 8)
    shown, wanted = end.advance(59.6), every.advance(59.6)
    assert end.time == pytest.approx(59.625)
    for name in ("time", "length", "z", "psi", "mu"):
        assert getattr(shown, name) == pytest.approx(getattr(wanted, name)[-5:], abs=1e-9)
    assert end.advance(60.0).time == pytest.approx([59.625, 59.75, 59.875])


def test_smooth_start_reaches_the_converged_state():
    solver = Delay(paper(-2.6))
    assert follow(solver, 600).psi == pytest.approx(-2.81740188949, abs=1e-9)


@pytest.mark.parametrize(
    ("log10_r", "period", "stress_drop", "elastic", "v_max", "v_min"),
    [
        (-2.69, 70.34210714, 0.1542893, 0.1424186, 3615.520, 4.299699),
        (-2.68, 73.4721449443, 0.1739634131, 0.1547375, 4412.3205, 2.860302),
    ],
)
def test_orbit_figures_of_the_independent_programs(log10_r, period, stress_drop, elastic, v_max, v_min):
    scene = paper(log10_r)
    solver = Delay(scene)
    observer = EventObserver(scene, solver.nodes)
    follow(solver, 5000, [observer])
    found = summarise(observer.events(3500.0))
    assert found.period.mean == pytest.approx(period, rel=2e-9)
    assert found.stress_drop.mean == pytest.approx(stress_drop, rel=3e-7)
    assert found.elastic_stress_drop.mean == pytest.approx(elastic, rel=4e-7)
    assert found.v_max == pytest.approx(v_max, rel=2e-7)
    assert found.v_min == pytest.approx(v_min, rel=2e-7)


def test_coarse_step_is_refined_not_nan():
    solver = Delay(paper(-2.3, **JUMP), nodes=5, steps=1, tolerance=1e-6)
    assert np.isfinite(follow(solver, 400).psi)
    assert solver.steps > 8


def test_unresolvable_run_is_refused_with_place_and_time(monkeypatch):
    monkeypatch.setattr("reduced.delay.alike.MAX_STEPS", 8)
    solver = Delay(paper(-2.3))
    with pytest.raises(NumericsError, match=r"delay: the step at t = .* transits"):
        follow(solver, 1e5)


def test_end_between_steps_is_read_from_the_polynomial():
    scene = paper(-2.6)
    whole, part = Delay(scene), Delay(scene)
    early = follow(part, 33.37)
    follow(whole, 33.0)
    late = follow(whole, 33.37)
    assert early.psi == pytest.approx(late.psi, abs=1e-11)
    assert part.time - 33.37 < 1.0 / part.steps


def test_an_end_that_rounding_just_misses_is_reached():
    solver = Delay(paper(-2.6))
    follow(solver, 20.0)
    solver.advance(20.0 + 1e-9)
    assert solver.time > 20.0


def test_unlike_slabs_are_refused_by_name():
    with pytest.raises(SceneError, match="alike"):
        Delay(read("grip"))
