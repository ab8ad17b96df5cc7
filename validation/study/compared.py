"""Fills the table of models (`validation.study.model_table`): errors against the exact system, onsets, costs."""

import math
from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from reduced.stability import critical_round_trip
from slipwave.errors import NumericsError
from slipwave.observe.statistics import Estimate
from slipwave.scene import Scene
from validation.compute.models import one_port_of
from validation.study.advice import with_advice
from validation.study.model_table import Compared, ModelCell, ModelColumn, ModelQuantity, ModelRow, ModelTable
from validation.study.regimes import Regime
from validation.timing import March, Setting, in_turn

EXACT_MODEL = "delay"
"""The reference model of errors."""

QUANTITIES = {
    "T": ("period", "transit", "transits"),
    "Δμ": ("stress drop", "normal stress", "σ"),
    "v_{max}": ("largest slip rate", "V*", "V*"),
}
"""Symbol -> name, unit in `slipwave.scene.units`, and unit in tables; in the order of `CycleFigures`."""

_SI = {"transit": "s", "normal stress": "Pa", "V*": "m/s"}
_TRANSITS, _BEFORE = 1000.0, 500.0  # that are timed, and marched before
_TOLERANCE = 1e-9
_EXACTLY = 1e-12  # relative error of an onset


class Sight(NamedTuple):
    """A scene as a column of the table: its `title`, r over the onset of the exact system, and the command line options that give
    it."""

    title: str
    scene: Scene
    over_onset: float
    settings: str = ""


def compared_table(
    name: str,
    caption: str,
    sights: Sequence[Sight],
    regimes: Mapping[str, Sequence[Regime]],
    costs: Mapping[str, Mapping[str, float]] | None = None,
    parameter: str = "log_{10} r",
) -> ModelTable:
    """The table, with advice and sentences, of models whose `regimes` in the scenes are known, the exact system's among them;
    `costs` by the title of a column, which is the `parameter`. Values of a scene in SI are in SI."""
    units, exact = sights[0].scene.units, regimes[EXACT_MODEL]
    sizes = [[units.size(unit, one.scene.transit) if units else 1.0 for _, unit, _ in QUANTITIES.values()] for one in sights]
    quantities = (
        ModelQuantity(symbol, name, _SI[unit] if units else shown) for symbol, (name, unit, shown) in QUANTITIES.items()
    )
    rows = []
    for model, found in regimes.items():
        each = zip(found, exact, sizes, strict=True)
        cells = tuple(_cell(one, None if model == EXACT_MODEL else other, size) for one, other, size in each)
        spent = tuple(known.get(model) for known in (costs or {}).values())
        rows.append(ModelRow(model, cells, _onset(model, sights[0].scene), spent, "", ""))
    groups = (
        "periodic" if one.words.startswith("periodic") else "torus, irregular" if one.figures else one.words for one in exact
    )
    columns = (
        ModelColumn(one.title, math.log10(one.scene.transit), one.over_onset, group, one.settings)
        for one, group in zip(sights, groups, strict=True)
    )
    table = ModelTable(name, caption, parameter, tuple(quantities), tuple(columns), tuple(costs or ()), EXACT_MODEL, tuple(rows))
    return with_advice(table)


def _cell(ours: Regime, exact: Regime | None, sizes: Sequence[float]) -> ModelCell:
    right = exact is None or ours.agrees(exact)
    if ours.figures is None:
        return ModelCell(ours.words, right)
    others = (None, None, None) if exact is None or exact.figures is None else exact.figures
    each = zip(QUANTITIES, ours.figures, others, sizes, strict=True)
    figures = {symbol: against(own, other, size) for symbol, own, other, size in each}
    return ModelCell(ours.words, right, ours.cycles, figures)


def against(ours: Estimate, exact: Estimate | None, size: float = 1.0) -> Compared:
    """A quantity of a model compared with the exact system's, if known."""
    own = ours.error / abs(ours.value)
    if exact is None:
        return Compared(size * ours.value, None, own)
    ratio = ours.value / exact.value
    return Compared(size * ours.value, ratio - 1.0, ratio * math.hypot(own, exact.error / exact.value))


def critical_r(model: str, scene: Scene) -> float:
    """The upper slab's r from which on steady sliding is unstable, both slabs scaled together; NaN if there is none."""
    try:
        return critical_round_trip(scene, model)[0]
    except NumericsError:
        return math.nan


def _onset(model: str, scene: Scene) -> Compared | None:
    """Onset of a model; for a full wave that of its equations, independent of the grid."""
    own, exact = (critical_r(one_port_of(one), scene) for one in (model, EXACT_MODEL))
    if not own > 0.0:
        return None
    return Compared(math.log10(own), None if model == EXACT_MODEL else own / exact - 1.0, _EXACTLY)


def relative_costs(models: Collection[str], cells: Mapping[str, int], scene: Scene, rounds: int) -> dict[str, float]:
    """Processor time of 1000 transits of march and event detection on the motion that each model has settled on, over that of the
    exact system: medians over `rounds` in which all are timed in turn. `cells`: of the full waves."""

    def work(model: str) -> March:
        """The timed march."""
        setting = Setting(model, cells=cells[model]) if model in cells else Setting(model, tolerance=_TOLERANCE)
        return March(setting, scene, _TRANSITS, _BEFORE)

    times = in_turn({model: work(model) for model in models}, rounds + 1)[1:]
    return {model: float(np.median([one[model] / one[EXACT_MODEL] for one in times])) for model in models}
