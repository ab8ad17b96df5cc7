"""Witnesses: method of lines against the delay system, the leapfrog against discontinuous Galerkin."""

import pytest
from order import extrapolated

import slipwave
from fullwave.discontinuous import DiscontinuousGalerkin
from fullwave.finite_difference import Leapfrog
from fullwave.finite_element import FiniteElement
from fullwave.summation_by_parts import SummationByParts
from reduced.delay.system import delay_system
from slipwave.observe import EventObserver
from slipwave.scene.slab import GripFace, Layer, MachineFace, ReflectingFace, StandardLinearViscosity
from slipwave.solve import follow
from tests.fullwave.grid_scenes import PAPER, ROUND_TRIP, SLAB, of
from tests.fullwave.grid_scenes import SCENES as OF_GRIDS

PERIOD = 73.4721449443
"""The paper's orbit at log10 r = -2.68 by Newton on the delay system: three meshes and a second program agree on these digits."""
STRESS_DROP, ELASTIC_DROP, V_MAX, V_MIN = 0.173963413156, 0.154737486111, 4412.32045802, 2.86030152897
"""Figures of the same orbit by the delay system at a tolerance of 1e-12."""


@pytest.mark.parametrize(
    ("kind", "options", "of_period", "of_drops", "of_rates"),
    [
        (DiscontinuousGalerkin, {"number": 7, "cells": 6, "time": "explicit"}, 1e-11, 1e-11, 2e-11),
        (DiscontinuousGalerkin, {"number": 7, "cells": 6, "time": "exact"}, 1e-12, 1e-11, 2e-11),
        (FiniteElement, {"number": 7, "cells": 6, "time": "explicit"}, 1e-10, 5e-10, 2e-8),
        (SummationByParts, {"number": 6, "cells": 48, "time": "explicit"}, 1e-8, 2e-6, 1e-6),
    ],
    ids=["dg", "dg exact", "fem", "sbp"],
)
def test_figures_of_the_papers_orbit(kind, options, of_period, of_drops, of_rates):
    """Measured: dg 4e-13, 4e-13, 8e-13; exact 3e-13, 2e-12, 6e-12; fem 8e-12, 3e-11, 1.3e-9; sbp 4.5e-10, 1.1e-7, 6.6e-8."""
    solver = kind(PAPER, **options)
    observer = EventObserver(PAPER, solver.nodes)
    follow(solver, 3000.0, [observer])
    events = observer.events()
    assert events.period[-1] == pytest.approx(PERIOD, rel=of_period)
    assert events.stress_drop[-1] == pytest.approx(STRESS_DROP, rel=of_drops)
    assert events.elastic_stress_drop[-1] == pytest.approx(ELASTIC_DROP, rel=of_drops)
    assert events.v_max[-1] == pytest.approx(V_MAX, rel=of_rates)
    assert events.v_min[-1] == pytest.approx(V_MIN, rel=of_rates)


SCENES = {
    "twice as thick": of({}, {"round_trip": 2 * SLAB.round_trip, "epsilon": 3 * SLAB.epsilon}),
    "incommensurate": of({}, {"round_trip": 2**0.5 * SLAB.round_trip, "epsilon": 3 * SLAB.epsilon}),
    "grips": of({"face": GripFace(2.0, 1.5)}),
    "one grip": of({"face": GripFace(2.0, 1.5)}, {"round_trip": 2**0.5 * SLAB.round_trip}),
    "grip below": of({}, {"face": GripFace(2.0, 1.5), "round_trip": 2**0.5 * SLAB.round_trip, "epsilon": 3 * SLAB.epsilon}),
    "layers below, on a grip": of(
        {}, {"layers": (Layer(0.4, 1.0), Layer(0.6, 2.0)), "face": GripFace(2.0, 1.5), "round_trip": 1.5 * SLAB.round_trip}
    ),
    "machines": of({"face": MachineFace(2.0, 0.5, 0.4)}),
    "machine below": of(
        {}, {"face": MachineFace(2.0, 1.5, 0.05), "round_trip": 2**0.5 * SLAB.round_trip, "epsilon": 3 * SLAB.epsilon}
    ),
    "machine on layers": of({"layers": (Layer(0.4, 1.0), Layer(0.6, 2.0)), "face": MachineFace(2.0, 0.0, 0.3)}),
    "masses under a dead load": of({"face": MachineFace(0.0, 0.5, 0.4)}, {"face": MachineFace(0.0, 0.0, 2.0)}),
    "reflecting": of({"face": ReflectingFace(0.9)}),
    "one absorbing": of({"face": ReflectingFace(0.0)}, {}),
    "layers": of({"layers": (Layer(0.4, 1.0), Layer(0.6, 2.0))}, {}),
    "three layers": of({"layers": (Layer(0.2, 1.0), Layer(0.3, 2.0), Layer(0.5, 0.6))}),
    "four layers below": of({}, {"layers": tuple(Layer(0.25, z) for z in (1.0, 3.0, 0.5, 2.0)), "epsilon": 2 * SLAB.epsilon}),
    **{law: slipwave.read(law, ["start.kind=nudge", "start.size=0.5"]) for law in ("slip-law", "regularised")},
    "grip on layers": of({"layers": (Layer(0.4, 1.0), Layer(0.6, 2.0)), "face": GripFace(2.0, 1.5)}),
}


@pytest.mark.parametrize("name", SCENES)
def test_final_state_agrees_with_the_delay_system(name):
    """Measured: 7e-13 in psi and ln v, 2e-14 in mu."""
    exact = follow(delay_system(SCENES[name], tolerance=1e-11), 150.0)
    final = follow(DiscontinuousGalerkin(SCENES[name], number=9, cells=6, time="explicit"), 150.0)
    assert (final.psi, final.ln_v) == (pytest.approx(exact.psi, abs=1e-11), pytest.approx(exact.ln_v, abs=1e-11))
    assert final.mu == pytest.approx(exact.mu, abs=4e-13)


LOSSY = {
    "epsilon": 5.6e-5,
    "round_trip": 1.5 * ROUND_TRIP,
    "face": GripFace(2.0, 1.5),
    "viscosity": StandardLinearViscosity(0.5 * ROUND_TRIP, 0.7),
}
SOME = ("unlike", "layers", "machine", "hung-machine", "kelvin-voigt", "standard-linear", "absorbing")
CASES = {name: OF_GRIDS[name] for name in SOME} | {"grip-and-loss-below": of({}, LOSSY)}


@pytest.mark.parametrize("name", CASES)
def test_two_discretisations_agree_to_ten_digits(name):
    coarse, fine = (follow(Leapfrog(CASES[name], cells, 0.9), 60.0) for cells in (320, 640))
    witness = follow(DiscontinuousGalerkin(CASES[name], number=7, cells=8, time="explicit"), 60.0)
    for quantity in ("psi", "ln_v", "mu"):
        ours = extrapolated(getattr(coarse, quantity), getattr(fine, quantity), 2)
        assert ours == pytest.approx(getattr(witness, quantity), abs=2e-10), quantity
