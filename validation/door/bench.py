"""`slipwave.bench`: run time against error, every model that can do the scene, at several settings each."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from slipwave.errors import SceneError
from slipwave.family import Family
from slipwave.input import SceneSource
from slipwave.scene import Scene
from slipwave.scene.doubts import doubts
from slipwave.solve.foresight import DAY
from validation.door.checked import checked
from validation.door.result import Dataset, Result, deliver, finite, scene_of, table_of
from validation.registry.choice import honouring
from validation.registry.families import one_port_of
from validation.results.conclusion import conclusion, nothing
from validation.results.provenance import SCHEMA, provenance
from validation.run.difference import in_json
from validation.run.length import Length, Until, length_of
from validation.run.progress import progress
from validation.run.simulate import Run, RunInterrupted, simulate
from validation.study.drawing import Drawing, canvas, pen, styled
from validation.timing import Setting, solver_of, warm_up

_TOLERANCES = (1e-5, 1e-7, 1e-9)
_REFERENCE_TOLERANCE = 1e-11


@dataclass(frozen=True, repr=False, eq=False)
class BenchResult(Result):
    """The timed `runs` of the `scene`, each with its numerical setting, and the `reference` for their errors."""

    scene: Scene
    reference: Run
    runs: list[tuple[Run, dict[str, Any]]]

    @property
    def summary(self) -> dict[str, Any]:
        """The JSON of `slipwave bench` (users rely on its keys), with errors as `slipwave compare`, without sign;
        `notes` are there only if the scene is doubtful."""
        rows = [_row(run, setting, self.reference) for run, setting in self.runs]
        facts = {"schema": SCHEMA, "scene": self.scene.name, "until": self.reference.until}
        facts |= {"reference": self.reference.solver.model, "conclusion": conclusion(finite(rows))}
        doubtful = doubts(self.scene)
        return dict(finite(facts | {"models": rows} | ({"notes": doubtful} if doubtful else {})))

    @cached_property
    def dataset(self) -> Dataset:
        """Wall time and errors of each run by `trial`, with its model and setting."""
        data = table_of(self.summary["models"], "trial", self.scene)
        return data.assign_attrs(provenance("bench", self.scene, self.reference.solver.model, {}))

    def plot(self) -> Drawing:
        """Error of the period against wall time, a line for each model; runs without cycles are left out."""
        with styled():
            figure = canvas(height=4.8)
            axes = figure.subplots()
            axes.set(xscale="log", yscale="log", xlabel="wall time / s", ylabel="relative error of the period")
            for model in dict.fromkeys(run.solver.model for run, _ in self.runs):
                rows = [row for row in self.summary["models"] if row["model"] == model and row["error"]["period"]]
                if rows:
                    pairs = [row["wall_s"] for row in rows], [row["error"]["period"] for row in rows]
                    look = pen(model)
                    axes.plot(*pairs, color=look.color, marker=look.marker, linestyle=look.dashes, label=model)
            axes.set_title(f"{self.scene.name}: run time against error")
            if axes.get_lines():
                axes.legend()
            return figure


@checked
def bench(
    source: SceneSource,
    *,
    until: float | str | None = None,
    most_seconds: float = DAY,
    settings: Iterable[str] = (),
    **changes: Any,
) -> BenchResult:
    """Time every model against its error in period and stress drop; the reference is the delay system at a tight tolerance.
    `changes` are those of `slipwave.read_scene`.

    A model that cannot do the scene (quasistatic runs away) still has a row. Raises SceneError for wrong input and where the
    reference has no cycles; NumericsError, with all of them as its `result`, if solves of the interface failed.
    """
    scene = scene_of(source, settings, changes, until)
    trials = [(family, setting) for family in honouring(scene) for setting in _settings(family)]
    if not trials:
        raise SceneError(f"scene = {scene.name!r}: no model of this installation can do it")
    reference = _reference(scene, trials, most_seconds)
    if nothing(reference):
        raise SceneError(f"until = {reference.until:g}: {nothing(reference)}")
    length = Until(reference.until)
    runs: list[tuple[Run, dict[str, Any]]] = []
    stopped = ""
    with progress("bench", len(trials)) as report:
        for done, (family, setting) in enumerate(trials):
            try:
                runs.append((_timed(scene, family, setting, length, most_seconds), setting))
            except RunInterrupted:
                stopped = f"after {done} of {len(trials)} runs"
                break
            report(done + 1)
    failed = [reference.failed] if reference.failed else [run.failed for run, _ in runs if run.solver.failures]
    failed = ["interrupted", *failed, stopped] if stopped else failed
    return deliver(BenchResult(scene, reference, runs), "; ".join(failed), bool(stopped))


def _settings(family: Family) -> list[dict[str, Any]]:
    if family.grids:
        return [{"cells": cells} for cells in family.grids]
    return [{"tolerance": tolerance} for tolerance in _TOLERANCES]


def _reference(scene: Scene, trials: list[tuple[Family, dict[str, Any]]], most: float) -> Run:
    """The delay system at a tight tolerance; for scenes it cannot do, the last full-wave family at its finest setting. All other
    runs last as long as it does."""
    delay = next((family for family, _ in trials if family.name == "delay"), None)
    family, setting = (delay, {"tolerance": _REFERENCE_TOLERANCE}) if delay is not None else trials[-1]
    return _timed(scene, family, setting, length_of(scene, one_port_of(family.example)), most)


def _timed(scene: Scene, family: Family, setting: dict[str, Any], length: Length, most: float) -> Run:
    chosen = Setting(family.example, **setting)
    warm_up(chosen, scene)
    return simulate(solver_of(chosen, scene), length, most_seconds=most)


def _row(run: Run, setting: dict[str, Any], reference: Run) -> dict[str, Any]:
    found = in_json(run, reference)
    found["error"] = {name: None if error is None else abs(error) for name, error in found["error"].items()}
    row = {
        "model": run.solver.model,
        "setting": setting,
        "verdict": run.kind,
        "wall_s": run.wall_s,
        **found,
        "failures": run.solver.failures,
    }
    return row | ({"failed": run.failed} if run.failed else {})
