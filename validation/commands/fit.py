"""`slipwave fit`: Parameters of a scene from measured friction, by least squares, with 95 % intervals."""

import math
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import field, replace
from functools import cached_property
from itertools import chain
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from slipwave.errors import NumericsError, SceneError
from slipwave.extras import require
from slipwave.family import features_of
from slipwave.files import FIGURES
from slipwave.friction.law import name_of
from slipwave.input.assemble import SceneSource, is_stored
from slipwave.input.stored import read_stored
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from validation.chart import GUIDE, INK, POINTS, Chart, Panel, Scale, Trace
from validation.chart.looks import model_line
from validation.commands.comparison import barred
from validation.commands.options import ModelOptions, RecordOptions, command, model_option, option
from validation.commands.reasons import PREFIXES, power_of
from validation.commands.result import Output, Result, aligned, rounded
from validation.commands.wording import header
from validation.data.datasets import Dataset
from validation.data.series import Series, read_series
from validation.fit.by_orbits import fitted_orbit
from validation.fit.least_squares import BestValues, Intervals, Solution, at_bounds, intervals, minimise, profiled
from validation.fit.orbits import MOST_TRANSITS, CycleOfOrbit
from validation.fit.parameters import NUISANCES, FreeParameter, Variants, begun, schedule_of, sizes
from validation.fit.problem import FrictionProblem, problem_of
from validation.fit.records import Experiment, experiment_of
from validation.models.by_name import family_of
from validation.models.own import digests
from validation.models.progress import log
from validation.models.provenance import provenance

_TOLERANCE = 1e-7
_ASTRAY, _UNEXPLAINED = 1.3, 3.0  # times the noise: a residual that needs a word, and that fails

_MEASURED = "#7fb0d6"
_LABELS = {"a_star": "$a_*$", "a": "$a$", "b": "$b$", "memory_length": "$L$", "reference_velocity": "$V_*$"}
_PREFIXED = ("m", "m/s", "s", "Pa", "Pa/m", "Pa s/m", "N/m", "N s/m")
_IN_A_LINE = 4
_FEW = 200  # points, that are drawn large, with twice their standard errors
_SURE = 2.0

_CHEAP = "quasidynamic"
_BLOCK = "fitted:0"
_LADDER = ("quasistatic", _CHEAP, "block12", _BLOCK, "delay")
"""Each has more of a scene than those before."""

_NO_BLOCK = {"kelvin-voigt", "standard-linear", "reflection"}


class _FitOptions(RecordOptions, ModelOptions):
    """Options of `slipwave.fit`."""

    EXAMPLES: ClassVar = (
        "slipwave fit granite.toml --data steps.csv --free interface.a,interface.b,interface.memory_length",
        "slipwave fit granite.toml --data a.csv --data b.csv --free a,b,memory_length,level --model delay --out fit.nc",
    )

    model: str = model_option(f"{_CHEAP}, or {_BLOCK} for a machine with a mass")
    data: Iterable[str | Path] = option(
        "a record, CSV or columns of text: time and friction (or shear stress), perhaps the load point's displacement; may be "
        "repeated",
        (),
        metavar="FILE ...",
        stored=True,
    )
    free: Iterable[str] | Mapping[str, float | str] = option(
        "what is fitted: keys of the scene, with commas; NAME=START: a variable that a --set names; level and drift: of the "
        "friction of each record",
        (),
        metavar="KEY,KEY",
        stored=True,
    )
    window: str | None = option(
        "only the samples from BEGIN to END of the files' own time count; the load before moves the model all the same",
        metavar="BEGIN:END",
        stored=True,
    )
    checkpoint: Path | None = option(
        "keep the best values here during the fit, and go on from them if FILE exists", metavar="FILE.json"
    )
    tol: float | None = option("relative error of the model's motion", stored=True)

    @property
    def words(self) -> list[str]:
        """What is fitted, one by one."""
        texts = [f"{name}={start}" for name, start in self.free.items()] if isinstance(self.free, Mapping) else _listed(self.free)
        return [word.strip() for text in texts for word in text.split(",") if word.strip()]

    @property
    def varied(self) -> tuple[str, ...]:
        """The names of what is fitted."""
        return tuple(word.partition("=")[0].strip() for word in self.words)


class FitResult(Result):
    """The best values of a `problem` so far."""

    OUTPUTS: ClassVar = (
        Output("--out", (".nc",), "to_netcdf", "keep records, fitted friction and parameters: .nc"),
        Output("--plot", FIGURES, "save_plot", "draw friction and residual: .png, .pdf or .svg"),
    )

    scene: Scene
    model: str
    problem: FrictionProblem
    solution: Solution
    spread: Intervals
    wall_s: float
    options: Mapping[str, Any] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()

    @property
    def parameters(self) -> dict[str, dict[str, Any]]:
        """Key -> value, ends of the 95 % interval, unit, whether the data determine it, and start value."""
        rows = {}
        free = dict(enumerate(self.problem.free))
        for k, name in enumerate(self.problem.names):
            key = free.get(k)
            numbers = [self.solution.inner[k], self.spread.low[k], self.spread.high[k]]
            value, low, high = (key.value(float(x)) if key else float(x) for x in numbers)
            row = {"value": value, "low": low, "high": high, "unit": key.shown_unit if key else ""}
            rows[name] = row | {"determined": bool(self.spread.determined[k]), "start": key.start if key else 0.0}
        return rows

    @property
    def facts(self) -> dict[str, Any]:
        """As `Result`."""
        names, parameters = self.problem.names, self.parameters
        pairs = zip(self.problem.records, self._friction, strict=True)
        residual = np.concatenate([(record.friction - fitted)[record.shown] for record, fitted in pairs])
        rows = zip(names, self.spread.correlation.tolist(), strict=True)
        return {
            "scene": self.scene.name,
            "model": self.model,
            "data": [*map(_facts_of, self.problem.records, self._friction)],
            "parameters": parameters,
            "determined": {name: row["determined"] for name, row in parameters.items()},
            "correlation": {name: dict(zip(names, row, strict=True)) for name, row in rows},
            "residual": {
                "rms": float(np.sqrt(np.mean(residual**2))),
                "largest": float(np.abs(residual).max()),
                "over_noise": self.spread.noise,
                "together": self.spread.together,
                "samples": residual.size,
            },
            "evaluations": self.solution.evaluations,
            "wall_s": self.wall_s,
            "notes": self.notes,
        }

    @property
    def notes(self) -> list[str]:
        """Remarks on the numbers."""
        notes = ["the values are the best so far; no interval is stated, because they are no minimum"]
        notes = [*(notes if np.isnan(self.spread.low).all() else []), *self.remarks]
        for record in self.problem.records:
            notes += [f"{record.name}: {line}" for line in record.notes]
        notes += [f"not determined: {line}" for line in self.spread.singular]
        if self.spread.profiled:
            notes.append(f"the interval of {' and '.join(self.spread.profiled)} is by profile: the derivative's is another")
        if self.spread.noise > _ASTRAY and not self.failed:
            cause = "a part of the record (--window) or the model is not what the other is, or the fit ended off its best values"
            notes.append(f"the residual is {self.spread.noise:.1f} times the noise, and the intervals do not know why: {cause}")
        together = self.spread.together
        if together > 2.0:
            wider = f"the intervals are {together**0.5:.1f} times as wide as those of white noise"
            notes.append(f"{together:.0f} neighbouring residuals fluctuate together: {wider}")
        return notes

    def lines(self, summary: Mapping[str, Any]) -> Iterator[str]:
        """The parameters with their intervals, and the residual."""
        yield from header(self.scene)
        yield from (f"set {key} = {text}" for key, text in self.options.get("set", {}).items())
        residual = summary["residual"]
        size = f"{residual['samples']} samples, residual {residual['rms']:.4g} (root mean square)"
        yield f"model {self.model}: {size}, {self.wall_s:.3g} s"
        yield ""
        rows = [
            [key, *(rounded(row[name], 6) for name in ("value", "low", "high")), row["unit"], "" if row["determined"] else "no"]
            for key, row in summary["parameters"].items()
        ]
        yield from aligned(["parameter", "value", "95 % from", "to", "unit", "determined"], rows)
        for note in summary["notes"]:
            yield f"note: {note}"

    def to_go_on(self, options: Any) -> str:
        """As `Result`."""
        return "with --checkpoint FILE.json the same command goes on; with --out FILE.nc, slipwave fit FILE.nc does"

    @cached_property
    def _friction(self) -> list[Array]:
        return self.problem.friction(self.solution.inner)

    @cached_property
    def dataset(self) -> Dataset:
        """Parameters with intervals and correlation, and every record with the fitted friction."""
        require("files", "a dataset")
        import xarray

        names = list(self.problem.names)
        rows = self.parameters
        columns: dict[str, Any] = {
            name: ("parameter", [rows[key][name] for key in names], {"long_name": words, "units": "1"})
            for name, words in {
                "value": "best value, in `unit`",
                "low": "lower end of the 95 % interval",
                "high": "upper end",
            }.items()
        }
        columns["unit"] = ("parameter", np.array([rows[key]["unit"] for key in names], dtype=object), {"long_name": "unit"})
        columns["correlation"] = (("parameter", "other"), self.spread.correlation, {"long_name": "correlation", "units": "1"})
        records = self.problem.records
        whose = [np.full(record.times[record.shown].size, k) for k, record in enumerate(records)]
        fitted = [values[record.shown] for record, values in zip(records, self._friction, strict=True)]
        pure, clock = {"units": "1"}, {"units": "s"} if self.scene.units else {"units": "1", "in_units_of": "transit"}
        for name, values, words, unit in (
            ("record", whose, "number of the record", pure),
            (
                "record_time",
                [record.times[record.shown] for record in records],
                "time since the start of the scene, or the event",
                clock,
            ),
            ("measured", [record.friction[record.shown] for record in records], "measured friction", pure),
            ("fitted", fitted, "friction of the fitted model", pure),
        ):
            columns[name] = ("sample", np.concatenate(values), {"long_name": words} | unit)
        attributes = provenance("fit", self.scene, self.model, self.options)
        return xarray.Dataset(columns, {"parameter": names, "other": names}, attributes)

    def chart(self) -> Chart:
        """Friction and residual of each record, and the values with their intervals."""
        return _chart(self.problem.records, self._friction, self.model, self.parameters, self.scene.units is not None)


@command
def fit(source: SceneSource, options: _FitOptions) -> FitResult:
    """Parameters of a scene from measured friction, by least squares, with 95 % intervals and a list of what the data do not
    determine.

    Raises SceneError for wrong input; NumericsError, with the best values as its `result`, if there is no minimum, a parameter
    ends at a bound, or the data do not determine one.
    """
    began = time.perf_counter()
    options = _going_on(source, options)
    files, words, scenes = _listed(options.data), options.words, options.scenes_of(source)
    options = replace(options, data=files)
    if not set(words).difference(NUISANCES):
        raise SceneError("--free: missing; must be keys of the scene, as in interface.a,interface.b,interface.memory_length")
    scenes, free = begun(scenes, words)
    scene = scenes.base
    model = _default_model(scene) if options.model == "auto" else options.model
    series = _read_once(files, options.reading)
    records = [experiment_of(measured, scene, options.window) for measured in series]
    tolerance = options.tol or _TOLERANCE
    problem = problem_of(scenes, free, words, records, model, tolerance)
    settings = options.stored | {"free": words, "model": model} | digests([name_of(scene.law)], [model])
    contents = {f"contents of {measured.source}": measured.digest for measured in series}
    facts = {"scene": scene.digest, **contents, **{name: repr(value) for name, value in settings.items() if name != "data"}}
    best = BestValues.kept(options.checkpoint, next(problem.starts()), facts)
    stopped, waves = False, next((forward for forward in problem.models if isinstance(forward, CycleOfOrbit)), None)
    try:
        starts, is_cheap = problem.starts(), all(forward.is_cheap for forward in problem.models)
        if best.evaluations:
            log.info("goes on from %s after %d evaluations", options.checkpoint, best.evaluations)
            starts = chain([best.inner], starts if is_cheap or waves else [])
        elif not is_cheap and not waves:
            starts = _nearby(problem_of(scenes, free, words, records, _CHEAP, tolerance), starts)
        solution = fitted_orbit(problem, waves, starts, best) if waves else minimise(problem, starts, best)
    except KeyboardInterrupt:
        if not np.isfinite(best.cost):
            raise
        stopped = True
        solution = Solution(best.inner, problem.residual(best.inner), problem.slopes(best.inner), best.evaluations, "interrupted")
    spread = intervals(problem, solution)
    if not solution.failed and is_cheap:
        spread = profiled(problem, solution, spread)
    fitted = Variants(scenes, free, schedule_of(scene)).read(solution.inner[: len(free)])
    failed = "; ".join(
        filter(None, [solution.failed or _unexplained(problem, solution, model), *_complaints(problem, solution, spread)])
    )
    if solution.failed or at_bounds(problem, solution.inner):
        unknown = np.full_like(spread.low, math.nan)
        spread = spread._replace(low=unknown, high=unknown, profiled=())
    return FitResult(
        fitted,
        model,
        problem,
        solution,
        spread,
        time.perf_counter() - began,
        options.stored | {"free": _from_best(words, free, solution.inner)},
        remarks=_missing_in(model, scene),
        failed=f"fit: {failed}" if failed else "",
        stopped=stopped,
    )


def _read_once(files: Sequence[str], reading: Mapping[str, str | None]) -> list[Series]:
    """The records; none, and one under two names, are refused."""
    if not files:
        raise SceneError("--data: missing; must be a file of measured friction")
    series = [read_series(file, **reading) for file in files]
    if len({measured.digest for measured in series}) < len(files):
        raise SceneError(f"--data {', '.join(files)}: a record is given twice, and would count twice")
    return series


def _going_on(source: SceneSource, options: _FitOptions) -> _FitOptions:
    """The options completed by those of a file of results."""
    if not is_stored(source):
        return options
    stored, names = read_stored(str(source)), ("data", "free", "window", "tol", *options.reading)
    known: dict[str, Any] = {name: getattr(options, name) or stored.options.get(name) for name in names}
    model = stored.model if options.model == "auto" else options.model
    whole = replace(options, **{name: value for name, value in known.items() if value}, model=model)
    return whole.with_expressions(stored.options.get("set", {}))


def _from_best(words: list[str], free: Iterable[FreeParameter], inner: Array) -> list[str]:
    """What is fitted, variables with their best values as starts."""
    best = {key.name: key.written(key.value(x)) for key, x in zip(free, inner.tolist(), strict=False)}
    names = [word.partition("=")[0].strip() for word in words]
    return [f"{name}={best[name]}" if "=" in word else word for word, name in zip(words, names, strict=True)]


def _nearby(cheap: FrictionProblem, others: Iterator[Array]) -> Iterator[Array]:
    """Starts of an expensive model: the best values of a cheap one, or its own starts where there are none."""
    try:
        solution = minimise(cheap, cheap.starts(), BestValues(next(cheap.starts())))
    except NumericsError as error:
        log.info("%s: %s", _CHEAP, error)
        yield from others
        return
    log.info(
        "%s fits with a residual of %.3g times the noise: the start of the fit",
        _CHEAP,
        math.sqrt(solution.cost / solution.residual.size),
    )
    yield solution.inner


def _facts_of(record: Experiment, fitted: Array) -> dict[str, Any]:
    """JSON of a record; for stick-slip the period, measured and fitted."""
    facts: dict[str, Any] = {"file": record.name, "samples": record.times[record.shown].size}
    if record.cycle is None:
        return facts
    error = float(np.hypot(record.cycle.period_error, np.linalg.norm(record.cycle.together[0])))
    period = {"measured": record.cycle.period, "error": error, "fitted": float(fitted[0])}
    return facts | {"events": record.cycle.events, "drop": record.cycle.drop, "period": period}


def _unexplained(problem: FrictionProblem, solution: Solution, model: str) -> str:
    """What to try next, if the residual is far above the noise."""
    if (far := problem.far(solution.residual)) <= _UNEXPLAINED:
        return ""
    record, scene = problem.records[0], problem.models[0].scene(solution.inner[: len(problem.free)])
    length = (record.cycle.period if record.cycle else 1e-3 * float(record.times[-1])) / sizes(scene)[0]
    other = _next_model(model, scene, length)
    more = ", ".join([*([f"--model {other}"] if other else []), "another law (interface.law)", "a part of the record (--window)"])
    return f"the residual is {far:.3g} times the noise, which {model} does not explain; to be tried next: {more}"


def _complaints(problem: FrictionProblem, solution: Solution, spread: Intervals) -> Iterator[str]:
    bounds = at_bounds(problem, solution.inner)
    if bounds:
        yield f"{' and '.join(bounds)} ended at a bound"
    wide = [name for name, known in zip(problem.names, spread.determined, strict=True) if not known and name not in bounds]
    together = [line for line in spread.singular if line not in wide]
    if wide:
        yield f"the data do not determine {' and '.join(wide)}" + (f" ({'; '.join(together)})" if together else "")


def _listed(given: Iterable[str | Path]) -> list[str]:
    return [given] if isinstance(given, str) else [str(path) for path in given]


def _chart(
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
    return Chart([*above, *below], height, count, width, heights=(3.0, 1.0), title=_values_in_words(parameters))


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


def _values_in_words(parameters: Mapping[str, Mapping[str, Any]]) -> str:
    """Text of the best values with half the width of their 95 % intervals."""
    said = [_value_in_words(key, row) for key, row in parameters.items()]
    lines = [",   ".join(said[k : k + _IN_A_LINE]) for k in range(0, len(said), _IN_A_LINE)]
    return "\n".join(lines) + "   (95 %)"


def _value_in_words(key: str, row: Mapping[str, Any]) -> str:
    word, value, unit = key.rpartition(".")[2], row["value"], row["unit"]
    label = _LABELS.get(word, word.replace("_", " "))
    power = power_of(value) if unit in _PREFIXED and value else 0
    size = 10.0**power
    half = 0.5 * (row["high"] - row["low"]) / size
    text = barred(value / size, half).replace("+-", "±") if row["determined"] else f"{value / size:.3g}, not determined"
    unit = f" {PREFIXES[power].replace('u', 'μ')}{unit}" if unit else ""
    return f"{label} = ({text}){unit}" if unit and row["determined"] else f"{label} = {text}{unit}"


def _default_model(scene: Scene) -> str:
    """The cheapest model that has the mass on the outer faces, where there is one."""
    features = features_of(scene)
    return _BLOCK if "mass" in features and not features & _NO_BLOCK else _CHEAP


def _missing_in(model: str, scene: Scene) -> tuple[str, ...]:
    """A line on what a cheap `model` leaves out of the `scene`; none for other models."""
    mass = "the mass on the outer face and " if model in _LADDER[:2] and "mass" in features_of(scene) else ""
    return (f"model {model} leaves out {mass}waves that return",) if model in (*_LADDER[:-1], "block8") else ()


def _next_model(model: str, scene: Scene, length: float) -> str:
    """The cheapest model that has more of the `scene` than `model`, for cycles of `length` (transits); empty if there is none."""
    features, place = features_of(scene), _LADDER.index(model) if model in _LADDER else len(_LADDER)
    for name in _LADDER[place + 1 :]:
        family = family_of(name)
        has_block = name != _BLOCK or ("grip" in features and not features & _NO_BLOCK)
        if family and not family.refusal(scene) and has_block and (name != "delay" or length <= MOST_TRANSITS):
            return name
    return ""
