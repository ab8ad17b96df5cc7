"""The chart of a fit: friction and residual of each record, and above them the best values with their intervals."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from slipwave.observe.pieces import Array
from validation.chart import GUIDE, INK, POINTS, Chart, Panel, Scale, Trace
from validation.chart.looks import model_line
from validation.commands.comparison import barred
from validation.fit.records import Experiment

_MEASURED = "#7fb0d6"
_PREFIXES = {-9: "n", -6: "μ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}
_LABELS = {"a_star": "$a_*$", "a": "$a$", "b": "$b$", "memory_length": "$L$", "reference_velocity": "$V_*$"}
_IN_A_LINE = 4
_FEW = 200  # points, that are drawn large, with twice their standard errors
_SURE = 2.0


def chart_of_fit(
    records: Sequence[Experiment], fitted: Sequence[Array], model: str, parameters: Mapping[str, Mapping[str, Any]], is_si: bool
) -> Chart:
    """Measured and fitted friction over the displacement of the load point, or over time where it rests for a while."""
    count = len(records)
    above, below = list[Panel](), list[Panel]()
    for record, values in zip(records, fitted, strict=True):
        along, name = _along(record, is_si)
        measured, ours = record.friction[record.shown], values[record.shown]
        are_few = measured.size <= _FEW
        look = POINTS.but(color=_MEASURED, marker=".", size=5.0 if are_few else 1.5)
        seen = "measured" if record.cycle is None else "mean cycle" if are_few else "all cycles"
        lines = [Trace(seen, along, measured, look), model_line(model, along, ours, color=INK, dashes="-")]
        bars = _SURE / np.asarray(record.weight)[record.shown] if are_few and np.ndim(record.weight) else None
        rest = [Trace("residual", along, measured - ours, look, y_error=bars), Trace("", [-np.inf, np.inf], [0.0, 0.0], GUIDE)]
        title = Path(record.name).name if count > 1 else ""
        above.append(Panel(title, Scale(name), Scale("friction"), lines, legend="" if above else "best"))
        below.append(Panel("", Scale(name), Scale("residual"), rest))
    width, height = 8.0 if count < 3 else 3.4 * count, 4.0 if count == 1 else 4.6
    return Chart([*above, *below], height, count, width, heights=(3.0, 1.0), title=values_in_words(parameters))


def _along(record: Experiment, is_si: bool) -> tuple[Array, str]:
    """Abscissa of a record's figure, and its name: displacement of the load point, or time where it rests (a hold would be one
    point)."""
    if record.cycle is not None:
        period = f"{record.cycle.period:.4g} {'s' if is_si else 'transits'}"
        return record.times[record.shown] / record.cycle.period, f"time since the last slip event / mean period ({period})"
    if 0.0 in record.schedule.velocities:
        return record.times[record.shown], "time / s" if is_si else "time / transits"
    size, unit = (1e6, "μm") if is_si else (1.0, "$L$")
    return size * record.travel[record.shown], f"displacement of the load point / {unit}"


def values_in_words(parameters: Mapping[str, Mapping[str, Any]]) -> str:
    """Text of the best values with half the width of their 95 % intervals."""
    said = [_in_words(key, row) for key, row in parameters.items()]
    lines = [",   ".join(said[k : k + _IN_A_LINE]) for k in range(0, len(said), _IN_A_LINE)]
    return "\n".join(lines) + "   (95 %)"


def _in_words(key: str, row: Mapping[str, Any]) -> str:
    word, value, unit = key.rpartition(".")[2], row["value"], row["unit"]
    label = _LABELS.get(word, word.replace("_", " "))
    power = 3 * math.floor(math.log10(abs(value)) / 3.0) if unit and value else 0
    size = 10.0 ** (power if power in _PREFIXES else 0)
    half = 0.5 * (row["high"] - row["low"]) / size
    text = barred(value / size, half).replace("+-", "±") if row["determined"] else f"{value / size:.3g}, not determined"
    unit = f" {_PREFIXES.get(power, '')}{unit}" if unit else ""
    return f"{label} = ({text}){unit}" if unit and row["determined"] else f"{label} = {text}{unit}"
