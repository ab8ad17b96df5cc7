"""Kinds of stated errors, each with a truth: of motions that repeat, and of others, by long continuations."""

import math
from dataclasses import replace

import numpy as np

from fullwave.adapt import difference_of, probe
from reduced.orbit.closing import close
from reduced.orbit.periodic import figures_of
from slipwave.errors import NumericsError
from slipwave.observe.events import Events
from slipwave.observe.pieces import Array
from slipwave.observe.statistics import summarise
from slipwave.scene import Scene
from slipwave.solve import Solver, follow
from slipwave.solve.lyapunov import INTERVALS, largest_exponent
from tests.verification.order import richardson
from tests.verification.stated_errors.held import SLABS, Held, random_scene
from validation.models.build import build, build_full_wave, judged_grid, prepare
from validation.models.cycle import watch
from validation.models.orbits import find_orbit
from validation.models.settle import settle

WITNESS = "dg:9"
"""The reference model for viscous slabs."""

_FINER = 3.0
_DEFAULT, _LOOSEST, _TIGHTEST = 1e-8, 1e-4, 1e-10  # tolerances of orbits; four in ten have the default
_WITNESS_CELLS = 8
_EXACT = 1e-11
_SETTLED = 0.1  # of the tolerance: how closely cycles repeat
_GRIDS = {"fd": 1e-3, "sbp:2": 1e-3, "sbp:4": 1e-4, "sbp:6": 1e-5, "fem:4": 1e-6, "dg": 1e-6}  # asked for, and near them


def of_orbit(model: str, scene: Scene, random: np.random.Generator) -> list[Held]:
    """Figures of an orbit to a random tolerance, compared with those on a much finer mesh."""
    tolerance = _DEFAULT if random.random() < 0.4 else 10.0 ** random.uniform(math.log10(_TIGHTEST), math.log10(_LOOSEST))
    found = find_orbit(model, scene, tolerance).found
    flow, start = found.closed.flow.remeshed(found.closed.cycle, _FINER)
    truth = figures_of(close(flow, start, found.closed.cycle.period, 0.0))
    stated = {name: getattr(found.orbit, name).error for name in truth}
    return [Held(name, stated[name] / true, abs(found.orbit.values()[name] / true - 1.0)) for name, true in truth.items()]


def any_orbit(random: np.random.Generator) -> list[Held]:
    kind = str(random.choice(list(SLABS)))
    able = {"alike": ["delay", "kelvin-voigt", "block8", "modal:2"], "unlike": ["delay", "modal:1"], "viscous": ["sbp:6"]}
    model = str(random.choice(able.get(kind, ["delay"])))
    return of_orbit(model, random_scene(kind, model, random), random)


def _grid_scene(model: str, random: np.random.Generator) -> tuple[str, Scene]:
    kind = str(random.choice(["alike", "unlike", "layered", "grip", "viscous"]))
    viscous = kind == "viscous"
    return WITNESS if viscous else "delay", random_scene(kind, model if viscous else "auto", random)


def _exact(model: str, scene: Scene) -> Solver:
    return build_full_wave(model, scene, cells=_WITNESS_CELLS) if model == WITNESS else build(model, scene, tolerance=_EXACT)


def chosen_grid(random: np.random.Generator) -> list[Held]:
    """Periods and drops of the probe's cycles on a grid chosen by a tolerance."""
    model = str(random.choice(list(_GRIDS)))
    known, scene = _grid_scene(model, random)
    built = prepare(model, scene, tolerance=_GRIDS[model] * 10.0 ** random.uniform(-0.5, 0.5))
    assert built.choice is not None
    return [Held("cycles", built.choice.error_estimate, difference_of(probe(_exact(known, scene)), probe(built.solver)))]


def default_grid(random: np.random.Generator) -> list[Held]:
    """As `chosen_grid` on a default grid; a warning without a number states no error."""
    model = str(random.choice([*_GRIDS, "dg:7"]))
    known, scene = _grid_scene(model, random)
    solver = prepare(model, scene).solver
    choice = judged_grid(solver, solver.state())
    assert choice is not None
    if not math.isfinite(choice.error_estimate):
        return []
    return [Held("cycles", choice.error_estimate, difference_of(probe(_exact(known, scene)), probe(solver)))]


def steps(random: np.random.Generator) -> list[Held]:
    """The cycle on which a run of a model without a grid settles, compared with the orbit. The stated error of a cycle is the
    run's tolerance plus the remaining difference of its cycles."""
    kind = str(random.choice(["alike", "unlike", "layered", "grip"]))
    model = str(random.choice(["delay", "kelvin-voigt", "block8", "modal:2"] if kind == "alike" else ["delay"]))
    scene, tolerance = random_scene(kind, model, random), 10.0 ** random.uniform(-9.0, -4.0)
    settled = settle(build(model, scene, tolerance=tolerance), _SETTLED * tolerance)
    if settled.unrest > tolerance:
        raise NumericsError("the motion does not settle")
    truth = find_orbit(model, scene, _EXACT).found.orbit.values()
    found = {name: getattr(settled.orbit, name) for name in ("period", "stress_drop")}
    return [Held(name, tolerance + one.error / one.value, abs(one.value / truth[name] - 1.0)) for name, one in found.items()]


def limits_of_grids(random: np.random.Generator) -> list[Held]:
    """State and slip rate after a while, from three grids of order 2."""
    model, kind = str(random.choice(["fd", "sbp:2"])), str(random.choice(["alike", "unlike", "layered"]))
    scene = replace(random_scene(kind, "auto", random), until=float(random.integers(30, 90)))
    cells, cfl = int(random.integers(24, 64)), 0.5 if model == "fd" else None
    coarse, middle, fine = (_final(build_full_wave(model, scene, cells=n * cells, cfl=cfl)) for n in (1, 2, 4))
    truth = _final(build("delay", scene, tolerance=_EXACT))
    found = {name: (richardson(coarse[k], middle[k], fine[k], 2.0), truth[k]) for k, name in enumerate(("ln v", "psi"))}
    return [Held(name, one.error, abs(one.value - known)) for name, (one, known) in found.items()]


def _final(solver: Solver) -> tuple[float, float]:
    assert solver.scene.until is not None
    final = follow(solver, solver.scene.until)
    return final.ln_v, final.psi


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
        for name, margin in first.margins.items()
        if name in first.spreads
    ]


def exponents(random: np.random.Generator) -> list[Held]:
    """The largest Lyapunov exponent times the period, with its margin, compared with that of a longer continuation."""
    solver, period = irregular_motion(random)
    twin = build(solver.model, solver.scene, tolerance=_TOLERANCE)
    found, truth = (largest_exponent(solver, twin, period, intervals=count) for count in (INTERVALS, _TIMES * INTERVALS))
    certain = 1.0 / math.sqrt(1.0 + found.transits / truth.transits)
    return [Held("exponent", found.margin * period, certain * abs(found.rate - truth.rate) * period)]
