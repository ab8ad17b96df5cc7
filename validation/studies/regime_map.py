"""Where in the plane of round trip and velocity does each model slide steadily, periodically, or irregularly?"""

import math
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

import slipwave
from validation.report import WITNESS, Budget, Figure, Number, StudyResult, Verdict, every, places, stated

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
    swept = _swept_plane(budget)
    regimes = _mapped(swept)
    rows = slipwave.map(swept, against=_REFERENCE).summary["differences"]
    nearest = sorted(rows, key=lambda row: float(row["other_regime_percent"]))
    areas = ", ".join(f"`{row['model']}` in {row['other_regime_percent']:.2g} %" for row in nearest)
    return StudyResult(
        answers={
            f"Of the plane of r and V another regime than the exact one have {areas}.": ("Regimes of runs",),
        },
        figures=(
            Figure("regimes", _REGIMES, regimes.chart),
            Figure("differences", _DIFFERENCES, lambda: slipwave.map(swept, against=_REFERENCE, show="other_regime").chart()),
        ),
        verdicts=(_boundaries(swept, regimes.boundaries),),
        numbers=_areas(swept.dataset.sizes, rows),
    )


def _swept_plane(budget: Budget) -> Any:
    """The sweep of the plane with every model."""
    scene = slipwave.read("paper", {"run.until": _UNTIL})
    round_trips, velocities, levels = budget.plan(quick=(13, 7, 1), full=(25, 13, 2))
    vary = {"log10_r": (*_R, round_trips), "V": f"{_V[0]:g}:{_V[1]:g}:{velocities}:log"}
    options = {"models": ",".join(_MODELS), "tol": _TOLERANCE, "refine": levels, "workers": 1}
    with ThreadPoolExecutor(1) as here:  # studies are computed side by side, in processes of their own
        swept = slipwave.sweep(scene, vary=vary, executor=here, **options)
        _ = swept.dataset  # read before its folder is removed
    swept.close()
    return swept


def _areas(sizes: Any, rows: Any) -> dict[str, Number]:
    """The share of the plane in which a model has another regime, in per cent; the error is one point. Shares on different
    lattices, which their names contain, are not compared."""
    counts = [size for name, size in sizes.items() if name != "model"]
    return {
        f"{row['model']} other regime, {' x '.join(map(str, counts))} points": stated(
            row["other_regime_percent"], 1e4 / (math.prod(counts) * row["compared_percent"])
        )
        for row in rows
    }


def _model_regimes(model: str, swept: Any) -> Any:
    """The regimes of a model at the points of the plane, as `MapResult.regimes`."""
    return slipwave.map(swept, plain=True).regimes(model)


def _mapped(swept: Any) -> Any:
    """The map of verdicts, with the boundaries on which steady sliding of each model loses its stability."""
    return slipwave.map(swept, show="verdict")


def _critical_round_trips(model: str, lines: Any, velocities: Any) -> Any:
    """log10 of the critical r of a model at these velocities, from the certified number of growing roots."""
    line = next(line for line in lines if line.model == model)
    order = np.argsort(line.up)
    return np.interp(velocities, np.asarray(line.up)[order], np.asarray(line.across)[order])


def _boundaries(swept: Any, lines: Any) -> Verdict:
    """Verdict: regimes of runs against the certified counts of roots, which use no run."""
    log10_r, velocity = (swept.dataset[name].values for name in ("log10_r", "drive_velocity"))
    wrong, judged, cell = 0, 0, np.diff(log10_r[:2])[0]
    for model in _MODELS:
        regimes, beyond = _model_regimes(model, swept), log10_r[:, None] - _critical_round_trips(model, lines, velocity)
        clear = (np.abs(beyond) > cell) & (regimes >= 0)
        wrong, judged = wrong + int((clear & ((regimes == 0) != (beyond < 0.0))).sum()), judged + int(clear.sum())
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
