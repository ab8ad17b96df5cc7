"""Attacks on the full wave: steps past the limit, stiff friction, extreme scenes, noise at the grid scale."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

import numpy as np

import slipwave as sw
from slipwave.errors import NumericsError, SceneError
from validation.measure.cycle import Events, history_of
from validation.measure.limits import (
    ATTACKED,
    BEYOND,
    EXPLICIT,
    FEW_MEDIA,
    MEDIA,
    around_the_limit,
    limit_at,
    locked_noise,
    state_reach,
    stops_beyond,
)
from validation.report import WITNESS, Budget, StudyResult, Verdict, claim, every
from validation.report.compared import GOOD
from validation.report.grid_verdicts import limit_verdict, medium_verdict, noise_verdict, state_verdict, stop_verdict

NAME = "stability-attacks"
QUESTION = "Can extreme inputs make the full-wave solvers fail without a message?"
SCENES = ("paper", "unlike")
SECONDS = (16.0, 60.0)

RIGHT = "Extreme scenes end right or with a message, never silently wrong"
CURED = "A run that asks for more cells is right once it has them"

_ADVISED_UNTIL = 400.0  # transits
_FEWEST_CYCLES = 2
_FINEST = 16  # times the usual cells, at most

MOMENTS = (6.0, 8.0, 12.0, 20.0, 40.0)
"""Transits at which psi is compared."""

CELLS = {model: cells.fine for model, cells in ATTACKED.items()}
"""Cells of the faster slab for runs that are compared with the delay system."""


class _Attack(NamedTuple):
    """An extreme scene: its title, the scene and its changes, the refinement of its grids over CELLS, and the time (transits) of
    the late motion."""

    title: str
    scene: str
    changes: tuple[str, ...]
    finer: int = 1
    late: float = 400.0


_GRIDS = {4: (2, 400.0), 5: (4, 200.0), 6: (1, 200.0)}
"""Power of ten of V -> refinement of the grids, and late time."""

_PI = ("upper.r=2e-3", f"lower.r={2e-3 * math.pi:.17g}")
ATTACKS = {
    **{f"epsilon {n}": _Attack(f"ε = 10^{{{n}}}", "paper", (f"slab.epsilon=1e{n}",)) for n in (-9, -4, -2, 2)},
    **{
        f"V {n}": _Attack(f"V = 10^{{{n}}} V*", "paper", (f"drive.velocity=1e{n}",), *_GRIDS.get(n, (1, 400.0)))
        for n in (-6, -2, 3, 4, 5, 6)
    },
    "impedance": _Attack("impedances 1 : 1000", "unlike", ("upper.epsilon=2.8e-5", "lower.epsilon=2.8e-2")),
    "round trip": _Attack("round trips 1 : 50", "unlike", ("upper.r=2e-4", "lower.r=1e-2"), late=200.0),
    "pi": _Attack("round trips 1 : π", "unlike", _PI),
    "jump": _Attack("jump of 5 in ψ at t = 0", "paper", ("start.kind=jump", "start.size=5")),
    "jump back": _Attack("jump of −5 in ψ at t = 0", "paper", ("start.kind=jump", "start.size=-5"), late=800.0),
}
"""The most extreme scenes that still make sense."""


def run(budget: Budget) -> StudyResult:
    """Step limits over eight decades of stiffness and over media, extreme scenes, and noise in a locked slab."""
    decades = budget.plan(quick=(-4, 0, 2, 4, 8), full=(-4, -2, *range(9)))
    steps = {model: {decade: limit_at(model, decade) for decade in decades} for model in budget.each(CELLS, 0.2)}
    media, transits = budget.plan(quick=FEW_MEDIA, full=tuple(MEDIA)), budget.plan(quick=1e3, full=2e4)
    around = {medium: {model: around_the_limit(model, medium) for model in CELLS} for medium in budget.each(media, 0.4, 0.2)}
    attacks = {name: _attack(name, late=not budget.quick) for name in budget.each(ATTACKS, 0.8, 0.4)}
    advice = {model: advised(model) for model in budget.plan(quick=["sbp:4", "fem:4", "dg:3"], full=[*CELLS])}
    verdicts = (
        *map(limit_verdict, steps, steps.values()),
        *map(medium_verdict, around, around.values()),
        *(state_verdict(model, state_reach(model)) for model in CELLS),
        stop_verdict({model: stops_beyond(model, BEYOND) for model in CELLS}),
        *(_attack_verdict(name, outcomes) for name, outcomes in attacks.items()),
        _advice_verdict(advice),
        *(noise_verdict(model, locked_noise(model, transits), transits) for model in budget.each(CELLS, 1.0, 0.8)),
    )
    return StudyResult(
        answers={
            answer(steps, attacks): tuple(dict.fromkeys(verdict.claim for verdict in verdicts)),
        },
        verdicts=verdicts,
        notes=_NOTES,
    )


def answer(steps: Mapping[str, Mapping[int, float]], attacks: Mapping[str, Mapping[str, "_AttackOutcome"]]) -> str:
    """One sentence with the figures that matter."""
    stiff = [share for shares in steps.values() for decade, share in shares.items() if decade > 0]
    outcomes = [(name, outcome) for name, by_model in attacks.items() for outcome in by_model.values()]
    silent = sum(outcome.is_silently_wrong for _, outcome in outcomes)
    stopped = sum(bool(outcome.message) for _, outcome in outcomes)
    return (
        f"The step limit lies at {min(stiff):.2f} to {max(stiff):.2f} of the declared one however stiff friction is, and noise "
        f"never gains energy; of {len(outcomes)} attacks {len(outcomes) - stopped - silent} end right, {stopped} with a message, "
        f"{silent} silently wrong."
    )


_NOTES = (
    f"Attacks: the largest error of ψ up to t = {MOMENTS[-1]:g} and, in the full report, of the late motion, in any of the "
    f"{len(CELLS)} families, against the delay system; allowed are the {100 * GOOD:g} % that a good model of the first table may "
    "err by. Users cannot pass the step limit: cfl beyond 1 is refused before a run begins.",
)


@dataclass(frozen=True)
class _AttackOutcome:
    """Largest error of psi up to t = 40; `late` as `_late_error` gives it; the message of a run that stopped (empty if none did).
    Only a run that stops need not be right: counted failed solves do not suffice."""

    error: float
    late: float = 0.0
    message: str = ""

    @property
    def off(self) -> float:
        """The larger error; psi is the logarithm of the state, so that its error is a relative one."""
        return float(np.max((self.error, self.late)))

    @property
    def is_silently_wrong(self) -> bool:
        """Whether the run ended further off than a good model may be in the first table of the page."""
        return not self.message and not self.off <= GOOD


Trajectory: TypeAlias = tuple[np.ndarray, float, Events]
"""psi at the moments and at the end, and the cycles of the second half."""


def _attack(name: str, late: bool = False) -> dict[str, _AttackOutcome]:
    """The outcome of attack `name` for every family, in 40 transits or until its late time."""
    finer, until = ATTACKS[name].finer, ATTACKS[name].late if late else MOMENTS[-1]
    exact = _trajectory("delay", name, until, tol=1e-10)
    return {model: _outcome(model, finer * cells, exact, name, until) for model, cells in CELLS.items()}


def _trajectory(model: str, name: str, until: float, **options: Any) -> Trajectory:
    """Of a run with `options` of `slipwave.run`."""
    scene = sw.read(ATTACKS[name].scene, ATTACKS[name].changes)
    run = sw.run(scene, model, until=until, window=(MOMENTS[0], MOMENTS[-1]), rate=1.0, **options)
    history = history_of(run)
    assert run.done.final
    psis = np.interp(MOMENTS, history["time"], history["psi"])
    return psis, run.done.final.psi, run.records.watch.events(0.5 * until)


def _outcome(model: str, cells: int, exact: Trajectory, name: str, until: float) -> _AttackOutcome:
    try:
        ours = _trajectory(model, name, until, cells=cells, time=EXPLICIT[model])
    except (SceneError, NumericsError) as error:
        return _AttackOutcome(math.nan, message=str(error))
    off = np.abs(ours[0] - exact[0]).max()
    return _AttackOutcome(off, _late_error(ours, exact) if until > MOMENTS[-1] else 0.0)


def _late_error(ours: Trajectory, exact: Trajectory) -> float:
    """Error of psi at the end or, if that is less, the largest relative error of the mean period, stress drop and v_max of the
    second half's cycles: an orbit may be right while its phase has drifted."""
    (_, late, cycles), (_, known, others) = ours, exact
    of_state = abs(late - known)
    if min(cycles.time.size, others.time.size) < _FEWEST_CYCLES:
        return of_state
    mine, theirs = (
        np.array([events.period.mean(), events.stress_drop.mean(), events.v_max.max()]) for events in (cycles, others)
    )
    return min(of_state, float(np.abs(mine / theirs - 1.0).max()))


def _attack_verdict(name: str, by_model: Mapping[str, _AttackOutcome]) -> Verdict:
    """Whether an attack ended right or with a message in every model."""
    ended = [attack.off for attack in by_model.values() if not attack.message]
    silent = [model for model, attack in by_model.items() if attack.is_silently_wrong]
    stopped = len(by_model) - len(ended)
    remark = ATTACKS[name].title + (f"; silently wrong: {', '.join(silent)}" if silent else "")
    if not ended:
        return every(RIGHT, WITNESS, stopped, len(by_model), remark, "with a message")
    remark += f"; {stopped} of {len(by_model)} with a message" if stopped else ""
    return claim(RIGHT, WITNESS, np.max(ended), GOOD, remark)


def advised(model: str) -> tuple[int, float]:
    """Run V = 1e5 with `model`'s usual cells, doubled as long as the run stops with a message: how many cells it had when it last
    stopped (0 if it never did), and the error of psi of the run that ended, infinite if none did."""
    exact, stopped, cells = _trajectory("delay", "V 5", _ADVISED_UNTIL, tol=1e-10), 0, CELLS[model]
    while cells <= _FINEST * CELLS[model]:
        outcome = _outcome(model, cells, exact, "V 5", _ADVISED_UNTIL)
        if not outcome.message:
            return stopped, max(outcome.error, abs(outcome.late))
        stopped, cells = cells, 2 * cells
    return stopped, math.inf


def _advice_verdict(advice: Mapping[str, tuple[int, float]]) -> Verdict:
    """Whether more cells cured the runs that asked for them."""
    right = sum(error <= GOOD for _, error in advice.values())
    asked = f"{sum(stopped > 0 for stopped, _ in advice.values())} of {len(advice)} families asked"
    remark = f"ψ to {100 * GOOD:g} %, V = 10^{{5}} V*, {_ADVISED_UNTIL:g} transits; {asked}"
    return every(CURED, WITNESS, right, len(advice), remark, "families")
