"""Where in the plane of round trip and velocity does each model slide steadily, periodically, or irregularly?"""

from typing import Any

import numpy as np

import slipwave
from validation.data.datasets import Dataset
from validation.report import WITNESS, Budget, Figure, StudyAnswer, StudyResult, Verdict, every
from validation.report.numbers import regime_areas
from validation.report.text import places
from validation.sweep.axes import axis_of
from validation.sweep.boundaries import onset_lines
from validation.sweep.difference import difference, difference_rows, model_regimes
from validation.sweep.map_figures import Line, chart_of_sweep
from validation.sweep.sweep import plan_of, swept_here

NAME = "regime-map"
QUESTION = "Where does each model have the wrong regime?"
SCENES = ("paper",)
SECONDS = (12.0, 40.0)

_REFERENCE = "delay"
_MODELS = (_REFERENCE, "kelvin-voigt", "modal:2", "block12", "quasidynamic")
_UNTIL, _TOLERANCE = 1200.0, 1e-6
_R, _V = (-2.74, -2.42), (100.0, 1000.0)


def run(budget: Budget) -> StudyResult:
    """Sweep the plane with every model, compare the boundaries with certified counts of roots, and compare the regimes."""
    data = swept_plane(budget)
    lines = onset_lines(data)
    differences = difference(data, _REFERENCE)
    rows = difference_rows(differences)
    nearest = sorted(rows, key=lambda row: float(row["other_regime_percent"]))
    areas = ", ".join(f"`{row['model']}` in {row['other_regime_percent']:.2g} %" for row in nearest)
    return StudyResult(
        answers=(StudyAnswer(f"Of the plane of r and V another regime than the exact one have {areas}.", ("Regimes of runs",)),),
        figures=(
            Figure("regimes", _REGIMES, lambda: chart_of_sweep(data, "verdict", lines)),
            Figure("differences", _DIFFERENCES, lambda: chart_of_sweep(differences, "other_regime")),
        ),
        verdicts=(_boundaries(data, lines),),
        numbers=regime_areas(differences, rows),
    )


def swept_plane(budget: Budget) -> Dataset:
    """The sweep of the plane with every model."""
    scene = slipwave.read("paper", {"run.until": _UNTIL})
    counts, levels = ((13, 7), 1) if budget.quick else ((25, 13), 2)
    axes = [axis_of("log10_r", (*_R, counts[0])), axis_of("V", f"{_V[0]:g}:{_V[1]:g}:{counts[1]}:log")]
    plan = plan_of(scene, axes, _MODELS, "verdict", tol=_TOLERANCE, refine=levels)
    return swept_here(plan)


def critical_round_trips(model: str, lines: tuple[Line, ...], velocities: Any) -> Any:
    """log10 of the critical r of a model at these velocities, from the certified number of growing roots."""
    line = next(line for line in lines if line.model == model)
    order = np.argsort(line.up)
    return np.interp(velocities, np.asarray(line.up)[order], np.asarray(line.across)[order])


def _beyond_onset(model: str, data: Dataset, lines: tuple[Line, ...]) -> Any:
    """Distance of each point of the plane from the model's critical r, in log10 r."""
    return data["log10_r"].values[:, None] - critical_round_trips(model, lines, data["drive_velocity"].values)


def _boundaries(data: Dataset, lines: tuple[Line, ...]) -> Verdict:
    """Verdict: regimes of runs against the certified counts of roots, which use no run."""
    wrong, judged, cell = 0, 0, float(np.diff(data["log10_r"].values[:2])[0])
    for model in _MODELS:
        found, beyond = model_regimes(model, data), _beyond_onset(model, data, lines)
        clear = (np.abs(beyond) > cell) & (found >= 0)
        wrong, judged = wrong + int((clear & ((found == 0) != (beyond < 0.0))).sum()), judged + int(clear.sum())
    title = "Regimes of runs change from steady sliding where certified counts of roots say so"
    remark = (
        f"every model; points more than a cell ({cell:.3g} in log_{{10}} r) from the boundary, which `slipwave.stability` finds"
    )
    return every(title, WITNESS, judged - wrong, judged, remark, "points")


_PLANE = (
    f"log_{{10}} r from {places(_R[:1])} to {places(_R[1:2])}, V from {_V[0]:g} to {_V[1]:g} V*, the paper’s law "
    f"and ε, runs of at most {_UNTIL:g} transits from a nudge of steady sliding"
)
_REGIMES = (
    f"Verdicts on the motion: {_PLANE}. Dashed: where steady sliding loses its stability, from the certified number of growing "
    "roots of each model, not from runs. “Too short”: too few cycles for a verdict."
)
_DIFFERENCES = (
    "Where a model has another regime than the delay system; white: one of both has no verdict. Steady sliding and the "
    "return to it are one regime."
)
