"""The exact delay system against independent values, and starts and ends meant to break it."""

import numpy as np
import pytest

from reduced.delay.alike import Delay
from reduced.delay.network import DelayNetwork
from slipwave import read
from slipwave.errors import NumericsError
from slipwave.observe.pieces import empty_pieces
from slipwave.solve import follow
from slipwave.step.nodal import DONE

JUMP = {"start.kind": "jump", "start.size": 0.05}


def paper(log10_r, **keys):
    return read("paper", {"slab.log10_r": log10_r, **keys})


@pytest.mark.parametrize(
    ("log10_r", "start", "transits", "psi", "allowed"),
    [
        (-2.68, JUMP, 400, -4.5206736325264, 1e-12),
        (-2.68, JUMP, 2000, -4.82021523090, 1e-10),
        (-2.68, JUMP, 6000, -2.87971286869, 1e-10),
        (-2.30, JUMP, 400, -1.50117901395, 2e-9),
        (-2.60, {}, 600, -2.81740188949, 1e-9),
    ],
)
@pytest.mark.parametrize("emit", [True, False])
def test_the_converged_state_is_reached(log10_r, start, transits, psi, allowed, emit):
    solver = Delay(paper(log10_r, **start), tolerance=1e-10, emit=emit)
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


def test_a_rejected_step_takes_the_march_back_to_the_start_of_its_transit():
    rejected, whole = (Delay(paper(-2.3), nodes=6, steps=6, tolerance=1e-6) for _ in range(2))
    kept, verdict = rejected._march(400, empty_pieces(2400, 6))
    assert kept > 0
    assert verdict != DONE
    assert whole._march(kept, empty_pieces(6 * kept, 6)) == (kept, DONE)
    assert rejected.iterations > whole.iterations + 6  # some steps of its last transit were solved
    state, wanted = rejected.state(), whole.state()
    assert all(np.array_equal(state[name], wanted[name]) for name in ("incoming", "guess", "now"))


@pytest.mark.parametrize(
    ("march", "name", "keys"),
    [(Delay, "paper", ("slab",)), (DelayNetwork, "unlike", ("upper", "lower"))],
    ids=["alike", "network"],
)
def test_unresolvable_run_is_refused_with_place_and_time(march, name, keys, monkeypatch):
    monkeypatch.setattr(f"{march.__module__}.MAX_STEPS", 8)
    with pytest.raises(NumericsError, match=r"delay: the step at t = .* transits"):
        follow(march(read(name, {f"{key}.log10_r": -2.3 for key in keys})), 1e5)


def test_end_between_steps_is_read_from_the_polynomial():
    scene = paper(-2.6)
    whole, part = Delay(scene), Delay(scene)
    early = follow(part, 33.37)
    follow(whole, 33.0)
    late = follow(whole, 33.37)
    assert early.psi == pytest.approx(late.psi, abs=1e-11)
    assert part.time - 33.37 < 1.0 / part.steps


@pytest.mark.parametrize(("march", "name"), [(Delay, "paper"), (DelayNetwork, "unlike-irrational")])
def test_an_end_that_rounding_just_misses_is_reached(march, name):
    solver = march(read(name))
    follow(solver, 500.0)
    assert abs(solver.time - 500.0) < 0.5
    for just_beyond in (1e-12, 1e-9, 1e-7):
        before = solver.time
        solver.advance(before + just_beyond)
        assert solver.time > before
