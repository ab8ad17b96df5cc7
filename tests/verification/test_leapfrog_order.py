"""The leapfrog's declared order: 2 in every output from a smooth start at every Courant number, 1 after a jump.

The reference is its own limit, Richardson's from cfl 0.5 on finer grids: waves that disperse, so nothing is shared with the exact
transport of cfl 1 but the interface. Against the delay system: tests/validation.
"""

import dataclasses

import numpy as np
import pytest
from order import assert_order

import slipwave
from fullwave.finite_difference import Leapfrog
from slipwave.observe import EventObserver
from slipwave.scene.slab import GripFace, KelvinVoigtViscosity, Layer, StandardLinearViscosity
from slipwave.scene.start import Start, StartKind
from slipwave.solve import follow
from validation.measure.order_fit import extrapolated

CELLS = (54, 108, 216, 432)
STATE = ("ln_v", "psi", "mu")


def final_state(chosen, cells, cfl, until):
    final = follow(Leapfrog(chosen, cells, cfl), until)
    return np.array([final.ln_v, final.psi, final.mu])


def limit_of(chosen, until):
    coarse, fine = (final_state(chosen, cells, 0.5, until) for cells in (576, 1152))
    return np.array([extrapolated(a, b, 2) for a, b in zip(coarse, fine, strict=True)])


@pytest.fixture(scope="module")
def smooth():
    chosen = slipwave.read("paper", ["slab.log10_r=-2.6"])
    return chosen, {until: limit_of(chosen, until) for until in (100.0, 200.0)}


@pytest.mark.parametrize("until", [100.0, 200.0])
@pytest.mark.parametrize("cfl", [0.5, 0.9, 1.0])
def test_final_state_is_of_order_two(smooth, cfl, until):
    chosen, limits = smooth
    errors = np.abs([final_state(chosen, cells, cfl, until) - limits[until] for cells in CELLS])
    for name, column in zip(STATE, errors.T, strict=True):
        fit = assert_order(column, 1 / np.array(CELLS), 2, tolerance=0.1, absolute=1e-4)
        print(f"cfl {cfl} t {until} {name}: {fit}")


OUTPUTS = ("period", "stress_drop", "elastic_stress_drop", "v_max", "v_min")


def cycle(cells, cfl):
    """Outputs (rows) of the first two cycles of the run: the same transient for every grid."""
    chosen = slipwave.read("paper", ["slab.log10_r=-2.6"])
    solver = Leapfrog(chosen, cells, cfl)
    events = EventObserver(chosen, solver.nodes)
    follow(solver, 280.0, [events])
    found = events.events()
    assert found.time.size >= 2
    return np.array([getattr(found, name)[:2] for name in OUTPUTS])


@pytest.fixture(scope="module")
def cycle_limit():
    coarse, fine = (cycle(cells, 0.5) for cells in (432, 864))
    pairs = zip(coarse.ravel(), fine.ravel(), strict=True)
    return np.array([extrapolated(a, b, 2) for a, b in pairs]).reshape(coarse.shape)


@pytest.mark.parametrize("cfl", [0.5, 0.9, 1.0])
def test_every_output_is_of_order_two(cycle_limit, cfl):
    cells = (54, 81, 108, 162, 216)
    errors = np.sqrt([((cycle(n, cfl) / cycle_limit - 1) ** 2).mean(axis=1) for n in cells])
    for name, column in zip(OUTPUTS, errors.T, strict=True):
        fit = assert_order(column, 1 / np.array(cells), 2, tolerance=0.15, absolute=2e-4)
        print(f"cfl {cfl} {name}: {fit}")


JUMP = dataclasses.replace(slipwave.read("paper"), start=Start(StartKind.JUMP, 0.05))


@pytest.fixture(scope="module")
def jump_limit():
    coarse, fine = (final_state(JUMP, cells, 1.0, 60.0)[1] for cells in (1440, 2880))
    return extrapolated(coarse, fine, 1)


@pytest.mark.parametrize("cfl", [0.5, 0.9, 1.0])
def test_jump_start_is_of_order_one(jump_limit, cfl):
    """The jump comes back every transit (MODEL.md section 7): order 1 is what there is. Steps end on t at every level."""
    cells = (45, 90, 180, 360)
    errors = [abs(final_state(JUMP, n, cfl, 60.0)[1] - jump_limit) for n in cells]
    fit = assert_order(errors, 1 / np.array(cells), 1, tolerance=0.2, absolute=1e-5)
    print(f"jump cfl {cfl}: {fit}")


ROUND_TRIP = slipwave.read("paper").transit
DRESSED = {
    "unlike": [{}, {"epsilon": 8.4e-5, "round_trip": 2 * ROUND_TRIP}],
    "grip": [{"face": GripFace(2.0, 1.0)}],
    "layers": [{"layers": (Layer(0.25, 1.0), Layer(0.75, 3.0)), "face": GripFace(2.0, 1.0)}],
    "kelvin-voigt": [{"viscosity": KelvinVoigtViscosity(0.02 * ROUND_TRIP)}],
    "standard-linear": [{"viscosity": StandardLinearViscosity(3 * ROUND_TRIP, 0.5)}],
}


@pytest.mark.parametrize("name", DRESSED)
def test_every_slab_is_of_order_two(name):
    plain = slipwave.read("paper")
    upper = dataclasses.replace(plain.upper, **DRESSED[name][0])
    lower = dataclasses.replace(plain.upper, **DRESSED[name][-1])
    chosen = dataclasses.replace(plain, upper=upper, lower=lower)
    cells = (40, 60, 80, 120, 160)
    until = 60.0
    coarse, fine = (final_state(chosen, n, 0.5, until) for n in (320, 640))
    reference = np.array([extrapolated(a, b, 2) for a, b in zip(coarse, fine, strict=True)])
    errors = np.abs([final_state(chosen, n, 0.9, until) - reference for n in cells])
    for label, column in zip(STATE, errors.T, strict=True):
        fit = assert_order(column, 1 / np.array(cells), 2, tolerance=0.15, absolute=1e-5)
        print(f"{name} {label}: {fit}")
