"""The delay system's branch of orbits folds back and forth: evidence from two meshes and from runs near a torus point."""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from validation.chart import DOTTED, ORANGE, Chart, Look, Panel, Scale, Trace
from validation.chart.looks import model_look
from validation.chart.thin import staying
from validation.measure import memo
from validation.measure.over_r import Branch, branch_of, parts
from validation.report import Budget, Figure, StudyAnswer, StudyResult, Table, table
from validation.report.branch_drawing import branch_keys, branch_traces
from validation.report.numbers import numbered_period
from validation.report.text import minus
from validation.studies.snaking import measured
from validation.studies.snaking.measured import DirectRun, coexisting, grows, settles, sides

NAME = "snaking"
QUESTION = "How many orbits does the exact system have at one r, and which of them are stable?"
SCENES = ("paper",)
SECONDS = (12.0, 54.0)

_FINER, _SHORT = 1e-8, 0.01
_NUDGES = (0.5, 2.0)
"""Sizes of the nudges of runs that may end on different orbits."""

_BEFORE, _BEYOND = -2.659, -2.6565
"""log10 r of direct runs on both sides of the first torus point, where the branch has one orbit."""


class _Plan(NamedTuple):
    """Periods (transits) up to which the branch is followed, and its finer copy; log10 r at which coexisting orbits are listed,
    and at which runs may end on different ones; the first special point beside which runs begin, and the stride to the next."""

    longest: float
    finer: float
    shown: tuple[float, ...]
    coexist: tuple[float, ...]
    beside: tuple[int, int]


_QUICK = _Plan(78.5, 75.2, (-2.66,), (-2.66,), (1, 4))
_FULL = _Plan(85.0, 78.3, (-2.66, -2.65, -2.64, -2.63, -2.62), (-2.6655, -2.66, -2.6595), (0, 1))


def run(budget: Budget) -> StudyResult:
    """Follow the branch twice, list the orbits at some r, and run the delay system near the first torus point."""
    plan = budget.plan(_QUICK, _FULL)
    branch = branch_of("delay", -2.3, plan.longest)
    budget.report(0.5)
    finer = branch_of("delay", -2.3, plan.finer, _FINER, _SHORT)
    budget.report(0.9)
    orbits = {log10_r: branch.orbits_at(log10_r) for log10_r in plan.shown}
    starts = [(log10_r, size) for log10_r in plan.coexist for size in _NUDGES]
    before, *others, beyond = (
        measured.run_at(log10_r, size, branch.orbits_at(log10_r))
        for log10_r, size in ((_BEFORE, _NUDGES[0]), *starts, (_BEYOND, _NUDGES[0]))
    )
    return StudyResult(
        answers=_answers(branch, max(map(len, orbits.values()))),
        figures=(
            Figure("snake", _CAPTION, lambda: snake(branch, [before, beyond]), zoom=True, beside="orbits"),
            Figure("orbits", _ORBITS, lambda: _orbits_along(branch), zoom=True),
        ),
        tables=(_window_table(branch), measured.coexisting_table(orbits)),
        verdicts=(
            *measured.fold_claims(branch, finer),
            *settles([before, *others]),
            measured.wanders(beyond),
            grows(sides(branch, *plan.beside)),
            *coexisting(others),
            *measured.on_torus(*measured.torus_at(-2.65)),
        ),
        notes=(_WHY,),
        numbers={
            f"T at {log10_r:g}, orbit {n}": numbered_period(closed)
            for log10_r, found in orbits.items()
            for n, closed in enumerate(found, 1)
        },
    )


def _answers(branch: Branch, most: int) -> tuple[StudyAnswer, ...]:
    torus, last = branch.of_kind("NS")[0].point, branch.points[-1].closed.cycle.period
    return (
        StudyAnswer(
            f"The exact system has up to {most} orbits at one r. Its branch folds back and forth, with "
            f"{len(measured.fold_pairs(branch))} pairs of folds up to T = {last:.1f} transits; where two of its orbits are "
            "stable, the start decides.",
            ("Special points depend", "Folds come in pairs", "Two stable orbits coexist"),
        ),
        StudyAnswer(
            minus(
                f"Its orbits are stable up to a torus point at log_{{10}} r = {torus.parameter:.7f}, except between the folds of "
                "a pair; beyond it they are stable in short windows only."
            ),
            ("Before the first torus point", "Beyond the first torus point", "On both sides", "A run on the torus"),
        ),
    )


_CAPTION = (
    "Period T of the delay system’s orbits over r: the bifurcation diagram, enlarged. Thick and solid: stable; thin and dotted: "
    "unstable. Orange: periods of direct runs, with bars from the least to the largest: one settles, the other does not. "
    "Right: the number of multipliers outside the unit circle along the branch."
)
_ORBITS = (
    "Stress over one period of orbits along the branch, from its low end (below) to its high one, each raised above the one "
    "before. Solid: stable; dotted: unstable."
)
_WHY = (
    "Ripples of one transit decorate the cycle. As r grows, T grows, and a new ripple enters the cycle about once per transit of "
    "T; each time the branch turns to smaller r and back. Such snakes are known of other systems with long delays."
)

_ALONG, _RAISED, _POINTS = 24, 0.15, 400  # orbits, their distance, points of each
_LEAST = 74.0
"""Period (transits) from which the branch is shown."""


def _window_table(branch: Branch) -> Table:
    rows = []
    for stable, part in parts(branch.corners):
        if stable and part[-1].period > _LEAST:
            low, high = sorted([part[0].value, part[-1].value])
            rows.append((part[0].period, part[-1].period, low, high, high - low))
    heading = "T from [transits] .4f | to [transits] .4f | log_{10} r from .7f | to .7f | width [log_{10} r] .2e"
    return table("windows", "Parts of the branch with stable orbits, in order along the branch.", heading, rows)


def _orbits_along(branch: Branch) -> Chart:
    """The stress of some orbits in order along the branch, each offset by `_RAISED`."""
    points = [point for point in branch.points if point.closed.cycle.period > _LEAST]
    traces = []
    for k, n in enumerate(np.linspace(0, len(points) - 1, _ALONG).astype(int)):
        closed = points[n].closed
        cycle = memo.cycle_of(closed, 0.0, 0.0)
        name = minus(f"T = {closed.cycle.period:.3f}, log10 r = {points[n].parameter:.5f}")
        look = model_look("delay", dashes=DOTTED if points[n].unstable else "-", width=0.8)
        kept = staying(cycle.time, cycle.stress, _POINTS)
        traces.append(Trace(name, cycle.time[kept], cycle.stress[kept], look, shift=(0.0, _RAISED * k)))
    raised = rf"$\mu$, each orbit {_RAISED:g} above the one before"
    return Chart([Panel("", Scale("time since the slip event (transits)"), Scale(raised), traces)], 6.0)


def snake(branch: Branch, runs: Iterable[DirectRun]) -> Chart:
    """T over log10 r, with the periods of direct runs, and the number of unstable multipliers."""
    corners = [corner for corner in branch.corners if corner.period > _LEAST]
    periods, r = [one.period for one in corners], [one.value for one in corners]
    ends = np.array([(run.log10_r, run.last.min(), run.last.max()) for run in runs]).T
    middle, half = 0.5 * (ends[1] + ends[2]), 0.5 * (ends[2] - ends[1])
    seen = Trace("direct run, all its periods", ends[0], middle, Look(ORANGE, "", "o", hollow=True), y_error=half)
    outside = Trace("", [one.unstable or 0 for one in corners], periods, Look(kind="steps-pre", width=1.0))
    up = Scale("$T$ (transits)", limits=(_LEAST, max(periods)))
    across = Scale(r"$\log_{10} r$", limits=(min(r) - 0.002, max(r) + 0.002))
    panels = (
        Panel("", across, up, [*branch_traces(branch, "period"), seen], grid=True),
        Panel("", Scale("count outside", ticks={0.0: "0", 1.0: "1", 2.0: "2"}), up, [outside], grid=True),
    )
    keys = [*branch_keys(("LP", "NS")), seen]
    return Chart(panels, 6.4, 2, widths=(4.0, 1.0), legend="outside upper left", legend_columns=4, keys=keys)
