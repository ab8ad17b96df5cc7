"""Fills the table of models (`validation.report.model_table`): errors against the exact system, onsets, costs."""

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np

from reduced.stability import critical_round_trip
from slipwave.errors import NumericsError
from slipwave.observe.statistics import Estimate
from slipwave.scene import Scene
from validation.measure.costs import march_times
from validation.measure.memo import kept
from validation.measure.regimes import Regime
from validation.models.by_name import one_port_of
from validation.report.advice import with_advice
from validation.report.model_table import Compared, ModelCell, ModelColumn, ModelQuantity, ModelRow, ModelTable

EXACT_MODEL = "delay"
"""The reference model of errors."""

QUANTITIES = (
    ModelQuantity("T", "period", "transits"),
    ModelQuantity("Δμ", "stress drop", "σ"),
    ModelQuantity("v_{max}", "largest slip rate", "V*"),
)
_TRANSITS, _BEFORE = 1000.0, 500.0  # that are timed, and marched before
_TOLERANCE = 1e-9
_EXACTLY = 1e-12  # relative error of an onset


def compared_table(
    name: str,
    caption: str,
    parameter: str,
    columns: Sequence[ModelColumn],
    regimes: Mapping[str, Sequence[Regime]],
    onsets: Mapping[str, Compared | None],
    costs: Mapping[str, Mapping[str, float]],
) -> ModelTable:
    """The table, with advice and sentences, of models whose `regimes` in the columns are known, the exact system's among them;
    `costs` by the title of a column, which is the `parameter`. A column without a group is in that of the exact regime."""
    exact = regimes[EXACT_MODEL]
    rows = []
    for model, found in regimes.items():
        cells = tuple(_cell(one, None if model == EXACT_MODEL else other) for one, other in zip(found, exact, strict=True))
        rows.append(ModelRow(model, cells, onsets.get(model), tuple(known.get(model) for known in costs.values()), "", ""))
    grouped = (
        replace(one, group=one.group or ("torus, irregular" if regime.cycles else regime.words))
        for one, regime in zip(columns, exact, strict=True)
    )
    table = ModelTable(name, caption, parameter, QUANTITIES, tuple(grouped), tuple(costs), EXACT_MODEL, tuple(rows))
    return with_advice(table)


def _cell(ours: Regime, exact: Regime | None) -> ModelCell:
    others = exact.figures if exact else {}
    figures = {symbol: against(own, others.get(symbol)) for symbol, own in ours.figures.items()}
    return ModelCell(ours.words, exact is None or ours.agrees(exact), ours.cycles, figures, ours.command)


def against(ours: Estimate, exact: Estimate | None) -> Compared:
    """A quantity of a model compared with the exact system's, if known."""
    own = ours.error / abs(ours.value)
    if exact is None:
        return Compared(ours.value, None, own)
    ratio = ours.value / exact.value
    return Compared(ours.value, ratio - 1.0, ratio * math.hypot(own, exact.error / exact.value))


@kept
def critical_r(model: str, scene: Scene) -> float:
    """The upper slab's r from which on steady sliding is unstable, both slabs scaled together; NaN if there is none. For a full
    wave that of its equations, independent of the grid."""
    try:
        return critical_round_trip(scene, one_port_of(model))[0]
    except NumericsError:
        return math.nan


def onset(model: str, scene: Scene) -> Compared | None:
    """Onset of a model, log10 of its critical r, with the relative error of r itself; None if it has none."""
    own, exact = (critical_r(one, scene) for one in (model, EXACT_MODEL))
    return Compared(math.log10(own), None if model == EXACT_MODEL else own / exact - 1.0, _EXACTLY) if own > 0.0 else None


def relative_costs(models: Collection[str], cells: Mapping[str, int], scene: Scene, rounds: int) -> dict[str, float]:
    """Processor time of 1000 transits of march and event detection on the motion that each model has settled on, over that of the
    exact system: medians over `rounds` in which all are timed in turn. `cells`: of the full waves."""
    settings = [(model, {"cells": cells[model]} if model in cells else {"tol": _TOLERANCE}) for model in models]
    times = march_times(settings, scene, _TRANSITS, rounds + 1, _BEFORE)[1:]
    shares = np.median(times / times[:, [[*models].index(EXACT_MODEL)]], axis=0)
    return dict(zip(models, shares.tolist(), strict=True))
