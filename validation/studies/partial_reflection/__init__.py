"""Outer faces that reflect a part of each wave: grips, which keep the load, and bare coefficients, which leak it."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from slipwave.observe.pieces import Array
from validation.studies.partial_reflection import measured
from validation.studies.partial_reflection.measured import HELD, LOG10_R, LOG10_R_BARE, RESTLESS, UNTIL, Pair, Point, locks
from validation.study import Budget, Figure, Number, StudyResult, Table, table
from validation.study.drawing import Drawing, subplots
from validation.study.text import plain

NAME = "partial-reflection"
QUESTION = "What do outer faces that reflect only a part of each wave do to stick-slip?"
SCENES = ("paper",)
SECONDS = (5.0, 12.0)

STIFFNESSES = (1.0, 10.0)
_LEAKS = {
    True: (1e-5, 1e-3, 3e-3, 6e-3, 0.02, 0.1, 0.5),
    False: (1e-5, 1e-4, 3e-4, *(1e-3 * n for n in range(1, 9)), 0.01, 0.02, 0.05, 0.1, 0.15, 0.25, 0.5, 1.0),
}
"""By quick or full report: values of 1 - R."""
_SLOW_LEAKS = (0.05, 0.1, 0.15, 0.25, 0.5)  # 1 - R on both sides of locking


def run(budget: Budget) -> StudyResult:
    """Settle over the grip's impedance, lay the full wave over it, then lower a bare coefficient from 1."""
    grid = np.geomspace(0.01, 100.0, 9 if budget.quick else 17)
    orbits = {stiff: [measured.orbit_of(measured.grip_scene(stiff, z, LOG10_R)) for z in grid] for stiff in STIFFNESSES}
    budget.report(0.4)
    few = (0.1, 1.0, 10.0) if budget.quick else tuple(grid[::4])
    pairs = [measured.pair_of(k, z, budget.quick) for k in STIFFNESSES for z in few]
    budget.report(0.6)
    leaks = _LEAKS[budget.quick]
    bare = [measured.orbit_of(measured.bare_scene(leak)) for leak in leaks]
    held = [measured.orbit_of(measured.grip_scene(HELD, 2.0 / leak - 1.0, LOG10_R_BARE)) for leak in leaks]
    ends = [
        measured.end_of(measured.bare_scene(leak)) if math.isnan(point.period) else "stick-slip"
        for leak, point in zip(leaks, bare, strict=True)
    ]
    edge = measured.locking_leak()
    slow = {leak: measured.end_of(measured.bare_scene(leak, nudge=0.01)) for leak in _SLOW_LEAKS}
    return StudyResult(
        answer=_answer(leaks, ends, held),
        figures=(
            Figure("grip", _GRIP, lambda: over_grip(grid, orbits, pairs)),
            Figure("bare", _BARE, lambda: bare_and_grip(np.array(leaks), bare, held, edge)),
        ),
        tables=(wave_table(pairs), bare_table(leaks, bare, held, ends)),
        verdicts=(
            measured.agreement(pairs, budget.quick),
            measured.dies(leaks, ends, bare[0].period),
            measured.keeps(leaks, held),
            locks(slow, edge),
        ),
        notes=(
            "A locked interface returns each wave whole, the outer face returns the share R of it. Behind a bare coefficient the "
            "load therefore falls by the factor R every transit, to 1/e in about 1/(1 − R) transits. Stick-slip needs a load "
            "that lasts for a period.",
        ),
        numbers={f"grip {k:g}, Z_{{g}}/ε = 1: T": Number(orbits[k][len(grid) // 2].period, 1e-7) for k in STIFFNESSES},
    )


def _answer(leaks: tuple[float, ...], ends: list[str], held: list[Point]) -> str:
    alive, dead = measured.last_alive(leaks, ends)
    kept = sum(not math.isnan(point.period) for point in held)
    return (
        f"Grips keep the cycle at {kept} of {len(held)} reflections tried, down to R = {1.0 - max(leaks):g}; bare coefficients, "
        f"which leak the load, end it between 1 − R = {plain(alive, '.0e')} and {plain(dead, '.0e')}."
    )


_GRIP = (
    "Period and stress drop over the impedance of grips of two stiffnesses K (in ε a transit), log_{10} r = −2.6. Z_{g} = ε "
    "absorbs every wave. Lines: delay system, settled (a gap: no cycle). Circles: full wave (discontinuous Galerkin), crosses: "
    f"delay system, both in the last complete cycle before {UNTIL:.0f} transits, which is not settled where cycles are long."
)
_BARE = (
    "Period, stress drop and largest rate over 1 − R, log_{10} r = −2.66: bare coefficients, which leak the load, and grips of "
    "the same high-frequency reflection, which keep it. Dotted: 1 − R beyond which the interface locks instead of sliding on."
)


_LOOKS = (("#111111", "-"), ("#0072b2", (0, (5, 1.5))))


def wave_table(pairs: list[Pair]) -> Table:
    """Delay system and full wave, grip by grip."""
    rows = ((pair.stiffness, pair.impedance, *pair.exact, *pair.differences) for pair in pairs)
    differences = [f"difference in {name} [relative] .0e" for name in ("T", "Δμ", "v_{max}")]
    columns = "K [ε a transit] .0f | Z_{g}/ε .3g | T [transits] .9g | Δμ [σ] .7f | v_{max} [V*] .7g"
    caption = (
        f"Slabs in grips of stiffness K and impedance Z_{{g}}, log_{{10}} r = −2.6: last complete cycle before {UNTIL:.0f} "
        "transits by the delay system, and how far discontinuous Galerkin is from it in the same cycle."
    )
    return table("grips", caption, " | ".join([columns, *differences]), rows)


def bare_table(leaks: tuple[float, ...], bare: list[Point], held: list[Point], ends: list[str]) -> Table:
    """Bare coefficients beside grips of the same reflection."""
    rows = ((q, end, *point, 2.0 / q - 1.0, *grip) for q, end, point, grip in zip(leaks, ends, bare, held, strict=True))
    figures = "T [transits] .6g | Δμ [σ] .5f | v_{max} [V*] .0f"
    heading = f"1 − R .0e | bare: ends as | {figures} | grip: Z_{{g}}/ε .5g | {figures}"
    caption = (
        "Left: faces with a bare coefficient R, right: grips that reflect the same share of a fast wave, stiffness 10 ε a "
        f"transit; log_{{10}} r = −2.66, delay system. A dash: no cycle that repeats to {plain(RESTLESS, '.0e')}."
    )
    return table("bare", caption, heading, rows)


def over_grip(grid: Array, orbits: Mapping[float, Sequence[Any]], pairs: Sequence[Any]) -> Drawing:
    """`orbits`: stiffness -> points (period, drop, v_max) over `grid`; `pairs` hold the full wave's points."""
    figure, panels = subplots(3.8, 1, 2, r"$Z_g/\epsilon$")
    for (stiffness, points), (color, dashes) in zip(orbits.items(), _LOOKS, strict=True):
        for axes, which in zip(panels, (0, 1), strict=True):
            label = f"delay system, $K = {stiffness:g}$"
            axes.semilogx(grid, [point[which] for point in points], color=color, linestyle=dashes, marker=".", label=label)
            chosen = [pair for pair in pairs if pair.stiffness == stiffness]
            at = [p.impedance for p in chosen]
            axes.plot(at, [p.exact[which] for p in chosen], "+", color=color, markersize=8)
            axes.plot(at, [p.wave[which] for p in chosen], "o", color="#d55e00", markerfacecolor="none")
    panels[1].lines[-1].set_label("full wave")
    for axes, name in zip(panels, ("period $T$ (transits)", r"stress drop $\Delta\mu$"), strict=True):
        axes.set_ylim(bottom=0.0)
        axes.set_ylabel(name)
        axes.grid(True)
    lines = [panels[1].lines[0], panels[1].lines[3], panels[1].lines[-1]]
    figure.legend(handles=lines, loc="outside upper left", ncols=3, handlelength=3.0)
    return figure


def bare_and_grip(leaks: Array, bare: Sequence[Any], held: Sequence[Any], edge: float) -> Drawing:
    """Points (period, drop, v_max) over `leaks` = 1 - R; the interface locks beyond `edge`."""
    figure, panels = subplots(3.4, 1, 3, "$1 - R$")
    names = ("period $T$ (transits)", r"stress drop $\Delta\mu$", r"$v_{max}/V^*$")
    for which, (axes, name) in enumerate(zip(panels, names, strict=True)):
        for points, (color, dashes), marker, label in zip(
            (bare, held), _LOOKS, ("o", "^"), ("bare coefficient $R$", "grip of the same reflection"), strict=True
        ):
            values = [point[which] for point in points]
            axes.semilogx(leaks, values, color=color, linestyle=dashes, marker=marker, markersize=4, label=label)
        axes.axvline(edge, color="#6b6b66", linewidth=0.8, linestyle=(0, (1, 2)))
        axes.set_ylim(bottom=0.0)
        axes.set_title(name)
        axes.grid(True)
    figure.legend(handles=panels[0].lines[:2], loc="outside upper left", ncols=2, handlelength=3.0)
    return figure
