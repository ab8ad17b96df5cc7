"""Settled orbits of every reduction and their errors against the delay system's, over r."""

import math
from typing import NamedTuple

import numpy as np

import slipwave
from reduced.impedance import reduction_of
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from validation.measure.settle import NoCycle, settle
from validation.registry.build import build

MODELS = ("block12", "block8", "kelvin-voigt", "modal:1", "modal:2", "modal:4", "modal:8")
SHOWN = (-2.69, -2.68, -2.66)
"""log10 r of the table."""

MOST = 9000.0
"""Transits after which an orbit must have settled."""

RESTLESS = 1e-6
"""An orbit whose cycles still differ by more, relative, is not compared."""


class ModelRun(NamedTuple):
    """A model's settled figures at one r, and milliseconds of processor time per 1000 transits."""

    period: float
    drop: float
    milliseconds: float


Runs = dict[str, dict[float, ModelRun | None]]
"""model -> log10 r -> its orbit; None where it found none."""


def scene_at(log10_r: float) -> Scene:
    """The paper's scene at another r."""
    return slipwave.read("paper", {"slab.log10_r": log10_r})


def orbit_of(model: str, log10_r: float) -> ModelRun | None:
    """The settled orbit, None if there is none or it has not settled."""
    try:
        found = settle(build(model, scene_at(log10_r), tolerance=1e-10), tolerance=1e-9, most=MOST)
    except NoCycle:
        return None
    if found.unrest >= RESTLESS:
        return None
    return ModelRun(found.orbit.period.value, found.orbit.stress_drop.value, 1e6 * found.seconds / found.transits)


def error(runs: Runs, model: str, log10_r: float, quantity: str) -> float:
    """Signed relative error of `period` or `drop` against the delay system; NaN where either has no orbit."""
    ours, exact = runs[model].get(log10_r), runs["delay"].get(log10_r)
    if ours is None or exact is None:
        return math.nan
    return float(getattr(ours, quantity) / getattr(exact, quantity) - 1.0)


def curves(runs: Runs) -> dict[str, tuple[Array, Array, Array]]:
    """By model: log10 r, absolute errors of period and drop."""
    grid = np.array(list(runs["delay"]))
    sizes = {model: np.abs([[error(runs, model, x, name) for x in grid] for name in ("period", "drop")]) for model in MODELS}
    return {model: (grid, *both) for model, both in sizes.items()}


def states(model: str) -> int:
    """Dynamical variables: psi, the elastic stress, v if there is mass, and two for each mode."""
    scene = reduction_of(scene_at(-2.68), model)
    return 2 + (not scene.is_algebraic) + 2 * len(scene.frequencies) + len(scene.relaxations)
