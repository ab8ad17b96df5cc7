"""Every model on its own orbit, with one cycle of it; and some models as r grows."""

from typing import NamedTuple

import slipwave
from reduced.orbit import PeriodicOrbit, periodic_orbit
from reduced.orbit.approach import approach
from reduced.stability import analyse
from slipwave.observe.statistics import Estimate, Orbit
from slipwave.scene import Scene
from validation.measure.correlated import mean_of
from validation.measure.cycle import Cycle
from validation.measure.settle import one_cycle, settle
from validation.registry.build import build
from validation.registry.orbits import moving
from validation.study.memo import cycle_of, cycles_in_turn, late_cycles, own_orbit
from validation.study.over_r import begun_at, scene_at

LOG10_R = -2.68
CELLS, CFL = 128, 0.5
COMPARED = ("delay", "kelvin-voigt", "block12", "quasidynamic")
"""Models that are followed as r grows."""

_TOLERANCE = 1e-10
_MARGIN = 4.0  # transits shown on either side of a cycle
_UNTIL, _LONGEST = 10000.0, 130.0
IN_TURN = 6
"""Cycles of a run that are drawn where a model has no stable orbit."""


class CycleRun(NamedTuple):
    """A model's orbit with errors of its computation, and one cycle of it."""

    orbit: Orbit
    cycle: Cycle


class AtR(NamedTuple):
    """A model at one r: period and stress drop of its stable orbit with its cycle or, where it has none, their means over so many
    `cycles` of a run with standard errors, and some of these cycles."""

    period: Estimate
    drop: Estimate
    drawn: list[Cycle]
    cycles: int = 0


def error(own: CycleRun, exact: CycleRun, quantity: str) -> float:
    """Relative error of `quantity` (a field of Orbit)."""
    return own.orbit.values()[quantity] / exact.orbit.values()[quantity] - 1.0


def run_model(model: str) -> CycleRun:
    """The orbit of `model` in the paper's scene: by Newton's method, but for the leapfrog, whose steps cannot be fractions of a
    period and which is run until it has settled."""
    scene = slipwave.read("paper")
    if model == "fd":
        settled = settle(build(model, scene, cells=CELLS, cfl=CFL), tolerance=_TOLERANCE)
        return CycleRun(settled.orbit, one_cycle(settled, before=_MARGIN, after=_MARGIN, per_piece=2))
    found = own_orbit(model, scene, _TOLERANCE)
    return CycleRun(found.orbit, cycle_of(found.closed, _MARGIN, _MARGIN))


def at_r(model: str, log10_r: float) -> AtR | None:
    """The model's stable orbit, or a run if none is found; None if it comes back to steady sliding."""
    scene = scene_at(log10_r)
    if analyse(scene, model).stable:
        return None
    found = _settled_orbit(model, begun_at(log10_r))
    if found is not None:
        return AtR(found.orbit.period, found.orbit.stress_drop, [cycle_of(found.closed, 0.0, 0.0)])
    events = late_cycles(model, scene, _UNTIL)
    drawn = cycles_in_turn(model, scene, IN_TURN, _LONGEST)
    return AtR(mean_of(events.period), mean_of(events.stress_drop), drawn, events.period.size)


def _settled_orbit(model: str, scene: Scene) -> PeriodicOrbit | None:
    """The orbit on which a run settles; None if its cycles keep changing."""
    known = moving(model, scene, _TOLERANCE)
    guess = approach(known.solver, known.freeze)
    return periodic_orbit(*guess[:3], _TOLERANCE) if guess.settled else None
