"""The leapfrog against a plain program, against itself in equivalent forms, and at its limits."""

import dataclasses
import math

import numpy as np
import pytest
from leapfrog_scenes import PAPER, SCENES, SLAB, of
from scipy.optimize import fsolve

from fullwave.finite_difference import Leapfrog
from slipwave.errors import NumericsError, SceneError
from slipwave.observe import EventObserver, summarise
from slipwave.scene.start import Start
from slipwave.solve import follow


@pytest.mark.parametrize("cells", [0, 1, -3, 2.5, 10**7, True, "64", float("nan")])
def test_wrong_cells_are_refused(cells):
    with pytest.raises(SceneError, match=r"cells = .*whole number from 2"):
        Leapfrog(PAPER, cells=cells)


@pytest.mark.parametrize("cfl", [0.0, -1.0, 1.0001, float("nan"), float("inf"), True, "1"])
def test_wrong_cfl_is_refused(cfl):
    with pytest.raises(SceneError, match=r"cfl = .*\(0, 1\]"):
        Leapfrog(PAPER, cfl=cfl)


def test_a_layer_thinner_than_a_cell_is_refused():
    scene = SCENES["layers"]
    with pytest.raises(SceneError, match="layer 1 is thinner than a cell; use at least 4"):
        Leapfrog(scene, cells=3)
    Leapfrog(scene, cells=4)


def plain_run(scene, cells, cfl, steps):
    """Alike rigid slabs by the scheme as one would write it on paper: rows (z, psi, mu)."""
    law, r, eps, V = scene.law, scene.transit, scene.upper.epsilon, scene.velocity
    dt = cfl * 0.5 / cells
    w, sigma, psi, z = np.full(cells + 1, V / 2), np.full(cells, scene.steady_stress), -math.log(V), math.log(V)
    rows = []
    for n in range(steps + 1):
        nudge = scene.start.nudge_size * math.exp(-((n * dt - 6.0) ** 2))

        def mismatch(x, w=w, sigma=sigma, psi=psi, nudge=nudge):
            mean_w, mean_psi = math.exp(x[0]) / 2, x[1]
            mu = law.a_star + law.a * x[0] + law.b * mean_psi
            momentum = eps / cfl * (mean_w - w[0]) - (sigma[0] - mu)
            return [momentum, mean_psi - psi - dt / 2 * (r * (math.exp(-mean_psi) - math.exp(x[0])) + nudge)]

        (z, mean_psi), _, _, _ = fsolve(mismatch, [z, psi], xtol=1e-14, full_output=True)
        rows.append((z, mean_psi, law.a_star + law.a * z + law.b * mean_psi))
        psi = 2 * mean_psi - psi
        w[0] = math.exp(z) - w[0]
        w[1:-1] += cfl / eps * np.diff(sigma)
        sigma = sigma + cfl * eps * np.diff(w)
    return np.array(rows)


@pytest.mark.parametrize("cfl", [1.0, 0.7])
def test_kernel_equals_the_plain_program(cfl):
    solver = Leapfrog(PAPER, cells=8, cfl=cfl)
    pieces = solver.advance(8.0)
    rows = plain_run(PAPER, 8, cfl, 4 * pieces.time.size)
    for column, values in enumerate((pieces.z, pieces.psi, pieces.mu)):
        ours = np.append(values[:, :-1].ravel(), values[-1, -1])
        assert np.abs(ours - rows[:, column]).max() < 2e-10
    assert np.ptp(rows[:, 0]) > 0.01


def test_one_slab_stands_for_two():
    together = of({}, {"epsilon": SLAB.epsilon * (1.0 + 4e-16)})
    assert not together.alike
    one, two = Leapfrog(PAPER, 32, 0.9), Leapfrog(together, 32, 0.9)
    assert two.total_cells == 2 * one.total_cells
    finals = [follow(solver, 150.0) for solver in (one, two)]
    assert finals[0].ln_v == pytest.approx(finals[1].ln_v, abs=1e-8)
    assert one.energy().input == pytest.approx(two.energy().input, rel=1e-10)


def test_steady_sliding_stays():
    solver = Leapfrog(dataclasses.replace(PAPER, start=Start(size=0.0)), 16)
    final = follow(solver, 50.0)
    assert final.ln_v == pytest.approx(math.log(100.0), abs=1e-11)
    assert solver.failures == 0


def test_yardstick_value():
    """Shared reference value at log10 r = -2.6, by other programs: psi(600) = -2.81740188949."""
    scene = dataclasses.replace(
        PAPER, upper=dataclasses.replace(SLAB, round_trip=10**-2.6), lower=dataclasses.replace(SLAB, round_trip=10**-2.6)
    )
    fine, coarse = (follow(Leapfrog(scene, cells, 1.0), 600.0).psi for cells in (360, 180))
    assert fine == pytest.approx(-2.81740188949, abs=3e-6)
    assert fine + (fine - coarse) / 3 == pytest.approx(-2.81740188949, abs=3e-9)


def test_orbit_of_the_paper():
    """Period and stress drop against the shared reference (delay system) from independent programs."""
    solver = Leapfrog(PAPER, 96, 1.0)
    events = EventObserver(PAPER, solver.nodes)
    follow(solver, 6000.0, [events])
    orbit = summarise(events.events(4000.0))
    assert orbit.period.mean == pytest.approx(73.4721449, rel=2e-5)
    assert orbit.stress_drop.mean == pytest.approx(0.1739634, rel=2e-5)
    assert orbit.elastic_stress_drop.mean == pytest.approx(0.1547375, rel=2e-5)
    assert orbit.v_max == pytest.approx(4412.32, rel=2e-4)
    assert solver.failures == 0


def test_numbers_without_bound_end_the_run_with_the_time():
    solver = Leapfrog(PAPER, 16)
    follow(solver, 5.0)
    state = solver.state()
    state["upper.stress"][3] = 1e308
    solver.restore(state)
    with pytest.raises(NumericsError, match=r"stopped being finite between t = 5"):
        follow(solver, 10.0)


def test_too_coarse_a_step_ends_the_run():
    """A round trip of many state relaxations: eight cells cannot follow psi through an event, 512 can."""
    scene = of({"epsilon": 1e-3, "round_trip": 1.0})
    with pytest.raises(NumericsError, match=r"did not converge by t = .*, the first at t = "):
        follow(Leapfrog(scene, 8), 100.0)
    solver = Leapfrog(scene, 512)
    follow(solver, 100.0)
    assert solver.failures == 0
