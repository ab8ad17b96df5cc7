"""Every model on its own orbit, with one cycle of it; some models as r grows; and what the orbits must show."""

import math
from collections.abc import Iterator
from typing import NamedTuple

import slipwave
from reduced.orbit import PeriodicOrbit, periodic_orbit
from reduced.orbit.approach import approach
from reduced.stability import analyse
from slipwave.errors import NumericsError
from slipwave.observe.statistics import Estimate, Orbit
from slipwave.scene import Scene
from validation.measure.cycle import Cycle
from validation.measure.settle import SYMBOLS, NoCycle, one_cycle
from validation.references.onset import onset_of
from validation.references.published import half_digit, reference_orbit
from validation.registry.orbits import moving
from validation.study import EXACT, WITNESS, Verdict, claim, holding, memo
from validation.study.over_r import begun_at, scene_at
from validation.study.text import plain

LOG10_R = -2.68
COMPARED = ("delay", "kelvin-voigt", "block12", "quasidynamic")
"""Models that are followed as r grows."""
IN_TURN = 6
"""Cycles of a run that are drawn where a model has no stable orbit."""

_CELLS, _CFL = 128, 0.5
_TOLERANCE = 1e-10
_MARGIN = 4.0  # transits shown on either side of a cycle
_UNTIL, _LONGEST = 10000.0, 130.0
_OURS = 9e-11  # beyond the digits of the others: the error of theirs
_WAVE = 5e-4  # leapfrog with these cells


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
        settled = memo.settled(model, scene, None, _TOLERANCE, cells=_CELLS, cfl=_CFL)
        return CycleRun(settled.orbit, one_cycle(settled, before=_MARGIN, after=_MARGIN, per_piece=2))
    found = memo.own_orbit(model, scene, _TOLERANCE)
    return CycleRun(found.orbit, memo.cycle_of(found.closed, _MARGIN, _MARGIN))


def at_r(model: str, log10_r: float) -> AtR | None:
    """The model's stable orbit, or a run if none is found; None if it comes back to steady sliding."""
    scene = scene_at(log10_r)
    if analyse(scene, model).stable:
        return None
    found = _stable_orbit(model, begun_at(log10_r))
    if found is not None:
        return AtR(found.orbit.period, found.orbit.stress_drop, [memo.cycle_of(found.closed, 0.0, 0.0)])
    period, drop, cycles = memo.means(model, scene, _UNTIL)
    return AtR(period, drop, memo.cycles_in_turn(model, scene, IN_TURN, _LONGEST), cycles)


def _stable_orbit(model: str, scene: Scene) -> PeriodicOrbit | None:
    """The orbit on which a run settles; None if its cycles keep changing."""
    guess = approach(moving(model, scene), _TOLERANCE)
    return periodic_orbit(*guess[:3], _TOLERANCE) if guess.settled else None


def what_stops(model: str, most: float) -> str:
    """What ends a run of `model` in the paper's scene: an error's message, `steady` sliding, or nothing."""
    try:
        memo.settled(model, slipwave.read("paper"), None, 1e-9, most)
    except NumericsError as failure:
        return str(failure).partition(" (scene")[0]
    except NoCycle:
        return "steady"
    return ""


def verdicts(runs: dict[str, CycleRun], quasistatic: str, quasidynamic: str) -> Iterator[Verdict]:
    """Every orbit against other programs' and the delay system's, and what stops the simplest models (`what_stops`)."""
    known = {model: reference_orbit(model, LOG10_R) for model in runs}
    yield from (_as_computed(model, runs[model].orbit.values(), figures) for model, figures in known.items() if figures)
    if "fd" in runs:
        off = max(abs(error(runs["fd"], runs["delay"], name)) for name in SYMBOLS)
        remark = f"leapfrog with {_CELLS} cells at CFL {_CFL}; the next study shows how the difference vanishes"
        yield claim("The full wave runs on the delay system’s orbit", WITNESS, off, _WAVE, remark)
    away = quasistatic not in ("", "steady")
    yield holding("The quasi-static model runs away", EXACT, "runs away", "runs away" if away else "goes on", away)
    scene = slipwave.read("paper")
    r_c = onset_of(scene.law, scene.upper.epsilon, scene.velocity).r_quasidynamic
    expected, ours = ("steady" if steady else "stick-slip" for steady in (scene.transit < r_c, quasidynamic == "steady"))
    remark = f"radiation damping: its onset, r = ε/(b − a − εV/2) = 10^{{{math.log10(r_c):.3f}}}, lies above this scene’s r"
    title = "The quasi-dynamic model slides steadily where the wave sticks and slips"
    yield holding(title, EXACT, expected, ours, ours == expected, f"earthquake modellers’ {remark}")


def _as_computed(model: str, ours: dict[str, float], known: dict[str, float]) -> Verdict:
    """Every value may differ by half of the last known digit and by the error of our own orbit."""
    off = {name: abs(ours[name] / value - 1.0) for name, value in known.items()}
    allowed = {name: half_digit(value) / abs(value) + _OURS for name, value in known.items()}
    worst = max(known, key=lambda name: off[name] / allowed[name])
    whose = "The exact orbit" if model == "delay" else "Reduced models’ orbits"
    remark = f"`{model}`: {', '.join(map(SYMBOLS.__getitem__, known))}; shown: {SYMBOLS[worst]}, the worst beside its digits"
    shown = f"{ours[worst]:.10g}, off by {plain(off[worst], '.0e')}"
    return claim(f"{whose} as computed by other programs", WITNESS, off[worst], allowed[worst], remark, shown)
