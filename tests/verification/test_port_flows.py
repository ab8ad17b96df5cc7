"""Reductions and grids over a period as differentiable maps: derivative against differences, motion against the run."""

from functools import partial

import numpy as np
import pytest

import slipwave
from fullwave.discontinuous import DiscontinuousGalerkin
from fullwave.finite_element import FiniteElement
from fullwave.summation_by_parts import SummationByParts
from reduced.impedance import reduction_of
from reduced.ode.slabs import ReducedModel
from slipwave.errors import NumericsError, SceneError
from slipwave.solve import follow
from tests.differences import difference, largest
from tests.reduced.reduction_equations import EVERY_TERM

STRONG = ["slab.epsilon=2e-3"]
"""Settings with which the motion of slabs acts on friction within a few transits."""

REDUCTIONS = {
    "kelvin-voigt": ("paper", STRONG),
    "modal:2": ("unlike", []),
    "block12": ("paper", STRONG),
    "quasidynamic": ("paper", STRONG),
    "fitted:3": ("viscous", STRONG),
    "fitted:4": ("machine", []),
    "made up": ("paper", STRONG),
}
SCENES = {
    "alike": ("paper", STRONG),
    "unlike": ("unlike", []),
    "kelvin-voigt solid": ("viscous", STRONG),
    "standard linear": ("paper", [*STRONG, 'slab.viscosity={kind="standard-linear", time=0.002, ratio=0.5}']),
    "machine": ("machine", []),
    "layered": ("layered", []),
}
GRIDS = {
    "dg:7": partial(DiscontinuousGalerkin, number=7, cells=2, time="exact", resolution=1e-11),
    "sbp:4": partial(SummationByParts, number=4, cells=12, time="exact", resolution=1e-11),
    "fem:4": partial(FiniteElement, number=4, cells=3, time="exact", resolution=1e-11),
}
CASES = [*(("reduced", name) for name in REDUCTIONS), *(("dg:7", name) for name in SCENES)]
OTHERS = [(grid, name) for grid in ("sbp:4", "fem:4") for name in ("alike", "unlike", "kelvin-voigt solid")]


def reduction_in(scene, name):
    return EVERY_TERM if name == "made up" else reduction_of(scene, name)


def solver_of(kind, name, tolerance=1e-11):
    scene = slipwave.read(*(REDUCTIONS if kind == "reduced" else SCENES)[name])
    return ReducedModel(scene, reduction_in(scene, name), tolerance) if kind == "reduced" else GRIDS[kind](scene)


def moving(kind, name, period=4.0):
    """The flow over `period` and the state of a run, moved a little in every direction."""
    solver = solver_of(kind, name)
    follow(solver, 9.0)
    flow, state = solver.flow(period, 1e-10)
    return flow.remeshed(flow.march(state + 1e-4 * np.sin(np.arange(1, state.size + 1)), period), 1.0)


@pytest.mark.parametrize(("kind", "name"), CASES)
def test_the_tangent_is_the_derivative_of_the_march(kind, name):
    flow, state = moving(kind, name)
    cycle = flow.march(state, 4.0)
    expected = difference(lambda change: flow.march(state + change, 4.0).end, flow.size)
    assert largest(flow.tangent(cycle) - expected) < 1e-7 * largest(expected)


@pytest.mark.parametrize(("kind", "name"), [*CASES, *OTHERS])
def test_the_flow_continues_the_run(kind, name):
    """From the state of a run to that of the same run later. Steady sliding stays."""
    solver = solver_of(kind, name)
    follow(solver, 20.0)
    begun, (flow, state) = solver.time, solver.flow(8.0, 1e-11)
    follow(solver, 28.0)
    period, later = solver.time - begun, solver.flow(8.0, 1e-9)[1]
    assert largest((flow.march(state, period).end - later) / np.maximum(1.0, np.abs(later))) < 1e-10
    assert largest(flow.march(flow.steady, period).end - flow.steady) < 1e-12


def test_a_motion_that_cannot_be_followed():
    scene = slipwave.read("paper")
    solver = ReducedModel(scene, reduction_of(scene, "quasistatic"))
    follow(solver, 9.0)
    with pytest.raises(NumericsError, match=r"quasistatic: the step at .* of 5000 transits cannot be solved"):
        solver.flow(5000.0, 1e-9)


def test_slabs_whose_grid_has_other_numbers_of_cells_need_another_flow():
    """Beyond twice the upper slab's round trip the lower one needs a fifth cell."""
    flow, _ = solver_of("dg:7", "unlike").flow(40.0, 1e-6)
    flow.of(slipwave.read("unlike", {"lower.r": 0.0048}))
    with pytest.raises(SceneError, match=r"^dg:7: its grid has other numbers of cells there \(\d+ values for \d+\); begin"):
        flow.of(slipwave.read("unlike", {"lower.r": 0.005}))
