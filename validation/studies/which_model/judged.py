"""Verdicts on the tables of models, of the paper's scene and of others, and on the means of motions that never repeat. These are
of runs so long that their errors are small beside the 1 % that they judge (`validation.measure.on_record`); a report computes a
few again."""

import math
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise

import slipwave
from validation.measure.memo import critical_r
from validation.measure.on_record import motions
from validation.measure.regimes import AWAY, STEADY, TOLERANCE, UNKNOWN, UNTRIED, Regime
from validation.report import EXACT, PAPER, SELF, WITNESS, Outcome, Verdict, Verdicts, claim, every, holding, places, plain
from validation.report.compared import AS_CHEAP, EXACT_MODEL, GOOD, JUDGED, costs_of_good_reductions, is_good
from validation.report.known import ERRORS, error_after, error_of
from validation.report.model_table import ModelCell, ModelColumn, ModelRow, ModelTable
from validation.studies.which_model.motions import WAVE, paper_at, regime_at

ADVISED = ("modal:8", "modal:4", "fitted:4")
_AVOIDED = ("kelvin-voigt", "block8", "block12", "quasidynamic", "quasistatic")
_LADDER = ("modal:1", "modal:2", "modal:4", "modal:8")
_MODES = "The slabs’ exact modes give the exact cycle"
_TARGETS = {"modal:1": 1e-3, "modal:2": 1e-5}  # model -> largest error of the period of the paper's scene
_IN_SCENES = 1e-3  # largest relative error of the advised models in other scenes
_RUN_ERROR = {"T": 5e-9, "Δμ": 1e-8}  # what the tolerance of a run may leave, relative
_PRINTED = 1.0 - 70.73 / 73.5
_HALF_DIGITS = 0.05 / 73.5 + 0.005 / 70.73
_AGAIN = (-2.65, -2.5)
"""log10 r at which motions of the paper's scene are computed again. On a torus they stay near each other, so that means repeat;
an irregular motion differs between processors, so that its mean repeats within its error."""
_SHORT = 10000.0  # transits

Found = tuple[ModelColumn, ModelRow, ModelCell]
ByModel = Mapping[str, Mapping[float, Regime]]
"""model -> log10 r -> its regime."""


def cells_of(table: ModelTable, *models: str) -> list[Found]:
    """The cells of some models, or of all, in scenes in which they were tried."""
    rows = [row for row in table.rows if not models or row.model in models]
    return [
        (column, row, cell)
        for row in rows
        for column, cell in zip(table.columns, row.cells, strict=True)
        if cell.regime != UNTRIED
    ]


def _late(model: str, scene: str) -> float:
    """Onset of a model in a scene, over that of the exact system."""
    return critical_r(model, slipwave.read(scene)) / critical_r(EXACT_MODEL, slipwave.read(scene))


def regime_verdicts(table: ModelTable) -> Verdicts:
    """Regimes against onsets, which use no run; those of the advised models and of the full wave against the exact ones."""
    known = [
        (cell.regime == STEADY) == (column.over_onset < late)
        for column, row, cell in cells_of(table)
        if (late := _late(row.model, column.settings.split()[0])) and cell.regime not in UNKNOWN
    ]
    title = "Runs leave steady sliding where their model’s onset lies"
    yield every(title, WITNESS, sum(known), len(known), f"{table.name}: onsets from impedance, which know no run", "points")
    same = [cell.right for _, _, cell in cells_of(table, WAVE, *ADVISED)]
    title = "The full wave and the ODEs advised have the exact system’s regimes"
    yield every(title, WITNESS, sum(same), len(same), f"{table.name}: `{WAVE}`, {_named(ADVISED)}", "points")


def _named(models: Sequence[str]) -> str:
    return ", ".join(f"`{model}`" for model in models)


def wave_verdicts(table: ModelTable, on_coarse: Callable[[int], Regime], cells: int, run: float) -> Verdicts:
    """The full wave's cycles against the exact ones where these repeat, allowed what its grid with a cell less leads to in a
    column, and what the tolerance of the exact system's `run` leaves."""
    exact, fine = table.row(EXACT_MODEL).cells, table.row(WAVE).cells
    columns = [
        n for n, (cell, other) in enumerate(zip(exact, fine, strict=True)) if cell.figures and not cell.cycles and other.right
    ]
    coarse = {n: on_coarse(n).figures for n in columns}
    for symbol in JUDGED:
        off = max((fine[n].figures[symbol].size for n in columns), default=math.nan)
        left = max((abs(coarse[n][symbol].value / exact[n].figures[symbol].value - 1.0) for n in columns), default=math.nan)
        allowed = error_after(WAVE, left, cells - 1, cells) + run
        where = f"{table.name}, {symbol}: `{WAVE}`, {cells} cells, at {len(columns)} r"
        yield claim("The full wave has the exact system’s cycles where they repeat", WITNESS, off, allowed, where)


def mean_verdicts(table: ModelTable) -> Verdicts:
    """Means of wandering cycles against the exact ones: the full wave's are the same; those of many modes differ, but by less
    than a good model's may."""
    for model, limit, unit in ((WAVE, ERRORS, "standard errors"), (ADVISED[0], GOOD, "")):
        cells = [cell for _, _, cell in cells_of(table, model) if cell.cycles and cell.right]
        wander = [figure for cell in cells for symbol in JUDGED if (figure := cell.figures[symbol]).error is not None]
        off = [figure.size / (figure.standard_error if unit else 1.0) for figure in wander]
        if off:
            who = "the full wave has the exact system’s means" if unit else "eight modes have its means to 1 %"
            where = f"{table.name}, `{model}`: the largest of {len(off)} differences of T and Δμ"
            yield claim(f"Where cycles wander, {who}", WITNESS, max(off), limit, where, unit=unit)


def paper_verdicts(table: ModelTable, shown: Sequence[str], main: str) -> Verdicts:
    """Errors in the columns `shown`, where orbits repeat, and in the `main` one; the simplest model; costs."""
    errors = {
        symbol: {
            (row.model, column.title): cell.figures[symbol].error or 0.0 for column, row, cell in cells_of(table) if cell.figures
        }
        for symbol in JUDGED
    }
    for model, limit in _TARGETS.items():
        yield claim(_MODES, WITNESS, abs(errors["T"][model, main]), limit, f"paper, `{model}`: at log_{{10}} r = {main}")
    short = -errors["T"]["kelvin-voigt", main]
    yield holding(
        "The paper’s ODE falls short of the exact period by some 4 %",
        PAPER,
        f"{100 * _PRINTED:.2f} ± {100 * _HALF_DIGITS:.2f} %",
        f"{100 * short:.2f} %",
        abs(short - _PRINTED) < _HALF_DIGITS,
        f"printed: 70.73 against 73.5 transits, log_{{10}} r = {main}; half of the last printed digits is allowed",
    ).with_margin(abs(short - _PRINTED), _HALF_DIGITS)
    largest = {symbol: [max(abs(by_place[model, x]) for x in shown) for model in _LADDER] for symbol, by_place in errors.items()}
    left = max(later / sooner for series in largest.values() for sooner, later in pairwise(series))
    title = "Every doubling of the number of modes reduces the largest error over the range of r"
    remark = "T and Δμ; 1, 2, 4, 8 modes; at a single r an error may change its sign"
    words = f"of T: {', '.join(plain(value, '.0e') for value in largest['T'])}"
    yield claim(title, WITNESS, left, 1.0, remark, words, unit="of the error before")
    away = [cell.regime == AWAY for _, _, cell in cells_of(table, "quasistatic")]
    yield every("The quasi-static model runs away", EXACT, sum(away), len(away), "at every r", "points")
    yield _cost_verdict(table)


def _cost_verdict(table: ModelTable) -> Verdict:
    """Whether the exact system costs as little as any good ODE."""
    costs = costs_of_good_reductions(table)
    least = min(costs, default=math.inf)
    return holding(
        f"No ODE that is right to {100 * GOOD:g} % at every r shown costs less than the exact system",
        SELF,
        f"at least {1.0 / AS_CHEAP:.1f} of its time",
        f"~{{{least:.2g}}} of its time",
        least * AS_CHEAP >= 1.0,
        f"the least of {len(costs)} ratios of medians; run times vary by a tenth",
        Outcome.FINDING,
    ).with_margin(1.0 / AS_CHEAP / least, 1.0, "of times")


def run_verdict(regimes: ByModel) -> Verdict:
    """Last cycles of runs against the orbits of the same models, which Newton's method finds."""
    cells = (
        (model, x, regime, symbol)
        for model, by_r in regimes.items()
        for x, regime in by_r.items()
        if regime.ran
        for symbol in JUDGED
    )
    pairs = [
        (f"`{model}`, {symbol} at {places([x])}", symbol, regime.ran[symbol], regime.figures[symbol])
        for model, x, regime, symbol in cells
    ]
    sizes = [
        (abs(run.value / orbit.value - 1.0), error_of(run, orbit) + _RUN_ERROR[symbol], where)
        for where, symbol, run, orbit in pairs
    ]
    off, allowed, where = max(sizes, key=lambda pair: pair[0] / pair[1])
    title = "Runs whose cycles repeat have the period and the drop of the model’s orbit"
    return claim(title, WITNESS, off, allowed, f"{len(sizes)} figures; shown: {where}")


def scene_verdicts(table: ModelTable) -> Verdicts:
    """Whether the advice of the first table holds in other scenes."""
    repeat = [(row, cell) for _, row, cell in cells_of(table, *ADVISED) if cell.figures and not cell.cycles and cell.right]
    off = [cell.figures[symbol].size for _, cell in repeat for symbol in JUDGED]
    yield claim(_MODES, WITNESS, max(off, default=math.nan), _IN_SCENES, f"scenes: {_named(ADVISED)}, T and Δμ")
    good = [is_good(cell) for _, _, cell in cells_of(table, *ADVISED)]
    title = "The ODEs that the first table advises are good in every scene"
    yield every(title, WITNESS, sum(good), len(good), f"{_named(ADVISED)}; by the rule of the first table", "points")
    where = {(row.model, column.title) for column, row, _ in cells_of(table, *_AVOIDED)}
    wrong = {(row.model, column.title) for column, row, cell in cells_of(table, *_AVOIDED) if not is_good(cell)}
    fine = ", ".join(f"`{model}` in {scene}" for model, scene in sorted(where - wrong))
    title = "No model that the first table says to avoid is good in another scene"
    yield every(title, WITNESS, len(wrong), len(where), fine or "by the rule of the first table", "are wrong at some r")


def record_verdicts() -> Verdicts:
    """Whether the present code has the means on record."""
    places_of = {paper_at(x): x for x in _AGAIN}
    repeated = []
    for model, x, recorded in (
        (model, places_of[scene], recorded) for (model, scene), recorded in motions().items() if scene in places_of
    ):
        torus = recorded.words == "torus"
        now = regime_at(model, x, float(recorded.command.split()[2]) if torus else _SHORT)
        pairs = [(now.figures[symbol], recorded.figures[symbol]) for symbol in JUDGED if symbol in now.figures]
        off = max((abs(new.value - old.value) / (old.value if torus else new.error) for new, old in pairs), default=math.nan)
        if torus:
            repeated.append(off < 10.0 * TOLERANCE)
        else:
            title, where = "Means on record of irregular motions are those of shorter runs", f"`{model}` at {places([x])}"
            yield claim(title, SELF, off, ERRORS, f"{where}: T and Δμ, {_SHORT:g} transits", unit="standard errors")
    title = f"Means on record repeat on a torus, to {10.0 * TOLERANCE:g} of themselves"
    yield every(title, SELF, sum(repeated), len(repeated), f"at {places([_AGAIN[0]])}", "models")
