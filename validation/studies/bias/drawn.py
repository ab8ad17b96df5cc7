"""The tables and the figure of the study."""

from collections.abc import Mapping, Sequence

import numpy as np

from slipwave.observe.pieces import Array
from validation.fit.synthetic import NOISE
from validation.studies.bias.atlas import ALLOWED, Atlas
from validation.studies.bias.measured import COVERED, MACHINES, MODELS, QUANTITIES, RINGING, SLIPPING_SWINGS, SWINGS
from validation.study import Cell, Table, table
from validation.study.drawing import Drawing, style_of, subplots

_COLORS = ("#0072b2", "#e69f00", "#d55e00")
_SHOWN = 4  # the swing whose errors the table shows
_SEEN = (0.01, 300.0)  # %


def called(model: str) -> str:
    """Name of a model on the page."""
    return "block, fitted mass" if model == "one mass" else style_of(model).label


def table_of_rules(atlas: Atlas) -> Table:
    """Limits, share of intervals that exclude the truth, and errors at one swing."""
    rows: list[list[Cell]] = []
    for model in MODELS:
        limits, out = atlas.limits(model), atlas.excluded(model)
        errors = (100.0 * float(np.nanmax(np.abs(atlas.of(model, "error", q)[:, _SHOWN]))) for q in QUANTITIES)
        rows.append([model, atlas.rule(model), *limits.min(axis=1).tolist(), limits.max(), 100.0 * float(out.mean()), *errors])
    machines = ("no machine" if mass is None else f"mass {mass:g}" for mass in MACHINES)
    heading = ["model", "swing with 1 % .2g", *(f"{name} .2g" for name in machines), "at best .2g", "truth excluded [%] .0f"]
    heading += [f"{q} at {SWINGS[_SHOWN]:.2g} [%] .2g" for q in QUANTITIES]
    return table("rules", _RULES, " | ".join(heading), rows)


def table_of_slips(atlas: Atlas) -> Table:
    """Medians of errors of fits to stick-slip."""
    rows: list[list[Cell]] = []
    for model in (one for one in MODELS if one not in RINGING):
        errors = [np.abs(atlas.of(model, "error", q, False)) for q in QUANTITIES]
        made = np.isfinite(errors[3])
        out = atlas.excluded(model, False)[made]
        medians = (100.0 * float(np.median(one[made])) if made.any() else None for one in errors)
        rows.append([model, int(made.sum()), 100.0 * float(out.mean()) if made.any() else None, *medians])
    heading = ["model", "fits .0f", "truth excluded [%] .0f", *(f"{q} [%] .2g" for q in QUANTITIES)]
    return table("stick-slip", _SLIPS, " | ".join(heading), rows)


def table_of_coverage(covered: Mapping[str, Sequence[Sequence[bool]]]) -> Table:
    """Coverage of the intervals."""
    rows = ((model, len(rows), *(100.0 * np.mean(rows, axis=0)).tolist()) for model, rows in covered.items())
    return table("coverage", _COVERAGE, "model | fits .0f | a [%] .1f | b [%] .1f | L [%] .1f", rows)


def draw_atlas(atlas: Atlas) -> Drawing:
    """A panel for each model: the largest error of a, b and L over the swing, by machine; stick-slip as circles."""
    figure, grid = subplots(4.8, 2, 4, sharex=True, sharey=True)
    for axes, model in zip(grid.flat, MODELS, strict=False):
        steps, slips = (_percent(atlas.worst(model, steps)) for steps in (True, False))
        excluded = atlas.excluded(model)
        for k, (color, mass, errors, slip) in enumerate(zip(_COLORS, MACHINES, steps, slips, strict=True)):
            out = excluded[k].any(axis=1)
            axes.plot(SWINGS, errors, color=color, label="no machine" if mass is None else f"machine, mass {mass:g}")
            axes.plot(SWINGS[out], errors[out], "x", color=color, markersize=5)
            made = np.isfinite(slip)
            axes.plot(SLIPPING_SWINGS[made], slip[made], "o", color=color, markersize=4, fillstyle="none")
        axes.axhline(100.0 * ALLOWED, color="#555555", linewidth=0.8, linestyle=(0, (4, 2)))
        axes.set(xscale="log", yscale="log", ylim=_SEEN)
        axes.set_title(called(model), fontsize="medium")
    legend = grid.flat[-1]
    legend.set_axis_off()
    lines = [line for line in grid.flat[0].get_lines() if not str(line.get_label()).startswith("_")]
    lines += [
        legend.plot([], [], mark, color="#555555", fillstyle="none", label=words)[0]
        for mark, words in (("x", "truth excluded"), ("o", "stick-slip"))
    ]
    legend.legend(handles=lines, loc="center", fontsize="small", borderaxespad=0.0)
    for axes in grid.flat[3:7]:
        axes.set_xlabel("swing / time of slip by $L$", fontsize="small")
        axes.tick_params(labelbottom=True)
    for axes in grid[:, 0]:
        axes.set_ylabel("largest error of a, b, L / %", fontsize="small")
    return figure


def _percent(worst: Array) -> Array:
    """Largest error over kappa in per cent, clipped to the axis; NaN where a fit did not converge."""
    most = 100.0 * worst.max(axis=2)
    return np.where(np.isfinite(most), np.clip(most, *_SEEN), np.nan)


_PLACES = (
    "Data of the exact delay system (a = 0.01, b = 0.015), fitted by slabs of the same impedance and stiffness, without a "
    "machine; free are a, b, L and stiffness. Swing: the period of the slowest free swing of sample and machine (without a "
    "machine twice the transit) over the time of slip by L at the faster velocity. Mass: of a machine that has half of the "
    "compliance, over the slab’s"
)
ATLAS = (
    f"{_PLACES}. Lines: a velocity step by ten, the worst k/k_{{c}} of 1.2 to 32, k_{{c}} = (b − a) σ/L. "
    f"Crosses: a fit’s own 95 % interval of a, b or L excludes the truth (noise {NOISE:g}). Circles: stick-slip at k/k_{{c}} of "
    "0.5 and 0.8, by period and phases. Dashed: 1 %."
)
_RULES = (
    f"{_PLACES}. Swing with 1 %: up to it no error of a, b and L is larger, for k/k_{{c}} from 1.2 to 32, in all and by machine, "
    "and at the best k/k_{c}; truth excluded: share of fits in which an interval of a, b or L does not hold the truth; then the "
    "largest errors at one swing."
)
_SLIPS = (
    "Fits to the period and the mean cycle of stick-slip records: medians of the errors’ sizes, and the share of fits in which "
    "an interval of a, b or L does not hold the truth. Kelvin–Voigt and modal:2 are not fitted: without a loss they swing on "
    "while they stick, and no fit of them came to an end. An event lasts about a transit whatever the slabs, so that thin ones "
    "do not help."
)
_COVERAGE = (
    f"Records of a, b, L by each model, fitted by itself, at share {COVERED[0]} and k/k_{{c}} {COVERED[1]}: how often intervals "
    "hold the truth."
)
