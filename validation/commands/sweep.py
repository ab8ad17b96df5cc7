"""`slipwave sweep`: One measure of many scenes over axes, on all cores or a cluster; resumed after any interruption."""

import csv
import io
import re
import shutil
import tempfile
import time
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from functools import cached_property
from pathlib import Path
from types import FunctionType
from typing import Any, ClassVar

import numpy as np

from slipwave.errors import NumericsError, SceneError
from slipwave.files import FIGURES, content_of
from slipwave.input.assemble import SceneSource
from slipwave.input.wording import sentence
from slipwave.packages import no_exit
from validation.chart import Chart
from validation.commands.options import LengthOptions, command, option
from validation.commands.result import Output, Result, aligned, rounded
from validation.commands.run import run
from validation.data.datasets import Dataset
from validation.sweep.executors import started
from validation.sweep.gather import dataset_of, filled_arrays
from validation.sweep.map_figures import chart_of_sweep, figures_on_clock, onset_lines
from validation.sweep.measures import MEASURES, measure_name, measure_of
from validation.sweep.plan import Axis, Plan, axis_of
from validation.sweep.store import STATUS, Store
from validation.sweep.sweep import forecast, perform_sweep, plan_of, require_laws_in_files, stored_plan

_SHOWN = 5  # reasons why points have no figures
_OF_A_PLAN = ("vary", "models", "rows", "out", "until", "tol", "cells", "refine")
_FEW = 12  # points that are printed one by one
GATHERED = "sweep.nc"
"""The file that `--gather` writes into the folder of a sweep."""


class _SweepOptions(LengthOptions):
    """Options of `slipwave.sweep`."""

    EXAMPLES: ClassVar = (
        "slipwave sweep paper --vary log10_r=-2.75:-2.2:33 --vary V=10:1000:17:log --out map",
        'slipwave sweep paper --vary q=1:10:9 --set "upper.epsilon=1.4e-5*(1+q)/q" --set "lower.epsilon=1.4e-5*(1+q)" --out q',
        "slipwave sweep map",
        "slipwave sweep map --gather --plot map.png",
    )
    DETAILS: ClassVar = (
        "SCENE may be the folder of a sweep, which is then gone on with. A point that cannot be computed has a status and a "
        "reason; it stops nothing."
    )

    vary: Iterable[str] | Mapping[str, object] = option(
        "an axis: a key of the scene, or a variable that a --set names, with FROM:TO:COUNT, FROM:TO:COUNT:log or A,B,C; may be "
        "repeated",
        (),
        metavar="KEY=VALUES ...",
    )
    models: str | Sequence[str] = option("the models, with commas", "delay", metavar="M1,M2")
    measure: str | FunctionType = option(
        f"what is computed at each point: {', '.join(MEASURES)}, or module:function of a scene that returns numbers by name",
        "verdict",
    )
    rows: Path | None = option("instead of axes, a table of scenes: the columns are keys", metavar="FILE.csv")
    out: Path | None = option("folder of the sweep (default in Python: none is kept)", metavar="DIR")
    until: float | str | None = option(
        "longest run, in transits or as 60s (default: the scene's, else 4000)", metavar="TRANSITS|TIME"
    )
    tol: float | None = option("requested relative error of each run")
    cells: int | None = option("full wave: cells per slab")
    refine: int = option("begin with every 2^LEVELS-th point, and divide cells in which the regime changes", 0, metavar="LEVELS")
    workers: int | None = option("processes (default: one per core)", least=1, most=4096, must="be from 1 to 4096")
    scheduler: str | None = option("compute on the dask cluster with this scheduler", metavar="tcp://HOST:PORT")
    executor: Executor | None = option("compute on this executor", python_only=True)
    part: str = option("this job's share of the points, for job arrays: the I-th of N", "1/1", metavar="I/N")
    gather: bool = option(f"compute nothing; write what is there to {GATHERED} in the folder", False)
    dry: bool = option("compute nothing; say how long it would take, from a few points", False)
    anew: bool = option("begin again in a folder that holds another sweep, or one of another version", False)

    @property
    def varied(self) -> tuple[str, ...]:
        """The names of the axes, or of the columns of `rows`."""
        rows = _rows(self.rows) if self.rows else ()
        return (*(axis.name for axis in _axes(self.vary)), *dict.fromkeys(key for row in rows for key in row))


class SweepResult(Result):
    """The present state of a sweep: the finished part of a `plan` in its `store`, the `audit` of a refined one (`refine`), the
    time of this call (s) and the points `computed` in it; with `dry` the `expected` time only."""

    OUTPUTS: ClassVar = (Output("--plot", FIGURES, "save_plot", "draw the map, or a line over one axis: .png, .pdf or .svg"),)

    plan: Plan
    store: Store
    audit: tuple[int, int] | None = None
    wall_s: float = 0.0
    computed: int = 0
    expected: dict[str, Any] | None = None
    temporary: bool = False

    @cached_property
    def dataset(self) -> Dataset:
        """The figures computed so far over the axes (and `model`, if there are several)."""
        return dataset_of(self.plan, self._arrays)

    @cached_property
    def _arrays(self) -> dict[str, Any]:
        return filled_arrays(self.plan, self.store)

    @property
    def facts(self) -> dict[str, Any]:
        """As `Result`."""
        plan = self.plan
        axes = [
            {
                "key": axis.name,
                "from": axis.values[0],
                "to": axis.values[-1],
                "count": len(axis.values),
                "unit": axis.unit or None,
            }
            for axis in plan.axes
        ]
        facts: dict[str, Any] = {"scene": plan.base.name, "measure": plan.measure, "models": list(plan.models)}
        facts |= {"axes": axes, "set": dict(plan.scenes.sets), "folder": None if self.temporary else str(self.store.folder)}
        if self.expected is not None:
            return facts | {"expected": self.expected}
        status = [STATUS[number] for number in self._arrays["status"] if number >= 0]
        reasons = Counter(str(reason) for reason in self._arrays["reason"] if reason)
        facts |= {"points": plan.size, **{name: status.count(name) for name in STATUS}}
        facts["reasons"] = [{"reason": reason, "points": count} for reason, count in reasons.most_common(_SHOWN)]
        facts |= {"regimes": self._regimes(), "wall_s": self.wall_s, "computed_now": self.computed}
        if self.audit is not None:
            divided, hidden = self.audit
            facts["audit"] = {"cells_divided": divided, "hidden": hidden, "share": hidden / max(divided, 1)}
        return facts

    def _regimes(self) -> list[dict[str, Any]]:
        """Number of points by model and verdict."""
        regimes = []
        for name, words in measure_of(self.plan.measure).words.items():
            values = np.reshape(self._arrays[name], (len(self.plan.models), -1))
            for model, row in zip(self.plan.models, values, strict=True):
                counts = {word: int((row == number).sum()) for number, word in enumerate(words)}
                regimes.append({"model": model, **{word: count for word, count in counts.items() if count}})
        return regimes

    def lines(self, summary: Mapping[str, Any]) -> Iterator[str]:
        """The axes, numbers of points by status, and reasons for points without figures."""
        plan = self.plan
        yield f"scene {plan.base.name}, {plan.measure} of {', '.join(plan.models)} at {plan.size} points"
        for axis in plan.axes:
            ends = ", ".join(map(str, axis.values)) if axis.is_of_words else f"from {axis.values[0]:g} to {axis.values[-1]:g}"
            yield f"{axis.name} {ends}{axis.unit and ' '}{axis.unit}, {len(axis.values)} values"
        yield from plan.scenes.lines
        if expected := self.expected:
            each, all_of_them = (rounded(value, 3) for value in (1e3 * expected["seconds_per_point"], expected["seconds"]))
            with_them = f"{expected['workers']} workers, {expected['size'] / 1e6:.1f} MB"
            yield f"{each} ms per point: about {all_of_them} s with {with_them}"
            return
        now = f"{summary['computed_now']} of them now, in {self.wall_s:.3g} s"
        yield f"done {summary['done']} of {summary['points']}, {now}"
        for row in summary["reasons"]:
            yield f"{row['points']} without figures: {row['reason']}"
        if self.audit is not None:
            yield "of {} cells divided at random {} held another regime than their corners".format(*self.audit)
        if summary["regimes"]:
            yield ""
            words = list(dict.fromkeys(word for row in summary["regimes"] for word in row))
            yield from aligned(words, [[str(row.get(word, "-")) for word in words] for row in summary["regimes"]])
        if 0 < plan.size <= _FEW and not plan.rows:
            yield ""
            yield from aligned(*self._table())
        if "needed" in self._arrays:
            needed, until = self._arrays["needed"], self._arrays["until"]
            short = np.isfinite(needed) & (needed > until)
            if short.any():
                yield f"runs that are too short have enough cycles with --until {float(f'{needed[short].max():.2g}'):g}"

    def _table(self) -> tuple[list[str], list[list[str]]]:
        """Heading and rows of a sweep of a few points: where they are, regime, and the first figures, or why there are none."""
        plan, arrays, measure = self.plan, self._arrays, measure_of(self.plan.measure)
        words = [name for name in measure.words if name in arrays]
        usual = [name for name in ("exponent", "period", "stress_drop", "v_max") if name in arrays]
        others = [name for name, values in arrays.items() if values.ndim == 1 and values.dtype.kind == "f"]
        figures = [figures_on_clock(self.dataset, name) for name in usual or others[:3]]
        labels = [re.sub(r" / (transits|normal stress|V\*)$", "", label) for _, label in figures]
        rows = []
        for point in range(plan.size):
            where = [str(value) if isinstance(value, str) else f"{value:.7g}" for value in plan.changes(point).values()]
            said = [measure.words[name][arrays[name][point]] if arrays[name][point] >= 0 else "-" for name in words]
            told = [rounded(float(values.values.ravel()[point]), 7) for values, _ in figures]
            rows.append([plan.model(point), *where, *said, *told, str(arrays["reason"][point])])
        return ["model", *(axis.name for axis in plan.axes), *words, *labels, ""], rows

    def chart(self) -> Chart:
        """The map over two axes with the boundary of stability, the figures over one, or the motion at the only point."""
        plan = self.plan
        if plan.size == 1 and "verdict" in self.dataset:
            given = {name: value for name, value in plan.options.items() if name in ("tol", "cells")}
            alone = run(plan.scene(0), plan.model(0), until=float(self._arrays["until"][0]), **given)
            return alone.chart()
        return chart_of_sweep(self.dataset, lines=onset_lines(self.dataset)[0])

    def to_go_on(self, options: _SweepOptions) -> str:
        """As `Result`."""
        again = "" if self.plan.measure in MEASURES else f" --measure {self.plan.measure}"
        return f"slipwave sweep {self.store.folder}{again} goes on"

    def close(self) -> None:
        """Remove the temporary folder of a sweep without `out`."""
        if self.temporary:
            shutil.rmtree(self.store.folder, ignore_errors=True)


@command
def sweep(source: SceneSource, options: _SweepOptions) -> SweepResult:
    """Compute one measure at all points of axes over a scene, each finished part kept in a folder.

    `vary` may be {"log10_r": (-2.75, -2.2, 33)} or {"V": [10, 20, 50]} too, and `measure` a function (of a scene, in a module)
    that returns numbers by name. If `source` is the folder of a sweep, that sweep is continued. Raises SceneError for wrong
    input; NumericsError if the scheduler disappears; finished parts are kept.
    """
    began = time.perf_counter()
    folder = Path(source) if isinstance(source, str | Path) and Path(source).is_dir() else None
    plan = stored_plan(folder, not options.gather) if folder is not None else _plan(source, options)
    is_own = plan.measure not in MEASURES
    if folder is not None:
        another = () if is_own or options.measure == plan.measure else ("measure",)
        options.require_unset((*_OF_A_PLAN, *another), f"{str(folder)!r} holds a sweep, which goes on as it began")
    folder = folder or options.out
    if not options.gather and is_own and plan.measure != measure_name(options.measure):
        needs = f"--measure {sentence(plan.measure)}, which is a function of your own: no folder says what is run"
        raise SceneError(f"SCENE = {str(folder)!r}: going on needs {needs}")
    label = f"--measure = {plan.measure!r}" if is_own else ""
    workers, part = options.workers or 0, _part(options)
    if options.dry:
        with no_exit(label):
            return SweepResult(plan, Store(folder or Path()), expected=forecast(plan, workers))
    if options.executor is None and not options.gather:
        require_laws_in_files(plan)
    store = Store(folder or Path(tempfile.mkdtemp(prefix="slipwave-sweep-")))
    if options.gather:
        result = SweepResult(plan, store)
        result.to_netcdf(store.folder / GATHERED)
        return result
    failed, stopped, audit, computed = "", False, None, 0
    try:
        with no_exit(label):
            where = started(workers, options.scheduler, options.executor)
            audit, computed = perform_sweep(plan, store, where, part, options.most_seconds, options.anew)
    except NumericsError as error:
        failed = str(error)
    except KeyboardInterrupt:
        failed, stopped = f"interrupted after {int(store.done(plan).sum())} of {plan.size} points", True
    seconds = time.perf_counter() - began
    return SweepResult(plan, store, audit, seconds, computed, temporary=folder is None, failed=failed, stopped=stopped)


def _part(options: _SweepOptions) -> tuple[int, int]:
    number, slash, count = options.part.partition("/")
    if not (slash and number.isdecimal() and count.isdecimal() and 1 <= int(number) <= int(count)):
        raise SceneError(f"--part = {options.part!r}: must be I/N with I from 1 to N, as 3/16")
    if int(count) > 1 and options.refine:
        raise SceneError(f"--part = {options.part!r}: must not be given together with --refine, whose levels wait for each other")
    if int(count) > 1 and options.anew:
        raise SceneError(f"--part = {options.part!r}: must not be given together with --anew, which removes what others computed")
    return int(number), int(count)


def _plan(source: SceneSource, options: _SweepOptions) -> Plan:
    rows = _rows(options.rows) if options.rows else ()
    if rows and options.vary:
        raise SceneError(f"--rows = {str(options.rows)!r}: must not be given together with --vary")
    numerical = {"tol": options.tol, "cells": options.cells, "refine": options.refine}
    models = options.models.split(",") if isinstance(options.models, str) else options.models
    if not models:
        raise SceneError("--models = []: must be one name or more")
    axes, scenes = _axes(options.vary), options.scenes_of(source, options.until)
    return plan_of(scenes, axes, models, measure_name(options.measure), rows=rows, **numerical)


def _axes(vary: Iterable[str] | Mapping[str, Any]) -> list[Axis]:
    if isinstance(vary, Mapping):
        return [axis_of(str(key), values) for key, values in vary.items()]
    pairs = [text.partition("=") for text in ([vary] if isinstance(vary, str) else vary)]
    for key, sign, values in pairs:
        if not sign:
            raise SceneError(f"--vary {key + values!r}: must be KEY=FROM:TO:COUNT, as in log10_r=-2.75:-2.2:33")
    return [axis_of(key.strip(), values) for key, _, values in pairs]


def _rows(path: Path) -> tuple[dict[str, float | str], ...]:
    """The rows of a table of scenes. Raises SceneError for any other file."""
    content = content_of(path, f"--rows = {str(path)!r}")
    try:
        rows = list(csv.DictReader(io.StringIO(content.decode(), newline=""), restkey="", strict=True))
    except (ValueError, csv.Error) as error:
        raise SceneError(f"--rows = {str(path)!r}: cannot be read: {error}") from None
    if not rows or any("" in row or None in row.values() for row in rows):
        raise SceneError(f"--rows = {str(path)!r}: must be a CSV file with keys of the scene above and one scene a row")
    return tuple({key.strip(): _plain(value) for key, value in row.items() if value.strip()} for row in rows)


def _plain(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text.strip()
