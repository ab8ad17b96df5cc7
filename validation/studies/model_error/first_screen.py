"""The table of the first screen, from what this study measures."""

import math

from slipwave.observe.statistics import Estimate
from validation.references.onset import onset_of
from validation.studies.model_error.measured import DAMPED, MODELS, SHOWN, TIMED_AT, Runs, error
from validation.study.model_table import Compared, ModelCell, ModelColumn, ModelQuantity, ModelRow, ModelTable
from validation.study.over_r import scene_at
from validation.study.text import places

_QUANTITIES = (ModelQuantity("T", "period", "transits"), ModelQuantity("Δμ", "stress drop", "σ"))
_IN = {"T": "period", "Δμ": "drop"}


def first_table(orbits: Runs, means: Runs, times: dict[str, float]) -> ModelTable:
    """Models over r: errors of the orbits where the exact one is stable, of means beyond."""
    scene = scene_at(TIMED_AT)
    onset = math.log10(onset_of(scene.law, scene.upper.epsilon, scene.velocity).r_delay)
    columns = [
        ModelColumn(places([x]), x, 10.0 ** (x - onset), "periodic" if x in SHOWN else "torus, irregular")
        for x in (*SHOWN, *means["delay"])
    ]
    rows = []
    for model in ("delay", *MODELS, DAMPED):
        cells = tuple(_cell(orbits if column.log10_r in SHOWN else means, model, column.log10_r) for column in columns)
        rows.append(ModelRow(model, cells, None, (times[model] / times["delay"],), "", ""))
    caption = "Errors of orbits, and of means over cycles where no orbit of the delay system is stable."
    return ModelTable("paper", caption, "log_{10} r", _QUANTITIES, tuple(columns), (places([TIMED_AT]),), "delay", tuple(rows))


def _cell(runs: Runs, model: str, log10_r: float) -> ModelCell:
    found = runs[model].get(log10_r)
    if found is None:
        return ModelCell("slides steadily", False)
    figures = {symbol: _compared(runs, model, log10_r, getattr(found, name), name) for symbol, name in _IN.items()}
    return ModelCell("periodic" if log10_r in SHOWN else "cycles", True, 0, figures)


def _compared(runs: Runs, model: str, log10_r: float, own: Estimate, name: str) -> Compared:
    if model == "delay":
        return Compared(own.value, None, own.error / own.value)
    off = error(runs, model, log10_r, name)
    return Compared(own.value, off.value, off.error)
