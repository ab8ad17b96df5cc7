"""The exact march of a grid: as the explicit one, gains no energy, ends on breaks, is right within its steps; its refusals."""

from types import SimpleNamespace

import numpy as np
import pytest
from grid_scenes import SCENES as OF_GRIDS

import slipwave
from fullwave.discontinuous import DiscontinuousGalerkin
from fullwave.finite_element import FiniteElement
from fullwave.lines import exact, march, propagator
from fullwave.lines.system import GRIP, SCALARS, Viscous
from fullwave.summation_by_parts import SummationByParts
from reduced.delay.system import delay_system
from slipwave.errors import NumericsError, SceneError
from slipwave.solve import follow
from slipwave.threads import one_thread

MANY = ("alike", "unlike", "grip", "machine", "absorbing", "layers", "kelvin-voigt", "standard-linear")
SCENES = {name: OF_GRIDS[name] for name in MANY}
SCENES |= {"jump": slipwave.read("paper", ["start.kind=jump", "start.size=0.05"]), "regularised": slipwave.read("regularised")}
MEMBERS = {
    "dg:7": (DiscontinuousGalerkin, {"number": 7, "cells": 4}),
    "fem:4": (FiniteElement, {"number": 4, "cells": 6}),
    "sbp:6": (SummationByParts, {"number": 6, "cells": 24}),
}


def solver_of(member, name, **options):
    kind, grid = MEMBERS[member]
    return kind(SCENES[name], **grid, **options)


OTHERS = [(member, name) for member in ("fem:4", "sbp:6") for name in ("unlike", "kelvin-voigt")]


@pytest.mark.parametrize(("member", "name"), [*(("dg:7", name) for name in SCENES), *OTHERS])
def test_both_marches_of_one_grid_agree(member, name):
    """At t = 50, in the stick after the first event. Measured: at most 3e-12 in psi and 1e-10 in ln v, after the jump 1e-10."""
    ends = [follow(solver_of(member, name, time=time), 50.0) for time in ("exact", "explicit")]
    allowed = 2e-9 if name == "jump" else 2e-10
    assert ends[0].psi == pytest.approx(ends[1].psi, abs=allowed)
    assert ends[0].ln_v == pytest.approx(ends[1].ln_v, abs=10.0 * allowed)


@pytest.mark.parametrize("name", SCENES)
def test_the_ledger_closes(name):
    """Elastic grids lose energy only by upwinding, which smooth motion does not feel; after a jump it is of first order."""
    solver = solver_of("dg:7", name, time="exact")
    assert solver.energy() is None
    solver.keep_ledger()
    follow(solver, 50.0)
    assert abs(solver.energy().residual) < (1e-7 if name == "jump" else 1e-13)


@pytest.mark.parametrize("name", ["alike", "unlike", "kelvin-voigt"])
def test_fields_inside_a_step_are_those_of_shorter_steps(name, monkeypatch):
    """A march whose steps are no longer than the time between two frames has the same fields at the ends of its steps."""
    shown = {}
    for longest in (1.0, 1.0 / 32.0):
        monkeypatch.setattr(exact, "LONGEST", longest)
        monkeypatch.setattr(exact, "_FIRST", min(longest, 0.125))
        solver = solver_of("dg:7", name, time="exact")
        frames = []
        if longest == 1.0:
            solver.keep_frames(1.0 / 32.0)
        while solver.time < 8.0:
            solver.advance(8.0 if longest == 1.0 else solver.time + 1e-6)  # one short step: the march itself leaves its end
            frames += solver.frames() if longest == 1.0 else [solver.snapshot()]
        shown[longest] = {round(32.0 * frame.time): frame for frame in frames if abs(32.0 * frame.time % 1.0) < 1e-9}
    common = sorted(set(shown[1.0]) & set(shown[1.0 / 32.0]))
    assert common == list(range(1, 257))
    for k in common:
        coarse, fine = shown[1.0][k], shown[1.0 / 32.0][k]
        np.testing.assert_allclose(coarse.upper.velocity, fine.upper.velocity, atol=2e-5, rtol=0.0)
        np.testing.assert_allclose(coarse.lower.stress, fine.lower.stress, atol=1e-9, rtol=0.0)


def energy_matrix(solver):
    """W of the energy q.W q of all marched slabs and their faces, in the layout of the explicit march."""
    system = solver.system
    weight = np.zeros((solver._march.layout.size,) * 2)
    for block in solver.grid.blocks:
        norm = np.diag(block.norm) if isinstance(block.norm, np.ndarray) else block.norm.toarray()
        norm = block.section.impedance * norm
        weight[np.ix_(block.velocity, block.velocity)] += norm
        relaxed, memory = 1.0, system.interface.size + SCALARS + block.stress
        if isinstance(system.medium, Viscous) and system.medium.rate[block.stress[0]] > 0.0:
            relaxed = 1.0 - float(system.medium.fraction[block.stress[0]])
            weight[np.ix_(memory, memory)] += norm / relaxed + norm / (1.0 - relaxed)
            weight[np.ix_(block.stress, memory)] -= norm / relaxed
            weight[np.ix_(memory, block.stress)] -= norm / relaxed
        weight[np.ix_(block.stress, block.stress)] += norm / relaxed
    for side in range(system.interface.sides):
        spring, load = system.tops.spring[side], system.interface.size + GRIP + side
        if spring > 0.0:
            weight[load, load] += system.traces.impedance[side - system.interface.sides] / spring
        if system.interface.heavy:
            weight[system.interface.heavy + side, system.interface.heavy + side] += system.tops.mass[side]
    return weight


STIFFNESSES = (0.0, 1e-6, 1e-2, 1.0, 1e2, 1e8, np.inf)
HARD = {
    "alike": [],
    "1 : 1000": ["upper.epsilon=2.8e-5", "upper.r=0.002", "lower.epsilon=2.8e-2", "lower.r=0.003"],
    "grip": ['slab.face={kind="grip", stiffness=1e4, impedance=1e-2}'],
    "machine": ['slab.face={kind="machine", stiffness=30.0, impedance=0.3, mass=0.02}'],
    "mass under a dead load": ['slab.face={kind="machine", stiffness=0.0, impedance=0.0, mass=2.0}'],
    **{f"reflection {share}": [f'slab.face={{kind="reflection", coefficient={share}}}'] for share in (0.9, 0.0, -1.0)},
    "layers": ["slab.layers=[{fraction=0.5, impedance=1.0}, {fraction=0.5, impedance=100.0}]"],
    "standard linear": ['slab.viscosity={kind="standard-linear", time=0.006, ratio=0.5}'],
    **{
        f"kelvin-voigt {time}": [f'slab.viscosity={{kind="kelvin-voigt", time={time}}}']
        for time in ("1e-10", "1e-7", "1e-5", "1e-3", "1.0")
    },
    "kelvin-voigt below 1 : 1000": [
        *("upper.epsilon=2.8e-5", "upper.r=0.002", "lower.epsilon=2.8e-2", "lower.r=0.003"),
        'lower.viscosity={kind="kelvin-voigt", time=1e-4}',
    ],
}


def hard_scene(name):
    return slipwave.read("unlike" if "1 : 1000" in name else "paper", HARD[name])


def worst_gain(solver, longest, levels):
    """Largest excess over 1 of the energy norm of the step coupled to friction with F_v = stiffness Z, relative to the rounding
    of the step's exponential, 10 eps |h L|."""
    slabs = solver._march.slabs
    weight = energy_matrix(solver)[np.ix_(slabs.slots, slabs.slots)]
    moves = weight.diagonal() > 0.0  # all but the loads of faces without a spring, which are 0 for ever
    factor = np.linalg.cholesky(weight[np.ix_(moves, moves)]).T
    port, n, worst = slabs.tables(longest)[1], slabs.remembered, -np.inf
    for level in levels:
        slabs.prepare(port, level)
        by_rate = port.change[level, port.values.size :][: exact.STAGES, :n].T
        step, free = port.change[level, :n, :n].T, port.free[level, :n].T
        for stiffness in STIFFNESSES:
            map_ = np.eye(n) + step
            if np.isfinite(stiffness):
                friction = stiffness * solver.scene.impedance * np.eye(exact.STAGES)
                map_ += by_rate @ np.linalg.solve(friction + port.impedance[level], free)
            norm = np.linalg.norm(factor @ map_[np.ix_(moves, moves)] @ np.linalg.inv(factor), 2)
            allowed = 10.0 * np.finfo(float).eps * float(port.length[level]) * np.linalg.norm(slabs.slabs.rates, 1)
            worst = max(worst, (norm - 1.0) / allowed)
    return worst


@pytest.mark.parametrize("name", HARD)
def test_the_coupled_step_never_gains_energy(name):
    """Steps of 1/64 to 40 transits. Measured: at most 0.05 of what rounding allows."""
    others = [MEMBERS[member] for member in ("fem:4", "sbp:6")] if name == "1 : 1000" else []
    with one_thread():
        for kind, grid in ((DiscontinuousGalerkin, {"number": 5, "cells": 3}), *others):
            solver = kind(hard_scene(name), **grid, time="exact")
            assert worst_gain(solver, 40.0, (0, 2, 5, 8)) < 1.0
            assert worst_gain(solver, 1.0, (0, 3, 6)) < 1.0


def test_any_slip_rate_and_a_long_hold():
    """V = 1e9 V*, while it is nudged, and an interface that nothing drives for 2000 transits: bounded without a step limit."""
    fast = slipwave.read("paper", ["drive.velocity=1e9", "start.size=0.01"])
    found, exact = (follow(one, 6.0) for one in (DiscontinuousGalerkin(fast, 5, 3, time="exact"), delay_system(fast)))
    assert exact.psi - fast.steady_psi > 1e-9
    assert found.psi == pytest.approx(exact.psi, abs=1e-13)  # equal
    assert found.mu == pytest.approx(exact.mu, abs=3e-11)  # 1e-12 measured
    held = DiscontinuousGalerkin(
        slipwave.read("paper", ["drive.velocity=[[0.0, 100.0], [10.0, 0.0], [20.0, 0.0]]"]), 3, 2, time="exact"
    )
    follow(held, 30.0)
    before = np.abs(held.snapshot().upper.velocity).max()
    follow(held, 2000.0)
    assert np.abs(held.snapshot().upper.velocity).max() <= 1.01 * before


FAR_RAMP = "drive.velocity=[[0.0, 100.0], [105.3, 100.0], [1211.17, 200.0]]"


@pytest.mark.parametrize("name", ["unlike", "unlike-irrational"])
def test_steps_end_on_breaks_far_apart_and_none_is_tiny(name):
    """The longest step between two breaks is no round number, and a break is a thousand steps away. Measured: at most 1e-13."""
    solver = DiscontinuousGalerkin(slipwave.read(name, [FAR_RAMP]), 5, 2, time="exact")
    ends, shortest = [], np.inf
    while solver.time < 1230.0:
        pieces = solver.advance(1230.0)
        ends.extend(pieces.time + pieces.length)
        shortest = min(shortest, pieces.length.min())
    travels = [0.5 * slab.round_trip / solver.scene.transit for slab in (solver.scene.upper, solver.scene.lower)]
    for arrival in (knot + delay for knot in (105.3, 1211.17) for delay in (0.0, *travels)):
        assert np.abs(np.array(ends) - arrival).min() < 2e-12
    assert shortest > 0.01


def test_a_motion_too_fast_for_every_step_is_refused(monkeypatch):
    monkeypatch.setattr(propagator, "LEVELS", 3)
    solver = DiscontinuousGalerkin(slipwave.read("paper", ["start.kind=jump", "start.size=3.0"]), 3, 2, time="exact")
    with pytest.raises(
        NumericsError, match=r"^dg:3: no step is short enough at t = 0 transits, v = .*, psi = [-.\d]+ \(scene 'paper'"
    ):
        follow(solver, 1.0)


@pytest.mark.parametrize(("gallery", "about"), [("paper", 121), ("viscous", 60), ("unlike", 45), ("layered", 121)])
def test_the_advised_number_of_cells_fits(gallery, about, monkeypatch):
    monkeypatch.setattr(march, "ExactMarch", lambda *arguments: SimpleNamespace(nodes=None, bookkeeping=None))
    scene = slipwave.read(gallery)
    for asked in (10_000, about + about // 10):
        with pytest.raises(SceneError) as refusal:
            DiscontinuousGalerkin(scene, 7, asked, time="exact")
        advised = int(str(refusal.value).partition("at most some ")[2].split()[0])
        assert advised == pytest.approx(about, rel=0.12)
        DiscontinuousGalerkin(scene, 7, advised, time="exact")
