"""Every model in scenes unlike the paper's: unlike and layered slabs, a grip, a testing machine, another law, a rock in SI."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import cast

import numpy as np

import slipwave
from reduced.stability import scaled
from slipwave.scene import Scene
from validation.compute.models import family_of
from validation.study import WITNESS, Budget, Cell, Number, Omission, StudyResult, Table, Verdict, claim, every, table
from validation.study.advice import JUDGED, is_good
from validation.study.compared import EXACT_MODEL, Sight, compared_table, critical_r
from validation.study.model_table import Compared, ModelRow, ModelTable
from validation.study.regimes import STEADY, UNDECIDED, regime_of
from validation.study.text import minus

NAME = "beyond-one-scene"
QUESTION = "Does the advice hold in other scenes, and how far off is each model there?"
SCENES = {
    "unlike": "Slabs that differ: the lower one has twice the round trip and three times the impedance.",
    "grip": "Outer faces in grips that reflect half of every wave but keep the load.",
    "machine": "Slabs driven by a testing machine: spring, dashpot and mass.",
    "layered": "Slabs of two layers, the outer one with twice the impedance.",
    "slip-law": "The paper’s slabs under Ruina’s slip law.",
    "rock": "Table 1’s rock in SI, at 1 cm/s, by the thickness of one slab.",
}
"""Scene of the gallery -> its description."""
SECONDS = (6.0, 18.0)

MODELS = ("delay", "dg:7", "modal:8", "modal:4", "modal:2", "modal:1", "fitted:4", "kelvin-voigt", "block8", "block12")
SIMPLEST = ("quasidynamic", "quasistatic")
_WAVE, _CELLS = "dg:7", 3
_AS_WAVES = ("modal:8", "modal:4", "fitted:4")
_OVER_ONSET = {True: (1.02, 1.25), False: (1.02, 1.1, 1.25)}
"""Quick report -> r over the onset of the exact system, both slabs scaled together."""
_QUICK = ("unlike", "grip", "rock")
_NEAR = 1.1
_UNTIL = {True: 4000.0, False: 5000.0}
_LONGER = {"rock": 1.7}  # its cycles are twice as long
_NUDGE = 0.5  # of ψ: a small one grows for thousands of transits near the onset; from 2 the ODE runs away under the slip law
_ERRORS = 4.0  # standard errors
_WAVE_ERROR, _MODES = {True: 4e-9, False: 4e-7}, 1e-3  # relative; the full report's r reach further


def run(budget: Budget) -> StudyResult:
    """Every model in every scene at every r, and the bias and the scatter of each over all of them."""
    names = _QUICK if budget.quick else SCENES
    tables = tuple(
        models_in(name, _OVER_ONSET[budget.quick], _LONGER.get(name, 1.0) * _UNTIL[budget.quick]) for name in budget.each(names)
    )
    rows = bias_rows(tables)
    return StudyResult(
        answer=_answer(rows, tables),
        tables=(_bias_table(rows),),
        verdicts=(*_waves(tables, _WAVE_ERROR[budget.quick]), _onsets(tables), *_reductions(tables), _avoided(tables)),
        numbers=_numbers(tables),
        omissions=(
            Omission(
                "Costs in these scenes.",
                "They are those of `which-model`, but for slabs that differ: two are marched instead of one.",
            ),
        ),
        model_tables=tables,
    )


def models_in(name: str, over_onset: Sequence[float], until: float) -> ModelTable:
    """The table of every model that can compute the scene."""
    sights = [sight(name, factor) for factor in over_onset]
    able = [model for model in (*MODELS, *SIMPLEST) if (family := family_of(model)) and not family.refusal(sights[0].scene)]
    models = [model for model in able if model != "fitted:4" or "modal:4" not in able]
    regimes = {
        model: [regime_of(model, one.scene, until, _CELLS if model == _WAVE else None) for one in sights] for model in models
    }
    return compared_table(name, f"{SCENES[name]} {_TABLE}", sights, regimes, parameter="r/r_{c}")


def sight(name: str, over_onset: float) -> Sight:
    """The scene with both slabs scaled together to r = `over_onset` times the onset of the exact system."""
    own = slipwave.read(name)
    factor = over_onset * critical_r(EXACT_MODEL, own) / own.transit
    scene = scaled(replace(own, start=replace(own.start, size=_NUDGE)), round_trip=factor)
    settings = f"{_settings(own, factor)} --set start.size={_NUDGE:g}"
    thickness = f" ({1e3 * _metres(scene):.0f} mm)" if scene.units and scene.upper.material else ""
    return Sight(f"{over_onset:.2f}{thickness}", scene, over_onset, settings)


def _settings(own: Scene, factor: float) -> str:
    """The command line options that make the slabs thicker by `factor`."""
    if own.upper.material:
        return f"--set slab.thickness={factor * _metres(own):.6g}"
    slabs = {"slab": own.upper} if own.alike else {"upper": own.upper, "lower": own.lower}
    return " ".join(f"--set {key}.r={factor * slab.round_trip:.7g}" for key, slab in slabs.items())


def _metres(scene: Scene) -> float:
    """Thickness of the upper slab, in m."""
    assert scene.units
    assert scene.upper.material
    return 0.5 * scene.transit * scene.units.time * scene.upper.material.wave_speed


_TABLE = (
    "Errors against the exact delay system at r over its onset r_{c}, both slabs scaled together, by runs from a nudge of 0.5: "
    "of the last cycles where they repeat, of means elsewhere, with two standard errors. Advice by the rule of the first table."
)


def errors_over(tables: Sequence[ModelTable], model: str, symbol: str, low: float, high: float) -> list[Compared]:
    """Every known error of a quantity at r over the onset between `low` and `high`."""
    rows = [(one, row) for one in tables for row in one.rows if row.model == model]
    cells = [
        cell for one, row in rows for column, cell in zip(one.columns, row.cells, strict=True) if low < column.over_onset <= high
    ]
    return [cell.figures[symbol] for cell in cells if symbol in cell.figures and cell.figures[symbol].error is not None]


def bias_and_scatter(errors: Sequence[Compared]) -> tuple[float, float, float]:
    """(mean, standard deviation over scenes, root mean square of the standard errors); NaN for too few errors."""
    values = np.array([one.error for one in errors], dtype=float)
    own = np.array([one.standard_error for one in errors])
    if not values.size:
        return math.nan, math.nan, math.nan
    return float(values.mean()), float(values.std(ddof=1)) if values.size > 1 else math.nan, float(np.sqrt((own**2).mean()))


def bias_rows(tables: Sequence[ModelTable]) -> dict[str, list[float]]:
    """Model -> bias, scatter and statistical error of T up to 1.1 r_c, of Δμ there, of T beyond; number of right regimes, and of
    all columns."""
    rows = {}
    for model in dict.fromkeys(row.model for one in tables for row in one.rows if row.model != EXACT_MODEL):
        ranges = (("T", 0.0, _NEAR), ("Δμ", 0.0, _NEAR), ("T", _NEAR, math.inf))
        numbers = [value for what in ranges for value in bias_and_scatter(errors_over(tables, model, *what))]
        cells = [cell for one in tables for row in one.rows if row.model == model for cell in row.cells]
        rows[model] = [*numbers, sum(cell.right for cell in cells), len(cells)]
    return rows


def _bias_table(rows: dict[str, list[float]]) -> Table:
    each = "bias [%] .2f | scatter [%] .2f | statistical [%] .2f"
    near = f"up to {_NEAR:g} r_{{c}}"
    heading = f"model | T {near}: {each} | Δμ {near}: {each} | T beyond: {each} | regime right .0f | of .0f"
    caption = (
        "Bias (mean of the errors) and scatter (their standard deviation) of each model over all these scenes and r, and the "
        "part of the scatter that the means themselves have (root mean square of their standard errors). A dash: no cycles."
    )
    shown = [[model, *(100.0 * value for value in numbers[:-2]), *numbers[-2:]] for model, numbers in rows.items()]
    return table("bias", caption, heading, cast(list[list[Cell]], shown))


def _answer(rows: dict[str, list[float]], tables: Sequence[ModelTable]) -> str:
    known = {model: numbers for model, numbers in rows.items() if math.isfinite(numbers[0])}
    words = [f"`{model}` {bias_in_words(numbers[0], numbers[1])}" for model, numbers in known.items() if model != _WAVE]
    lost = [f"`{model}` {where}" for model in rows if (where := _silent(tables, model))]
    silent = f" Without cycles: {'; '.join(lost)}." if lost else ""
    return (
        f"Bias and scatter of T up to {_NEAR:g} r_{{c}} over {len(tables)} scenes ({', '.join(one.name for one in tables)}): "
        f"{', '.join(words)}.{silent}"
    )


def bias_in_words(bias: float, scatter: float) -> str:
    """Bias and scatter, in per cent."""
    return minus(f"{100 * bias:+z.1f}{f' ± {100 * scatter:.1f}' if math.isfinite(scatter) else ''} %")


def _silent(tables: Sequence[ModelTable], model: str) -> str:
    """Text on where a model has no cycles."""
    every = [(one.name, row) for one, row in _pairs(tables, [model])]
    silent = [(name, cell.regime) for name, row in every for cell in row.cells if not cell.figures and cell.regime != UNDECIDED]
    where = list(dict.fromkeys(name for name, _ in silent))
    named = "every scene" if len(where) == len(every) else ", ".join(where)
    return f"{' or '.join(dict.fromkeys(regime for _, regime in silent))} in {named}" if silent else ""


def _pairs(tables: Sequence[ModelTable], models: Sequence[str]) -> Iterator[tuple[ModelTable, ModelRow]]:
    return ((one, row) for one in tables for row in one.rows if row.model in models)


def _worst(tables: Sequence[ModelTable], models: Sequence[str], wanders: bool) -> list[float]:
    """Errors of T and Δμ where cycles repeat; in standard errors where they wander."""
    found = []
    for _, row in _pairs(tables, models):
        figures = [
            cell.figures[symbol]
            for cell in row.cells
            if bool(cell.cycles) == wanders and cell.right
            for symbol in JUDGED
            if cell.figures
        ]
        found += [abs(one.error or 0.0) / (one.standard_error if wanders else 1.0) for one in figures]
    return found


def _waves(tables: Sequence[ModelTable], limit: float) -> Iterator[Verdict]:
    repeats, wanders = (_worst(tables, [_WAVE], one) for one in (False, True))
    where = f"`{_WAVE}`, {_CELLS} cells; T and Δμ at {len(repeats) // 2} values of r of {len(tables)} scenes"
    title = "The full wave has the delay system’s cycles in every scene where they repeat"
    yield claim(title, WITNESS, max(repeats, default=math.nan), limit, where)
    if wanders:
        title, where = "The full wave has the delay system’s means in every scene where cycles wander", "differences of T and Δμ"
        yield claim(title, WITNESS, max(wanders), _ERRORS, f"the largest of {len(wanders)} {where}", unit="standard errors")


def _onsets(tables: Sequence[ModelTable]) -> Verdict:
    """Verdict: regimes of runs against onsets by impedance."""
    known = [
        (cell.regime == STEADY) == (column.log10_r < row.onset.value)
        for one in tables
        for row in one.rows
        for column, cell in zip(one.columns, row.cells, strict=True)
        if row.onset and cell.regime != UNDECIDED
    ]
    title = "In every scene runs leave steady sliding where their model’s onset lies"
    return every(title, WITNESS, sum(known), len(known), "onsets from impedance, which use no run", "values of r")


def _reductions(tables: Sequence[ModelTable]) -> Iterator[Verdict]:
    off = max(_worst(tables, _AS_WAVES, wanders=False), default=math.nan)
    title = "Four modes, eight modes and a rational fit have the exact cycles in every scene where they repeat"
    yield claim(title, WITNESS, off, _MODES, f"{', '.join(f'`{model}`' for model in _AS_WAVES)}; T and Δμ, relative")
    good = [is_good(cell) for _, row in _pairs(tables, _AS_WAVES) for cell in row.cells]
    title = "The ODEs that the first table advises are good in every scene"
    where = "`modal:8` and `modal:4`, or `fitted:4` where outer faces are not rigid; good by the rule of the first table"
    yield every(title, WITNESS, sum(good), len(good), where, "values of r")


def _avoided(tables: Sequence[ModelTable]) -> Verdict:
    """Verdict: the models that the first table says to avoid."""
    models = ("kelvin-voigt", "block8", "block12", *SIMPLEST)
    pairs = list(_pairs(tables, models))
    fine = [f"`{row.model}` in {one.name}" for one, row in pairs if all(map(is_good, row.cells))]
    title, where = "No model that the first table says to avoid is good in another scene", "by the rule of the first table"
    return every(title, WITNESS, len(pairs) - len(fine), len(pairs), ", ".join(fine) or where, "are wrong at some r")


def _numbers(tables: Sequence[ModelTable]) -> dict[str, Number]:
    """Errors of T where cycles repeat, with the accuracy of runs; means of irregular motion differ between machines."""
    return {
        f"{one.name}: {row.model} error of T at {column.over_onset:g}": Number(found.error, max(1e-3, 3e-7 / abs(found.error)))
        for one, row in _pairs(tables, (*MODELS, *SIMPLEST))
        for column, cell in zip(one.columns, row.cells, strict=True)
        if not cell.cycles and column.group == "periodic" and row.model != _WAVE
        if (found := cell.figures.get("T")) and found.error
    }
