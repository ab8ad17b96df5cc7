"""Slabs that differ: the delay network against every full-wave family, and the regime of each model over their ratios."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

import slipwave as sw
from validation.measure import growth
from validation.measure.in_process import SweepResult, model_regimes, swept_here
from validation.measure.order_fit import WITHIN
from validation.report import Budget, Figure, StudyAnswer, StudyResult, Table, stated, table
from validation.report.numbers import regime_areas
from validation.report.text import places, plain
from validation.report.verdict import ROUNDING, WITNESS, Verdict, claim, every, in_range

NAME = "asymmetry"
QUESTION = "What does it change that the slabs differ?"
SCENES = ("unlike", "unlike-irrational", "paper")
SECONDS = (8.0, 28.0)

UNTIL = 600.0
TOLERANCE = 1e-11
"""Tolerance of the delay system."""

_PAIRS = {"unlike": "2", "unlike-irrational": "√2"}
"""Scene -> its ratio of round trips; the ratio of impedances is 3 in both."""
_SECOND_ORDER = 4.0 * (1.0 - 2.0**-WITHIN)  # how far the leapfrog's ratio may lie from 4
_GRIDS = {
    True: (("dg:7", 4, None), ("sbp:6", 64, None), ("fem:4", 8, None), ("fd", 96, 0.5), ("fd", 192, 0.5)),
    False: (("dg:7", 6, None), ("sbp:6", 96, None), ("fem:4", 12, None), ("fd", 192, 0.5), ("fd", 384, 0.5)),
}
"""Quick report -> models, cells per slab and Courant numbers."""

_MODELS = ("delay", "kelvin-voigt", "modal:2")
_AXES = ("ratio_epsilon", "ratio_r")
_RANGE = "0.7:1.4"
_LOG10_R, _LONGEST, _SWEPT = -2.67, 3000.0, 1e-6


Psi = Mapping[tuple[str, int | None], float]
"""Model and cells of a slab -> psi at UNTIL."""


def run(budget: Budget) -> StudyResult:
    """March both scenes with every family; sweep the plane of ratios with some models."""
    grids = [("delay", None, None), *_GRIDS[budget.quick]]
    runs = {name: {(model, cells): state_of(name, model, cells, cfl) for model, cells, cfl in grids} for name in _PAIRS}
    budget.report(0.5)
    known = {name: error_of_delay(name, each["delay", None]) for name, each in runs.items()}
    budget.report(0.7)
    scene = sw.read("paper", {"run.until": _LONGEST, "slab.log10_r": _LOG10_R})
    swept = swept_ratios(scene, 5 if budget.quick else 9)
    rows = sw.map(swept, against=_MODELS[0]).summary["differences"]
    return StudyResult(
        answers=_answers(runs, swept, rows),
        figures=(
            Figure("regimes", _REGIMES, lambda: sw.map(swept, show="verdict", plain=True).chart()),
            Figure("differences", _DIFFERENCES, lambda: sw.map(swept, against=_MODELS[0], show="other_regime").chart()),
        ),
        tables=(_errors(rows),),
        verdicts=(*_agreements(runs, known), *_leapfrog(runs), _as_counted(scene, swept)),
        numbers={f"{name}: ψ({UNTIL:.0f})": stated(runs[name]["delay", None], error) for name, error in known.items()}
        | regime_areas(swept.dataset.sizes, rows),
    )


def _answers(runs: Mapping[str, Psi], swept: SweepResult, rows: Any) -> tuple[StudyAnswer, ...]:
    off = max(abs(psi - each["delay", None]) for each in runs.values() for (model, _), psi in each.items() if model == "dg:7")
    worst = max(rows, key=lambda row: row["other_regime_percent"])
    across, up = np.meshgrid(*(np.log(swept.dataset[name].values) for name in _AXES), indexing="ij")
    steady = model_regimes(_MODELS[0], swept) == 0
    share = 100.0 * float((steady & (across > up)).sum()) / max(int(steady.sum()), 1)
    return (
        StudyAnswer(
            f"Slabs may differ, and the exact system stays exact: after {UNTIL:.0f} transits ψ of the delay network and of "
            f"discontinuous Galerkin differ by {plain(off, '.0e')} at most.",
            ("Unlike slabs:",),
        ),
        StudyAnswer(
            f"Of the plane of ratios that both decide, {worst['model']} has another regime than the delay system in "
            f"{worst['other_regime_percent']:.0f} %; {share:.0f} % of the points that slide steadily have a stiffer lower slab.",
            ("Runs of unlike slabs",),
        ),
    )


def state_of(name: str, model: str, cells: int | None, cfl: float | None) -> float:
    """psi = ln phi of `model` on a scene of the gallery at UNTIL."""
    march = None if model == "fd" else "explicit"
    options: dict[str, Any] = {"tol": TOLERANCE} if model == "delay" else {"cells": cells, "cfl": cfl, "time": march}
    return float(sw.run(name, model, until=UNTIL, **options).final.psi)


def error_of_delay(name: str, psi: float) -> float:
    """Of the delay system's final state, a logarithm: how far a run at ten times the tolerance is, or rounding."""
    return max(ROUNDING, abs(float(sw.run(name, "delay", until=UNTIL, tol=10.0 * TOLERANCE).final.psi) - psi))


def swept_ratios(scene: sw.Scene, count: int) -> SweepResult:
    """The sweep of the plane with every model."""
    return swept_here(scene, dict.fromkeys(_AXES, f"{_RANGE}:{count}:log"), _MODELS, tol=_SWEPT)


def growing_roots(scene: sw.Scene, model: str, swept: SweepResult) -> Any:
    """The certified number of growing roots of steady sliding at each point of the plane."""
    first, second = (swept.dataset[name].values for name in _AXES)
    pairs = ([dict(zip(_AXES, (x, y), strict=True)) for y in second] for x in first)
    return np.array([[growth.counted_roots(scene, model, pair) for pair in row] for row in pairs])


def _agreements(runs: Mapping[str, Psi], known: Mapping[str, float]) -> Iterator[Verdict]:
    title = f"Unlike slabs: ψ({UNTIL:.0f}) of the delay network and of each full-wave family of high order agree"
    for name, found in runs.items():
        for model, cells in found:
            if model not in ("delay", "fd"):
                off = found[model, cells] - found["delay", None]
                yield claim(title, WITNESS, off, known[name], f"`{model}`, round trips {_PAIRS[name]} : 1")


def _leapfrog(runs: Mapping[str, Psi]) -> Iterator[Verdict]:
    """Half the cells, four times the error."""
    title, ends = "Unlike slabs: leapfrog’s error falls with the square of the cell", (4.0 - _SECOND_ORDER, 4.0 + _SECOND_ORDER)
    for name, found in runs.items():
        coarse, fine = (abs(psi - found["delay", None]) for (model, _), psi in found.items() if model == "fd")
        remark = f"round trips {_PAIRS[name]} : 1: ratio of the errors of ψ({UNTIL:.0f}) at half and at all the cells"
        yield in_range(title, WITNESS, ends, [coarse / fine], remark, ".2f")


def _as_counted(scene: sw.Scene, swept: SweepResult) -> Verdict:
    wrong, judged = 0, 0
    for model in _MODELS:
        found = model_regimes(model, swept)
        steady = growing_roots(scene, model, swept) == 0
        judged += int((found >= 0).sum())
        wrong += int(((found >= 0) & ((found == 0) != steady)).sum())
    title = "Runs of unlike slabs leave steady sliding where certified counts of roots say so"
    return every(title, WITNESS, judged - wrong, judged, "every model, every point with a verdict that lasts", "points")


def _errors(rows: Any) -> Table:
    heading = "model | both decide [%] .3g | other regime [%] .2g | largest error of T .1e | of the stress drop .1e"
    names = ("model", "compared_percent", "other_regime_percent", "period", "stress_drop")
    return table("errors", _ERRORS, heading, ([None if row[name] != row[name] else row[name] for name in names] for row in rows))


_PLANE = (
    f"Ratio of the slabs’ impedances and of their round trips (lower over upper slab) from 0.7 to 1.4, "
    f"log_{{10}} r = {places([_LOG10_R])} of the upper slab, V = 100 V*, runs of at most {_LONGEST:g} transits from a nudge"
)
_REGIMES = f"Verdicts on the motion of unlike slabs. {_PLANE}. “Too short”: too few cycles for a verdict."
_DIFFERENCES = "Where a model of unlike slabs has another regime than the delay system; white: one of both has no verdict."
_ERRORS = (
    "The plane of ratios: per cent of the area in which both a model and the delay system have a verdict; of that, per cent with "
    "another regime; and the largest relative errors where both motions are periodic."
)
