"""The delay system's branch of orbits folds back and forth: evidence from two meshes and from runs near a torus point."""

import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from reduced.continuation.branch import Control
from reduced.orbit.closing import Closed
from reduced.orbit.figures import figures_of
from reduced.orbit.multipliers import count_unstable, floquet
from validation.chart.thin import staying
from validation.compute.points import BranchPoint
from validation.studies.snaking import measured
from validation.studies.snaking.measured import Attractor, FoldSide, PeriodsOfRun, Sides, coexisting, grows, settles, sides
from validation.study import Budget, Cell, Figure, StudyResult, Table, memo, table
from validation.study.branch_drawing import draw_branch, draw_special, special_keys
from validation.study.drawing import Drawing, ruled, style_of, subplots
from validation.study.over_r import COMPARED, Branch, branch_of, numbered_period, parts, scene_at
from validation.study.text import minus, plain

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
"""Quick report -> index of the first special point near which runs begin, and the stride to the next ones."""

_BEFORE, _BEYOND = -2.659, -2.6565
"""log10 r of direct runs on both sides of the first torus point, where the branch has one orbit."""


def run(budget: Budget) -> StudyResult:
    """Follow the branch twice, list the orbits at some r, and run the delay system near the first torus point."""
    branch = branch_of("delay", -2.3, _LONGEST[budget.quick])
    budget.report(0.5)
    finer = branch_of("delay", -2.3, _FINER_LONGEST[budget.quick], _FINER, _SHORT)
    budget.report(0.9)
    orbits = {log10_r: branch.orbits_at(log10_r) for log10_r in _SHOWN[budget.quick]}
    runs = [measured.run_at(log10_r) for log10_r in (_BEFORE, _BEYOND)]
    starts = [(log10_r, size) for log10_r in _COEXIST[budget.quick] for size in _NUDGES]
    attractors = [measured.attractor(log10_r, size, branch.orbits_at(log10_r)) for log10_r, size in starts]
    again = memo.own_orbit("delay", scene_at(-2.68), 1e-11).closed
    residuals = {turns: measured.in_thicker_slabs(again, turns, again.cycle.period) for turns in range(4)}
    both = sides(branch, *_SIDES[budget.quick])
    nearest = [branch.orbits_at(log10_r)[-1] for log10_r in (_BEFORE, _BEYOND)]
    return StudyResult(
        answer=_answer(branch, max(map(len, orbits.values()))),
        figures=(
            Figure("snake", _CAPTION, lambda: snake(branch, runs), zoom=True, beside="orbits"),
            Figure("orbits", _ORBITS, lambda: orbits_along(branch), zoom=True),
        ),
        tables=(
            _window_table(branch.corners),
            _coexisting_table(orbits),
            _sides_table(both),
            _attractor_table(attractors),
            _reappearance_table(again, residuals),
        ),
        verdicts=(
            *measured.fold_claims(branch, finer),
            *settles(runs[0], nearest[0]),
            measured.wanders(runs[1], nearest[1]),
            *grows(both),
            *coexisting(attractors),
            *measured.on_torus(measured.torus_at(-2.65)),
            measured.reappears(residuals),
        ),
        notes=(_WHY,),
        numbers={
            f"T at {log10_r:g}, orbit {n}": numbered_period(closed)
            for log10_r, found in orbits.items()
            for n, closed in enumerate(found, 1)
        },
    )


def _answer(branch: Branch, most: int) -> str:
    torus, last = branch.of_kind("NS")[0].point, branch.points[-1].closed.cycle.period
    pairs = len(measured.fold_pairs(branch))
    return (
        f"Up to {most}, at the r shown. The branch folds back and forth, with {pairs} pairs of folds up to "
        f"T = {last:.1f} transits. Its orbits are stable up to a torus point at log_{{10}} r = {torus.parameter:.7f}, except "
        "between the two folds of a pair; beyond it they are stable in short windows only."
    ).replace("= -", "= −")


_CAPTION = (
    "Period T of the delay system’s orbits over r: the bifurcation diagram, enlarged. Thick and solid: stable; thin and dotted: "
    "unstable. Orange: periods of direct runs; one settles (circle), the other does not (bar from the least to the largest). "
    "Right: the number of multipliers outside the unit circle along the branch."
)
_ORBITS = (
    "Stress over one period of orbits along the branch, from its low end (below) to its high one, each raised above the one "
    "before. Solid: stable; dotted: unstable."
)
_WHY = (
    "Ripples of one transit decorate the cycle. As r grows, T grows, and a new ripple enters the cycle about once per transit of "
    "T; each time the branch turns to smaller r and back. Such snakes are known of other systems with long delays. The study "
    "`bifurcation` lists r and T of every fold."
)

_ALONG, _POINTS, _RAISED = 24, 400, 0.15
_LEAST = 74.0
"""Period (transits) from which the branch is shown."""

_RUNS: dict[str, Any] = {"color": "#d55e00", "capsize": 3.0, "linestyle": "none", "markerfacecolor": "none"}


def _window_table(corners: list[BranchPoint]) -> Table:
    rows = []
    for stable, part in parts(corners):
        if stable and part[-1].period > _LEAST:
            low, high = sorted([part[0].value, part[-1].value])
            rows.append((part[0].period, part[-1].period, low, high, high - low))
    heading = "T from [transits] .4f | to [transits] .4f | log_{10} r from .7f | to .7f | width [log_{10} r] .2e"
    return table("windows", "Parts of the branch with stable orbits, in order along the branch.", heading, rows)


def _coexisting_table(found: dict[float, list[Closed]]) -> Table:
    rows = [_coexisting_row(log10_r, closed) for log10_r, orbits in found.items() for closed in orbits]
    heading = "log_{10} r .2f | T [transits] .7f | Δμ [σ] .7f | Δy [σ] .7f | unstable .0f | largest multiplier"
    caption = "Orbits of the branch that coexist at one r; unstable: multipliers outside the unit circle."
    return table("coexisting", caption, heading, rows)


def _coexisting_row(log10_r: float, closed: Closed) -> tuple[Cell, ...]:
    lead, found = floquet(closed.monodromy)[0][0], figures_of(closed)
    return (log10_r, *(found[name] for name in COMPARED), float(count_unstable(closed)), _complex_text(lead, ".4f"))


def _sides_table(both: Sides) -> Table:
    def cells(side: FoldSide) -> tuple[Cell, ...]:
        return _complex_text(side.orbit), abs(side.seen), side.apart

    rows = ((one.kind, one.point.parameter, *cells(before), *cells(beyond)) for one, before, beyond in both)
    columns = "before: multiplier | modulus seen in runs .6f | difference [relative] .0e"
    heading = f"kind | log_{{10}} r .7f | {columns} | {columns.replace('before', 'beyond')}"
    caption = (
        "Direct runs on both sides of special points, each begun near the next orbit of the branch, off by 1e-6 in the "
        "direction of the multiplier that passes."
    )
    return table("beside", caption, heading, rows)


def _complex_text(value: complex, spec: str = ".6f") -> str:
    return plain(value.real, spec) + (f" ± {plain(abs(value.imag), spec)} i" if value.imag else "")


def _attractor_table(attractors: Iterable[Attractor]) -> Table:
    rows = ((one.run.log10_r, one.size, float(one.run.last[-1]), one.orbit, one.apart) for one in attractors)
    heading = (
        "log_{10} r .3f | nudge .1f | T of the run [transits] .7f | T of the orbit [transits] .7f | difference [relative] .0e"
    )
    caption = "Direct runs from nudges of different size, and the stable orbit of the branch nearest to each."
    return table("attractors", caption, heading, rows)


def _reappearance_table(closed: Closed, residuals: Mapping[int, float]) -> Table:
    period, r = closed.cycle.period, closed.flow.scene.transit
    rows = [
        (turns, math.log10(r * (1.0 + turns * period)), period / (1.0 + turns * period), off) for turns, off in residuals.items()
    ]
    caption = (
        "The orbit of log_{10} r = −2.68 put into slabs that are 1 + k T times as thick, where it has T/(1 + k T) transits: "
        "largest difference of ψ in a march over the period there."
    )
    return table("reappearance", caption, "k .0f | log_{10} r .6f | T [transits] .8f | difference of ψ .0e", rows)


def orbits_along(branch: Branch) -> Drawing:
    """The stress of some orbits in order along the branch, each offset by `_RAISED`."""
    points = [point for point in branch.points if point.closed.cycle.period > _LEAST]
    raised = rf"$\mu$, each orbit {_RAISED:g} above the one before"
    figure, axes = subplots(6.0, 1, 1, "time since the slip event (transits)", raised)
    for k, n in enumerate(np.linspace(0, len(points) - 1, _ALONG).astype(int)):
        closed = points[n].closed
        cycle = memo.cycle_of(closed, 0.0, 0.0)
        chosen = staying(cycle.time, cycle.stress, _POINTS)
        label = minus(f"T = {closed.cycle.period:.3f}, log10 r = {points[n].parameter:.5f}")
        stable = count_unstable(closed) == 0
        look: Any = {"linestyle": "-" if stable else (0, (1.5, 1.2)), "linewidth": 0.8, "label": label}
        axes.plot(cycle.time[chosen], cycle.stress[chosen] + _RAISED * k, color=style_of("delay").color, **look)
    return figure


def snake(branch: Branch, runs: Iterable[PeriodsOfRun]) -> Drawing:
    """T over log10 r, with the periods of direct runs, and the number of unstable multipliers."""
    corners = [corner for corner in branch.corners if corner.period > _LEAST]
    figure, (left, right) = subplots(6.4, 1, 2, r"$\log_{10} r$", "$T$ (transits)", sharey=True, width_ratios=(4.0, 1.0))
    draw_branch(left, branch.model, corners, "period")
    draw_special(left, branch, "period")
    for run in runs:
        middle = 0.5 * (run.last.min() + run.last.max())
        left.errorbar([run.log10_r], [middle], [0.5 * np.ptp(run.last)], marker="o" if run.settled else "", **_RUNS)
    period, r = [one.period for one in corners], [one.value for one in corners]
    left.set(ylim=(_LEAST, max(period)), xlim=(min(r) - 0.002, max(r) + 0.002))
    right.step([one.unstable for one in corners], period, color="#111111", linewidth=1.0, where="pre")
    right.set(xlabel="count outside", xticks=(0, 1, 2))
    ruled(left, right)
    handles = [*special_keys(("LP", "NS")), *left.containers[:1]]
    labels = ["unstable", "fold", "torus point", "direct run, all its periods"]
    figure.legend(handles, labels, loc="outside upper left", ncols=4, handlelength=2.4)
    return figure
