"""Kinds of stated errors of motions that never repeat, each compared with a much longer continuation of the run."""

import math

import numpy as np

from slipwave.errors import NumericsError
from slipwave.observe.events import Events
from slipwave.observe.pieces import Array
from slipwave.observe.statistics import summarise
from slipwave.solve import Solver
from slipwave.solve.lyapunov import INTERVALS, largest_exponent
from tests.verification.stated_errors.held import Held
from tests.verification.stated_errors.scenes import random_scene
from validation.compute.build import build
from validation.measure.cycle import watch

_BEYOND = (1.15, 2.5)  # times the round trip at which steady sliding loses its stability: many motions never repeat there
_TOLERANCE = 1e-7
_TRANSIENT = 1500.0  # transits
_LEAST_SPREAD, _FEWEST = 1e-3, 6  # change of the periods, relative, and number of them, in motions that never repeat
_CYCLES = (16.0, 240.0)  # of a run: their range
_LONG = 1000  # cycles of the run that goes on
_TIMES = 3  # as many intervals in that of an exponent


def irregular_motion(random: np.random.Generator) -> tuple[Solver, float]:
    """A solver past its transient, in a motion that never repeats, and its mean period. Raises NumericsError if the motion
    repeats."""
    model = str(random.choice(["delay", "kelvin-voigt", "modal:2"]))
    solver = build(model, random_scene("alike", model, random, _BEYOND), tolerance=_TOLERANCE)
    period = watch(solver, 2.0 * _TRANSIENT).events(_TRANSIENT).period
    require_irregular(period)
    return solver, float(period.mean())


def require_irregular(periods: Array) -> None:
    """Raises NumericsError for cycles that repeat after some number of them, and for too few to decide."""
    repeats = [np.ptp(periods[lag:] - periods[:-lag]) < _LEAST_SPREAD * periods.mean() for lag in range(1, periods.size // 2)]
    if periods.size < _FEWEST or any(repeats):
        raise NumericsError("the motion repeats")


def irregular_means(random: np.random.Generator) -> list[Held]:
    """Means over the first cycles of a run, with their stated margins, compared with those over all later cycles."""
    solver, period = irregular_motion(random)
    cycles, begin = round(math.exp(random.uniform(*np.log(_CYCLES)))), solver.time
    events = watch(solver, begin + (cycles + _LONG) * period).events(begin)
    require_irregular(events.period[-_LONG // 10 :])
    return held_means(events, cycles)


def held_means(events: Events, count: int) -> list[Held]:
    """Means over the first `count` cycles, compared with those over the others."""
    first, rest = (summarise(Events(*(column[part] for column in events)), False) for part in (slice(count), slice(count, None)))
    certain = 1.0 / math.sqrt(1.0 + first.cycles / rest.cycles)
    return [
        Held(name, margin / getattr(rest, name).mean, certain * abs(getattr(first, name).mean / getattr(rest, name).mean - 1.0))
        for name, margin in vars(first.margins).items()
        if name in first.spreads
    ]


def exponents(random: np.random.Generator) -> list[Held]:
    """The largest Lyapunov exponent times the period, with its margin, compared with that of a longer continuation."""
    solver, period = irregular_motion(random)
    twin = build(solver.model, solver.scene, tolerance=_TOLERANCE)
    found, truth = (largest_exponent(solver, twin, period, intervals=count) for count in (INTERVALS, _TIMES * INTERVALS))
    certain = 1.0 / math.sqrt(1.0 + found.transits / truth.transits)
    return [Held("exponent", found.margin * period, certain * abs(found.rate - truth.rate) * period)]
