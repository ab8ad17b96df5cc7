"""Orbits of every reduction and of the delay system, means where no orbit is stable, and the errors of both over r."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from reduced.impedance import reduction_of
from slipwave.errors import NumericsError
from slipwave.observe.pieces import Array
from slipwave.observe.statistics import Estimate
from validation.measure.correlated import mean_of
from validation.measure.cycle import watch
from validation.references.onset import onset_of
from validation.registry.build import build
from validation.run.timing import timed
from validation.study.memo import late_cycles, own_orbit
from validation.study.over_r import begun_at, scene_at

MODELS = ("block12", "block8", "kelvin-voigt", "modal:1", "modal:2", "modal:4", "modal:8")
DAMPED = "quasidynamic"
"""Slides steadily up to an onset of its own, and has a stable orbit beyond."""
SHOWN = (-2.69, -2.68, -2.66)
"""log10 r of the table of orbits."""

TOLERANCE = 1e-9
TIMED, TIMED_AT = 1000.0, -2.68
"""Transits that are timed, and log10 r there."""


class Figures(NamedTuple):
    """Period and stress drop with their errors: of an orbit those of its computation, of a mean its standard error."""

    period: Estimate
    drop: Estimate


Runs = dict[str, dict[float, Figures | None]]
"""model -> log10 r -> its orbit, or its mean; None where it found none."""


def orbit_of(model: str, log10_r: float) -> Figures | None:
    """The model's own orbit by Newton's method; None if it has none."""
    try:
        orbit = own_orbit(model, begun_at(log10_r), TOLERANCE).orbit
    except NumericsError:
        return None
    return Figures(orbit.period, orbit.stress_drop)


def mean_at(model: str, log10_r: float, until: float) -> Figures:
    """Means over the cycles of a run of so many transits, its transient left out."""
    cycles = late_cycles(model, scene_at(log10_r), until)
    return Figures(mean_of(cycles.period), mean_of(cycles.stress_drop))


def onset_of_damped() -> float:
    """log10 r from which on the quasi-dynamic model sticks and slips, by its closed form."""
    scene = scene_at(SHOWN[0])
    return math.log10(onset_of(scene.law, scene.upper.epsilon, scene.velocity).r_quasidynamic)


def milliseconds_of(model: str) -> float:
    """Processor time of the transits that are timed."""
    return 1e3 * timed(lambda: watch(build(model, scene_at(TIMED_AT), tolerance=TOLERANCE), TIMED))[0]


def error(runs: Runs, model: str, log10_r: float, quantity: str) -> Estimate:
    """Signed relative error of `period` or `drop` against the delay system; NaN where either has none."""
    ours, exact = runs[model].get(log10_r), runs["delay"].get(log10_r)
    if ours is None or exact is None:
        return Estimate(math.nan, math.nan)
    one, other = getattr(ours, quantity), getattr(exact, quantity)
    ratio = one.value / other.value
    return Estimate(ratio - 1.0, ratio * math.hypot(one.error / one.value, other.error / other.value))


def column(runs: Runs, model: str, quantity: str, part: Callable[[Estimate], float]) -> Array:
    """A part of the errors of `model` at every r of the delay system."""
    return np.array([part(error(runs, model, log10_r, quantity)) for log10_r in runs["delay"]])


def sizes(runs: Runs, model: str, quantity: str) -> Array:
    """Absolute errors of `model` at every r of the delay system."""
    return np.abs(column(runs, model, quantity, lambda one: one.value))


def states(model: str) -> int:
    """Dynamical variables: psi, the elastic stress, v if there is mass, and two for each mode."""
    scene = reduction_of(scene_at(TIMED_AT), model)
    return 2 + (not scene.is_algebraic) + 2 * len(scene.frequencies) + len(scene.relaxations)
