"""The delay system's branch of orbits folds back and forth: evidence from two meshes and from runs beside a torus point."""

from reduced.continuation.branch import Control
from validation.studies.snaking.beside import sides
from validation.studies.snaking.reappearance import in_thicker_slabs
from validation.studies.snaking.runs import attractor, run_at, torus_at
from validation.studies.snaking.shown import (
    attractor_table,
    beside_table,
    coexisting_table,
    fold_pairs,
    pair_table,
    reappearance_table,
    snake,
    window_table,
)
from validation.studies.snaking.verdicts import coexisting, grows, meshes, on_torus, once_per_transit, reappears, settles, wanders
from validation.study import Budget, Figure, Number, StudyResult
from validation.study.memo import own_orbit
from validation.study.over_r import Branch, branch_of, scene_at

NAME = "snaking"
QUESTION = "How many orbits does the exact system have at one r, and which of them are stable?"
SCENES = ("paper",)
SECONDS = (12.0, 54.0)

_LONGEST = {True: 78.5, False: 85.0}
_FINER_LONGEST = {True: 75.2, False: 78.3}
_FINER = 1e-8
_SHORT = Control(longest=0.01)
_SHOWN = {True: (-2.66,), False: (-2.66, -2.65, -2.64, -2.63, -2.62)}
"""log10 r at which coexisting orbits are listed."""

_COEXIST = {True: (-2.66,), False: (-2.6655, -2.66, -2.6595)}
_NUDGES = (0.5, 2.0)
"""log10 r and sizes of the nudges of runs that may end on different orbits."""

_SIDES = {True: (1, 4), False: (0, 1)}
"""The first special point beside which runs begin, and every which one after it."""

_BEFORE, _BEYOND = -2.659, -2.6565
"""log10 r of direct runs on both sides of the first torus point, where the branch has one orbit."""


def run(budget: Budget) -> StudyResult:
    """Follow the branch twice, list the orbits at some r, and run the delay system beside the first torus point."""
    branch = branch_of("delay", -2.3, _LONGEST[budget.quick])
    budget.report(0.5)
    finer = branch_of("delay", -2.3, _FINER_LONGEST[budget.quick], _FINER, _SHORT)
    budget.report(0.9)
    orbits = {log10_r: branch.orbits_at(log10_r) for log10_r in _SHOWN[budget.quick]}
    runs = [run_at(log10_r) for log10_r in (_BEFORE, _BEYOND)]
    starts = [(log10_r, size) for log10_r in _COEXIST[budget.quick] for size in _NUDGES]
    attractors = [attractor(log10_r, size, branch.orbits_at(log10_r)) for log10_r, size in starts]
    again = own_orbit("delay", scene_at(-2.68), 1e-11).closed
    residuals = {turns: in_thicker_slabs(again, turns, again.cycle.period) for turns in range(4)}
    both = sides(branch, *_SIDES[budget.quick])
    beside = [branch.orbits_at(log10_r)[-1] for log10_r in (_BEFORE, _BEYOND)]
    return StudyResult(
        answer=_answer(branch, max(map(len, orbits.values()))),
        figures=(Figure("snake", _CAPTION, lambda: snake(branch, runs)),),
        tables=(
            pair_table(branch),
            window_table(branch.corners),
            coexisting_table(orbits),
            beside_table(both),
            attractor_table(attractors),
            reappearance_table(again, residuals),
        ),
        verdicts=(
            *meshes(branch, finer),
            once_per_transit(branch),
            *settles(runs[0], beside[0]),
            wanders(runs[1], beside[1]),
            *grows(both),
            *coexisting(attractors),
            *on_torus(torus_at(-2.65)),
            reappears(residuals),
        ),
        notes=(_WHY,),
        numbers={
            f"T at {log10_r:g}, orbit {n}": Number(closed.cycle.period, 1e-8)
            for log10_r, found in orbits.items()
            for n, closed in enumerate(found, 1)
        },
    )


def _answer(branch: Branch, most: int) -> str:
    torus, last = branch.of_kind("NS")[0].point, branch.points[-1].closed.cycle.period
    return (
        f"Up to {most}, at the r shown. The branch folds back and forth, with {len(fold_pairs(branch))} pairs of folds up to "
        f"T = {last:.1f} transits. Its orbits are stable up to a torus point at log_{{10}} r = {torus.parameter:.7f}, except "
        "between the two folds of a pair; beyond it they are stable in short windows only."
    ).replace("= -", "= −")


_CAPTION = (
    "Period T of the delay system’s orbits over r: the bifurcation diagram, enlarged. Thick and solid: stable; thin and dotted: "
    "unstable. Orange: periods of direct runs; one settles (circle), the other does not (bar from the least to the largest). "
    "Right: the number of multipliers outside the unit circle along the branch."
)
_WHY = (
    "Ripples of one transit decorate the cycle. As r grows, T grows, and a new ripple enters the cycle about once per transit of "
    "T; each time the branch turns to smaller r and back. Such snakes are known of other systems with long delays."
)
