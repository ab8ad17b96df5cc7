"""The snake of folds in the (r, T) plane, its pairs of folds, its windows of stability, and orbits that coexist."""

import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from reduced.continuation.special import Special
from reduced.orbit.closing import Closed
from reduced.orbit.figures import figures_of
from reduced.orbit.multipliers import count_unstable, floquet
from validation.studies.bifurcation.shown import draw_branch, draw_special, special_keys
from validation.studies.bifurcation.waves import COMPARED
from validation.studies.snaking.beside import Side
from validation.studies.snaking.runs import Attractor, Run
from validation.study import Cell, Table, table
from validation.study.drawing import WIDTH, Drawing, canvas, ruled
from validation.study.over_r import Branch, Corner, column, parts
from validation.study.text import plain

_LEAST = 74.0
"""Period (transits) from which the branch is shown."""

_RUNS: dict[str, Any] = {"color": "#d55e00", "capsize": 3.0, "linestyle": "none", "markerfacecolor": "none"}


def fold_pairs(branch: Branch) -> list[tuple[Special, Special]]:
    """Folds after the first, two by two: where the branch turns to smaller r, and where it turns back."""
    folds = branch.of_kind("LP")[1:]
    return list(zip(folds[::2], folds[1::2], strict=False))


def pair_table(branch: Branch) -> Table:
    """Each pair of folds with its distance from the one before."""
    pairs, rows = fold_pairs(branch), list[tuple[Cell, ...]]()
    for n, (turn, back) in enumerate(pairs):
        period, before = turn.point.closed.cycle.period, pairs[n - 1][0].point.closed.cycle.period
        rows.append(
            (
                turn.point.parameter,
                period,
                back.point.parameter,
                back.point.closed.cycle.period,
                turn.point.parameter - back.point.parameter,
                period - before if n else None,
            )
        )
    heading = (
        "turns at [log_{10} r] .9f | T [transits] .5f | back at [log_{10} r] .9f | T [transits] .5f | width [log_{10} r] .2e "
        "| T since the pair before [transits] .3f"
    )
    return table("pairs", "Pairs of folds along the branch; the last column is the growth of T from pair to pair.", heading, rows)


def window_table(corners: list[Corner]) -> Table:
    """Parts of the branch whose orbits are stable."""
    rows = []
    for stable, part in parts(corners):
        if stable and part[-1].figures["period"] > _LEAST:
            ends = sorted([part[0].log10_r, part[-1].log10_r])
            rows.append((part[0].figures["period"], part[-1].figures["period"], *ends, ends[1] - ends[0]))
    heading = "T from [transits] .4f | to [transits] .4f | log_{10} r from .7f | to .7f | width [log_{10} r] .2e"
    return table("windows", "Parts of the branch with stable orbits, in order along the branch.", heading, rows)


def coexisting_table(found: dict[float, list[Closed]]) -> Table:
    """All orbits of the branch at each r."""
    rows = [_coexisting_row(log10_r, closed) for log10_r, orbits in found.items() for closed in orbits]
    heading = "log_{10} r .2f | T [transits] .7f | Δμ [σ] .7f | Δy [σ] .7f | unstable .0f | largest multiplier"
    return table(
        "coexisting", "Orbits of the branch that coexist at one r; unstable: multipliers outside the unit circle.", heading, rows
    )


def _coexisting_row(log10_r: float, closed: Closed) -> tuple[Cell, ...]:
    lead, found = floquet(closed.monodromy)[0][0], figures_of(closed)
    multiplier = plain(lead.real, ".4f") + (f" ± {plain(abs(lead.imag), '.4f')} i" if lead.imag else "")
    return (log10_r, *(found[name] for name in COMPARED), float(count_unstable(closed)), multiplier)


def beside_table(both: Iterable[tuple[Special, Side, Side]]) -> Table:
    """The multiplier that passes at each special point, on both sides of it, from the orbit and from runs."""
    rows = [
        (
            one.kind,
            one.point.parameter,
            *(cell for side in sides for cell in (complex_text(side.orbit), abs(side.seen), side.apart)),
        )
        for one, *sides in both
    ]
    columns = "before: multiplier | modulus seen in runs .6f | difference [relative] .0e"
    heading = f"kind | log_{{10}} r .7f | {columns} | {columns.replace('before', 'beyond')}"
    caption = (
        "Direct runs on both sides of special points, each begun beside the next orbit of the branch, off by 1e-6 in the "
        "direction of the multiplier that passes."
    )
    return table("beside", caption, heading, rows)


def complex_text(value: complex) -> str:
    """A real multiplier, or a pair."""
    return plain(value.real, ".6f") + (f" ± {plain(abs(value.imag), '.6f')} i" if value.imag else "")


def attractor_table(attractors: Iterable[Attractor]) -> Table:
    """Runs from nudges of different size, and the orbits on which they settle."""
    rows = [(one.run.log10_r, one.size, float(one.run.last[-1]), one.orbit, one.apart) for one in attractors]
    heading = (
        "log_{10} r .3f | nudge .1f | T of the run [transits] .7f | T of the orbit [transits] .7f | difference [relative] .0e"
    )
    return table(
        "attractors",
        "Direct runs from nudges of different size, beside the stable orbit of the branch nearest to each.",
        heading,
        rows,
    )


def reappearance_table(closed: Closed, residuals: Mapping[int, float]) -> Table:
    """Where an orbit reappears."""
    period, r = closed.cycle.period, closed.flow.scene.transit
    rows = [
        (turns, math.log10(r * (1.0 + turns * period)), period / (1.0 + turns * period), off) for turns, off in residuals.items()
    ]
    caption = (
        "The orbit of log_{10} r = −2.68 put into slabs that are 1 + k T times as thick, where it has T/(1 + k T) transits: "
        "largest difference of ψ in a march over the period there."
    )
    return table("reappearance", caption, "k .0f | log_{10} r .6f | T [transits] .8f | difference of ψ .0e", rows)


def snake(branch: Branch, runs: Iterable[Run]) -> Drawing:
    """T over log10 r, with the periods of direct runs; beside it the number of unstable multipliers."""
    corners = [corner for corner in branch.corners if corner.figures["period"] > _LEAST]
    figure = canvas(WIDTH, 6.4)
    left, right = figure.subplots(1, 2, sharey=True, width_ratios=(4.0, 1.0))
    draw_branch(left, branch.model, corners, "period")
    draw_special(left, branch, "period")
    for run in runs:
        middle = 0.5 * (run.last.min() + run.last.max())
        left.errorbar([run.log10_r], [middle], [0.5 * np.ptp(run.last)], marker="o" if run.settled else "", **_RUNS)
    period, r = column(corners, lambda one: one.figures["period"]), column(corners, lambda one: one.log10_r)
    left.set(xlabel=r"$\log_{10} r$", ylabel="$T$ (transits)", ylim=(_LEAST, period.max()))
    left.set_xlim(r.min() - 0.002, r.max() + 0.002)
    right.step(column(corners, lambda one: float(one.unstable)), period, color="#111111", linewidth=1.0, where="pre")
    right.set(xlabel="count outside", xticks=(0, 1, 2))
    ruled(left, right)
    handles = [*special_keys(("LP", "NS")), *left.containers[:1]]
    labels = ["unstable", "fold", "torus point", "direct run, all its periods"]
    figure.legend(handles, labels, loc="outside upper left", ncols=4, handlelength=2.4)
    return figure
