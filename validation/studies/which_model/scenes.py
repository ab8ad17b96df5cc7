"""Every model in scenes unlike the paper's: unlike and layered slabs, a grip, a testing machine, another law, a rock in SI."""

import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import product

import numpy as np

import slipwave
from validation.measure.in_words import able
from validation.measure.regimes import UNTRIED, Regime, regime_of
from validation.report import Cell, Number, Table, table
from validation.report.compared import EXACT_MODEL, compared_table, critical_r
from validation.report.model_table import ModelColumn, ModelRow, ModelTable
from validation.report.text import minus

SCENES = {
    "unlike": "slabs that differ, the lower one with twice the round trip and three times the impedance",
    "grip": "outer faces in grips that reflect half of every wave but keep the load",
    "machine": "slabs driven by a testing machine: spring, dashpot and mass",
    "layered": "slabs of two layers, the outer one with twice the impedance",
    "slip-law": "the paper’s slabs under Ruina’s slip law",
    "rock": "Table 1’s rock in SI, at 1 cm/s",
}
"""Scene of the gallery -> its description."""
OVER_ONSET = (1.02, 1.25)
"""r over the onset of the exact system, both slabs scaled together."""
_NONE = 1e-3  # a bias that is not mentioned
_NUDGE = 0.5  # of ψ: a small one grows for thousands of transits near the onset; from 2 the ODE runs away under the slip law


Place = tuple[ModelColumn, slipwave.Scene]
"""A column and its scene."""


def place(name: str, over_onset: float) -> Place:
    """A scene with both slabs scaled together to r = `over_onset` times the onset of the exact system, and its column."""
    own = slipwave.read(name)
    factor = over_onset * critical_r(EXACT_MODEL, own) / own.transit
    settings = [*_settings(own, factor), f"start.size={_NUDGE:g}"]
    scene, words = slipwave.read(name, settings), " ".join(f"--set {one}" for one in settings)
    return ModelColumn(name, math.log10(scene.transit), over_onset, f"r = {over_onset:.2f} r_{{c}}", f"{name} {words}"), scene


def _settings(own: slipwave.Scene, factor: float) -> list[str]:
    """The settings that make the slabs thicker by `factor`."""
    if own.upper.material and own.units:
        return [f"slab.thickness={factor * 0.5 * own.transit * own.units.time * own.upper.material.wave_speed:.6g}"]
    slabs = {"slab": own.upper} if own.alike else {"upper": own.upper, "lower": own.lower}
    return [f"{key}.r={factor * slab.round_trip:.7g}" for key, slab in slabs.items()]


def places_of(names: Iterable[str] = tuple(SCENES)) -> list[Place]:
    """Columns and scenes of the table, by r over the onset."""
    return [place(name, over_onset) for over_onset, name in product(OVER_ONSET, names)]


def regime_there(model: str, where: Place, until: float, cells: int | None, tolerance: float) -> Regime:
    """The regime of a run to `until`, and its orbit to the `tolerance`; UNTRIED where the model cannot compute the scene, or
    where a rational fit would find the modes of another model."""
    scene = where[1]
    if not able(model, scene) or (model.startswith("fitted:") and able(f"modal:{model[7:]}", scene)):
        return Regime(UNTRIED)
    return regime_of(model, scene, until, cells, tolerance)


def scene_table(places: Sequence[Place], regimes: Mapping[str, Sequence[Regime]]) -> ModelTable:
    """The table of models over scenes."""
    words = "; ".join(f"`{name}`: {what}" for name, what in SCENES.items() if any(name == one.title for one, _ in places))
    caption = (
        f"Errors at r over the onset r_{{c}} of the exact system, by runs from a nudge of {_NUDGE:g}, with advice by the rule of "
        f"the first table, in other scenes ({words}); –: not for this scene."
    )
    return compared_table("scenes", caption, "scene", [column for column, _ in places], regimes, {}, {})


def bias_table(found: ModelTable) -> Table:
    """Bias and scatter of each model over all scenes."""
    ranges = (("T", OVER_ONSET[0]), ("Δμ", OVER_ONSET[0]), ("T", OVER_ONSET[1]))
    rows: list[list[Cell]] = [
        [row.model, *(100.0 * value for what in ranges for value in _bias_and_scatter(found, row, *what))]
        for row in found.rows[1:]
    ]
    numbers = "bias [%] .2f | scatter [%] .2f | statistical [%] .2f"
    heading = " | ".join(["model", *(f"{symbol}, {over_onset:g} r_{{c}}: {numbers}" for symbol, over_onset in ranges)])
    caption = (
        "Bias (mean error) and scatter (standard deviation) of each model over these scenes, and the part of the scatter that "
        "means themselves have (root mean square of their standard errors). A dash: no cycles."
    )
    return table("bias", caption, heading, rows)


def _bias_and_scatter(found: ModelTable, row: ModelRow, symbol: str, over_onset: float) -> tuple[float, float, float]:
    """(mean, standard deviation over scenes, root mean square of the standard errors) of the errors of a quantity at this r over
    the onset; NaN for too few errors."""
    cells = [cell for column, cell in zip(found.columns, row.cells, strict=True) if column.over_onset == over_onset]
    errors = [one for cell in cells if (one := cell.figures.get(symbol)) and one.error is not None]
    values, own = (np.array([getattr(one, name) for one in errors], dtype=float) for name in ("error", "standard_error"))
    if not values.size:
        return math.nan, math.nan, math.nan
    return float(values.mean()), float(values.std(ddof=1)) if values.size > 1 else math.nan, float(np.sqrt((own**2).mean()))


def scene_answer(found: ModelTable) -> str:
    """Whether the advice holds in these scenes, and how far off the models to be avoided are near the onset."""
    good = [f"`{row.model}`" for row in found.rows[1:] if row.advice == "use"]
    known = ((row.model, _bias_and_scatter(found, row, "T", OVER_ONSET[0])) for row in found.rows if row.advice == "avoid")
    words = [
        f"`{model}` " + minus(f"{100 * bias:+z.1f}{f' ± {100 * scatter:.1f}' if math.isfinite(scatter) else ''} %")
        for model, (bias, scatter, _) in known
        if abs(bias) > _NONE
    ]
    count, near = len({column.title for column in found.columns}), f"{OVER_ONSET[0]:g} r_{{c}}"
    return (
        f"The advice holds in {count} other scenes: {', '.join(good)} are right to 1 %. Bias and scatter of T at {near} "
        f"are {', '.join(words)}; `quasidynamic` slides steadily."
    )


def scene_numbers(found: ModelTable, models: Sequence[str]) -> dict[str, Number]:
    """Errors of T of these models where cycles repeat, with the accuracy of runs."""
    return {
        f"{column.title}: {row.model} error of T at {column.over_onset:g}": Number(one.error, max(1e-3, 3e-7 / abs(one.error)))
        for row in found.rows
        for column, exact, cell in zip(found.columns, found.rows[0].cells, row.cells, strict=True)
        if row.model in models and not cell.cycles and not exact.cycles and (one := cell.figures.get("T")) and one.error
    }
