"""`slipwave bench`: Time every model against its error in period and stress drop; the reference is the delay system at a tight
tolerance.
"""

import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import Any, ClassVar

from fullwave.families import FullWave
from slipwave.errors import NumericsError, SceneError
from slipwave.family import Family
from slipwave.input.assemble import SceneSource
from slipwave.scene import Scene
from validation.chart import Chart, Panel, Scale
from validation.chart.looks import model_line, style_of
from validation.commands.comparison import Comparison, errors_of, nothing, remarks, row_of
from validation.commands.options import LengthOptions, command
from validation.commands.result import aligned, rounded
from validation.models.build import build
from validation.models.by_name import honouring, one_port_of
from validation.models.cycle import watch
from validation.models.outlook import Length, length_of
from validation.models.progress import progress
from validation.models.run import Run, simulate
from validation.models.timing import WARM_UP, alternating, quartiles

_TOLERANCES = (1e-5, 1e-7, 1e-9)
_REFERENCE_TOLERANCE = 1e-11
_ROUNDS, _ENOUGH = 3, 10.0
"""Rounds in which all runs are timed, and the seconds in all after which there is no further one."""


class _BenchOptions(LengthOptions):
    """Options of `slipwave.bench`."""

    EXAMPLES: ClassVar = ("slipwave bench paper --until 1000",)


class BenchResult(Comparison):
    """The `runs` of the scene, each with its numerical setting and its wall times (s) in all rounds; the reference is the delay
    system at a tight tolerance."""

    DIMENSION: ClassVar = "trial"
    COMMAND: ClassVar = "bench"

    runs: list[tuple[Run, dict[str, Any], list[float]]]

    @property
    def rows(self) -> list[dict[str, Any]]:
        """One for each run, with errors without sign; its time is the median over rounds."""
        rows = []
        for run, setting, times in self.runs:
            low, median, high = quartiles(times)
            row = row_of(replace(run, wall_s=median), {"setting": setting}, self.reference)
            row |= {"wall_low_s": low, "wall_high_s": high}
            row["error"] = {name: None if error is None else abs(error) for name, error in row["error"].items()}
            rows.append(row)
        return rows

    def lines(self, summary: Mapping[str, Any]) -> Iterator[str]:
        """One row per run, and the conclusion."""
        rows = [
            [
                row["model"],
                ", ".join(f"{name} {value:g}" for name, value in row["setting"].items()) or "-",
                rounded(row["wall_s"], 3),
                f"{rounded(row['wall_low_s'], 3)} to {rounded(row['wall_high_s'], 3)}",
                *errors_of(row),
            ]
            for row in summary["models"]
        ]
        yield from aligned(["model", "setting", "wall s", "quartiles", "error T", "error drop"], rows)
        against = f"relative errors of the second half's mean against {summary['reference']} (tight)"
        yield f"\n{summary['until']:g} transits; {against}"
        yield from remarks(summary)

    def chart(self) -> Chart:
        """Error of the period against wall time, a line for each model; runs without cycles are left out."""
        lines = []
        for model in dict.fromkeys(run.solver.model for run, _, _ in self.runs):
            rows = [row for row in self.summary["models"] if row["model"] == model and row["error"]["period"]]
            pairs = [row["wall_s"] for row in rows], [row["error"]["period"] for row in rows]
            lines += [model_line(model, *pairs, model, marker=style_of(model).marker)] if rows else []
        panel = Panel("", Scale("wall time / s", "log"), Scale("relative error of the period", "log"), lines, "best")
        return Chart([panel], 4.8, title=f"{self.scene.name}: run time against error")


@command
def bench(source: SceneSource, options: _BenchOptions) -> BenchResult:
    """Time every model against its error in period and stress drop; the reference is the delay system at a tight tolerance.

    Times are medians over three rounds in which all run in turn; there is one round where that takes longer than ten seconds.
    A model that fails on the scene (quasistatic runs away) still has a row. Raises SceneError for wrong input and where the
    reference has no cycles; NumericsError, with all of them as its `result`, if solves of the interface failed.
    """
    scene = options.scene_of(source, options.until)
    tolerances = [{"tolerance": tolerance} for tolerance in _TOLERANCES]
    settings = {family.name: _grids(scene, family) or tolerances for family in honouring(scene)}
    trials = [(family, setting) for family in honouring(scene) for setting in settings[family.name]]
    if not trials:
        raise SceneError(f"scene = {scene.name!r}: no model of this installation can do it")
    delay = next((family for family, _ in trials if family.name == "delay"), None)
    family, setting = (delay, {"tolerance": _REFERENCE_TOLERANCE}) if delay is not None else trials[-1]  # else its finest
    all_of_it = length_of(scene, one_port_of(family.example))
    reference = _prepared(scene, family, setting, all_of_it, options.most_seconds)()
    if reference.stopped:
        raise KeyboardInterrupt
    if nothing(reference):
        raise SceneError(f"until = {reference.until:g}: {nothing(reference)}")
    length = Length(until=reference.until)
    works = {number: partial(_prepared, scene, *trial, length, options.most_seconds) for number, trial in enumerate(trials)}
    runs: list[tuple[Run, dict[str, Any], list[float]]] = []
    stopped, spent = "", 0.0
    with progress("bench", _ROUNDS * len(trials)) as report:
        for done, (number, seconds, run) in enumerate(alternating(works, _ROUNDS, time.perf_counter)):
            if run.stopped:
                stopped = f"after {done} of {_ROUNDS * len(trials)} runs"
                break
            if done < len(trials):
                runs.append((run, trials[number][1], []))
            runs[number][2].append(seconds)
            spent += seconds
            report(done + 1)
            if number == len(trials) - 1 and spent > _ENOUGH:
                break
    failed = [reference.failed] if reference.failed else [run.failed for run, _, _ in runs if run.solver.failures]
    failed = ["interrupted", *failed, stopped] if stopped else failed
    return BenchResult(scene, reference, options.stored, runs, failed="; ".join(failed), stopped=bool(stopped))


def _grids(scene: Scene, family: Family) -> list[dict[str, Any]]:
    """The grids of `family` on the scene, each once: layers that have their fewest cells are the same at fewer cells yet. A full
    wave that names none has those from its usual one on: of a low order, no grid may reach a tolerance."""
    usual = [family.cells, 2 * family.cells, 4 * family.cells] if isinstance(family, FullWave) else []
    distinct = {str(build(family.example, scene, cells=cells).settings): {"cells": cells} for cells in family.grids or usual}
    return [*distinct.values()]


def _prepared(scene: Scene, family: Family, setting: dict[str, Any], length: Length, most: float) -> Callable[[], Run]:
    """The run, with its code loaded."""
    with suppress(NumericsError):  # a run that fails reports it itself
        watch(build(family.example, scene, **setting), WARM_UP if scene.until is None else min(WARM_UP, scene.until))
    return partial(simulate, build(family.example, scene, **setting), length, most_seconds=most)
