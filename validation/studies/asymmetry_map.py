"""Two slabs that differ in impedance and in thickness: where does each model slide steadily, and where is its regime wrong?"""

from typing import Any

import numpy as np

import slipwave
from reduced.stability.characteristic import characteristic
from reduced.stability.spectrum import unstable_count
from slipwave.scene import Scene
from validation.compute.models import one_port_of
from validation.results.result import Dataset
from validation.study import WITNESS, Budget, Figure, StudyResult, Table, Verdict, every, table
from validation.study.regimes import regime_areas
from validation.study.text import places
from validation.sweep.axes import axis_of, changed
from validation.sweep.difference import difference, model_regimes
from validation.sweep.map_figures import figure_of
from validation.sweep.sweep import plan_of, swept_here

NAME = "asymmetry-map"
QUESTION = "What does asymmetry of the slabs do to the regime of each model?"
SCENES = ("paper",)
SECONDS = (4.0, 16.0)

_REFERENCE = "delay"
_MODELS = (_REFERENCE, "kelvin-voigt", "modal:2")
_AXES = ("ratio_epsilon", "ratio_r")
_RANGE = "0.7:1.4"
_LOG10_R, _UNTIL, _TOLERANCE = -2.67, 3000.0, 1e-6


def run(budget: Budget) -> StudyResult:
    """Sweep the plane with every model, compare each decided point with the certified count of roots, compare the regimes."""
    scene = slipwave.read("paper", {"run.until": _UNTIL, "slab.log10_r": _LOG10_R})
    data = swept_ratios(scene, 5 if budget.quick else 9)
    differences = difference(data, _REFERENCE)
    rows = differences.attrs["differences"]
    worst = max(rows, key=lambda row: row["other_regime_percent"])
    return StudyResult(
        answer=f"Of the plane that both decide, {worst['model']} has another regime than the delay system in "
        f"{worst['other_regime_percent']:.0f} %; {_onset(data)}.",
        figures=(
            Figure("regimes", _REGIMES, lambda: figure_of(data, "verdict")),
            Figure("differences", _DIFFERENCES, lambda: figure_of(differences, "other_regime")),
        ),
        tables=(_errors(rows),),
        verdicts=(_as_counted(scene, data),),
        numbers=regime_areas(differences),
    )


def swept_ratios(scene: Scene, count: int) -> Dataset:
    """The sweep of the plane with every model."""
    axes = [axis_of(name, f"{_RANGE}:{count}:log") for name in _AXES]
    return swept_here(plan_of(scene, axes, _MODELS, "verdict", tol=_TOLERANCE))


def growing_roots(scene: Scene, model: str, data: Dataset) -> Any:
    """The certified number of growing roots of steady sliding at each point of the plane."""
    first, second = (data[name].values for name in _AXES)
    scenes = ([changed(scene, dict(zip(_AXES, (x, y), strict=True))) for y in second] for x in first)
    return np.array([[unstable_count(characteristic(one, one_port_of(model))) for one in row] for row in scenes])


def _as_counted(scene: Scene, data: Dataset) -> Verdict:
    wrong, judged = 0, 0
    for model in _MODELS:
        found = model_regimes(model, data)
        steady = growing_roots(scene, model, data) == 0
        judged += int((found >= 0).sum())
        wrong += int(((found >= 0) & ((found == 0) != steady)).sum())
    title = "Runs of unlike slabs leave steady sliding where certified counts of roots say so"
    return every(title, WITNESS, judged - wrong, judged, "every model, every point with a verdict that lasts", "points")


def _onset(data: Dataset) -> str:
    """Text on steady sliding in the plane, with numbers."""
    across, up = np.meshgrid(*(np.log(data[name].values) for name in _AXES), indexing="ij")
    found = model_regimes(_REFERENCE, data)
    stiff = across > up
    share = 100.0 * float(((found == 0) & stiff).sum()) / max(int((found == 0).sum()), 1)
    return f"{share:.0f} % of the points that slide steadily have a stiffer lower slab: more impedance than travel time"


def _errors(rows: Any) -> Table:
    heading = "model | both decide [%] .3g | other regime [%] .2g | largest error of T .1e | of the stress drop .1e"
    names = ("model", "compared_percent", "other_regime_percent", "period", "stress_drop")
    return table("errors", _ERRORS, heading, ([None if row[name] != row[name] else row[name] for name in names] for row in rows))


_PLANE = (
    f"Ratio of the slabs’ impedances and of their round trips (lower over upper slab) from 0.7 to 1.4, "
    f"log_{{10}} r = {places([_LOG10_R])} of the upper slab, V = 100 V*, the paper’s law, "
    f"runs of at most {_UNTIL:g} transits from a nudge of steady sliding"
)
_REGIMES = f"Verdicts on the motion of unlike slabs. {_PLANE}. “Too short”: too few cycles for a verdict."
_DIFFERENCES = "Where a model of unlike slabs has another regime than the delay system; white: one of both has no verdict."
_ERRORS = (
    f"{_PLANE}. Per cent of the area in which both a model and the delay system have a verdict; of that, per cent with another "
    "regime; and the largest relative errors where both motions are periodic."
)
