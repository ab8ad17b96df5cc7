"""A run as a netCDF file: events if they were watched, the interface's history if the scene records it, and its
provenance; and the fields of a full-wave run's last transits.
"""

import math
import os
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from slipwave.errors import SceneError
from slipwave.files import whole_or_absent
from slipwave.observe import EventObserver, Solver
from slipwave.observe.checkpoint import Checkpoints
from slipwave.observe.follow import Mark, Observer
from slipwave.observe.snapshot import FieldSolver
from slipwave.observe.solver import Resumable
from validation.run.history_file import HistoryFile
from validation.run.simulate import Run

if TYPE_CHECKING:
    from fullwave.fields.record import Field, FieldRecord

_EVENT_NOTES = {
    "time": ("date of the slip event: v passes half its largest value", "transit"),
    "period": ("time to the next event", "transit"),
    "stress_drop": ("max - min of the friction stress over the cycle", "normal stress"),
    "elastic_stress_drop": ("max - min of the elastic stress y over the cycle", "normal stress"),
    "v_max": ("largest slip rate of the cycle", "V*"),
    "v_min": ("smallest slip rate of the cycle", "V*"),
}
_HISTORY_NOTES = {
    "time": ("time", "transit"),
    "slip_rate": ("slip rate v", "V*"),
    "psi": ("state ln phi", "1"),
    "stress": ("friction stress mu", "normal stress"),
    "elastic_stress": ("elastic stress y", "normal stress"),
}


_EVERY = 1000.0  # transits between two checkpoints

FIELD_FILES = (".vtu", ".xdmf", ".nc")
"""Kinds of file that fields are written to."""

FIELD_WINDOW = 100.0
"""Transits before the end of the run whose fields are kept: more than a cycle of the paper's scenes, never all of a long run."""


@dataclass(frozen=True)
class Records:
    """What is kept of a run on its way: `watch` for events, and, where asked for, the interface's history, the last fields and
    checkpoints."""

    watch: EventObserver
    history: HistoryFile | None
    fields: "FieldRecord | None"
    checkpoints: Checkpoints | None

    @property
    def observers(self) -> list[Observer]:
        """The observers of the run besides `watch`."""
        return [self.history] if self.history is not None else []

    @property
    def marks(self) -> list[Mark]:
        """What is done at certain times of the run: fields first, so that a checkpoint has them."""
        return [mark for mark in (self.fields, self.checkpoints) if mark is not None]

    def close(self) -> None:
        """Close the history's file, which is removed unless it belongs to a checkpoint."""
        if self.history is not None:
            self.history.close()


def records_of(
    solver: Solver, until: float, history: bool | Path, fields: bool | None, checkpoint: Path | None, every: float | None
) -> Records:
    """What a run of `solver` keeps: the interface's `history`, the last `fields` and, every `every` transits, a `checkpoint`.

    It goes on from `checkpoint` if that exists. Raises SceneError for fields of a model that has none and for a checkpoint of
    another run.
    """
    samples = history_for(solver, until, history, checkpoint)
    watch, kept = EventObserver(solver.scene, solver.nodes), fields_for(solver, until, fields)
    parts = {"events": watch if solver.scene.record else None, "interface": samples, "fields": kept}
    saved: dict[str, Resumable] = {label: part for label, part in parts.items() if part is not None}
    marks = None if checkpoint is None else Checkpoints(solver, saved, checkpoint, until, _EVERY if every is None else every)
    records = Records(watch, samples, kept, marks)
    if marks is not None and checkpoint is not None and checkpoint.exists():
        try:
            marks.resume()
        except BaseException:
            records.close()
            raise
    return records


def fields_for(solver: Solver, until: float, fields: bool | None) -> "FieldRecord | None":
    """The record of the last FIELD_WINDOW transits, if `fields` asks for it or, where that is None, the scene's `record`.

    Raises SceneError, naming what asked, if the solver has no fields.
    """
    if fields is False or (fields is None and "fields" not in solver.scene.record):
        return None
    if not isinstance(solver, FieldSolver):
        asked = "fields" if fields else 'run.record: "fields"'
        raise SceneError(f"{asked}: model {solver.model} has no grid to take fields from; use a full-wave model")
    from fullwave.fields.record import FieldRecord

    return FieldRecord(solver, max(until - FIELD_WINDOW, 0.0), until)


def history_for(solver: Solver, until: float, history: bool | Path, checkpoint: Path | None) -> HistoryFile | None:
    """The observer of the interface's history, if that is to be kept and the scene's `record` asks for it.

    Its samples are kept in the file `history`, or in a temporary one, until it is closed. With checkpoints they are kept in a
    file beside those, which stays for runs that go on.
    """
    if history is False or "interface" not in solver.scene.record:
        return None
    if checkpoint is not None:
        path = checkpoint.with_name(f"{checkpoint.name}.samples")
    else:
        path = _temporary_samples() if history is True else history
    return HistoryFile(solver.scene.law, solver.nodes, path, until, stays=checkpoint is not None)


def _temporary_samples() -> Path:
    import tempfile

    handle, name = tempfile.mkstemp(prefix="slipwave-", suffix=".samples")
    os.close(handle)
    return Path(name)


def write_run(path: Path, done: Run, history: HistoryFile | None, field: "Field | None" = None) -> None:
    """Write `done` to `path`, which is whole or absent; `complete` is 0 if the run ended early. A `field` becomes the
    file's group "fields".

    Raises SceneError if the file, or the history before, could not be written.
    """
    import xarray

    if history is not None and history.problem:
        raise SceneError(history.problem)
    scene = done.solver.scene
    variables, judged = _events_of(done)
    facts = {
        "title": f"slipwave run of scene {scene.name} with model {done.solver.model}",
        "scene": scene.name,
        "scene_digest": scene.digest,
        "model": done.solver.model,
        "slipwave_version": version("slipwave"),
        "until_transits": done.until,
        "transit_in_friction_time": scene.transit,
        **judged,
        "failures": done.solver.failures,
        "complete": 0 if done.failed else 1,
        "failed": done.failed,
    }
    with whole_or_absent(path) as temporary:
        xarray.Dataset(variables, attrs=facts).to_netcdf(temporary, engine="netcdf4")
        if history is not None:
            _append_history(temporary, history)
        if field is not None:
            field.dataset().to_netcdf(temporary, mode="a", group="fields", engine="netcdf4")


def _events_of(done: Run) -> tuple[dict[str, Any], dict[str, Any]]:
    """Variables on the cycles of a run, none if events were not watched, and attributes: what is known of its events.

    `multiplicity` is there only if the run is periodic, `rotation_number` only on a torus: a netCDF attribute cannot be empty.
    """
    if done.verdict is None:
        return {}, {"events": "not watched", "verdict": "not watched"}
    columns = {"event_time" if name == "time" else name: name for name in done.events._fields}
    variables = {label: ("event", getattr(done.events, name), _notes(_EVENT_NOTES[name])) for label, name in columns.items()}
    facts = {"events": done.starts, "verdict": done.verdict.kind}
    more = {"multiplicity": done.verdict.multiplicity, "rotation_number": done.verdict.rotation}
    return variables, facts | {name: value for name, value in more.items() if value is not None}


def _append_history(path: Path, history: HistoryFile) -> None:
    import netCDF4

    with netCDF4.Dataset(path, "a") as file:
        file.createDimension("sample", len(history))
        columns = {}
        for name, notes in _HISTORY_NOTES.items():
            label = "time" if name == "time" else f"interface_{name}"
            columns[name] = file.createVariable(label, "f8", ("sample",), fill_value=math.nan)
            columns[name].setncatts(_notes(notes))
        first = 0
        for part in history.parts():
            for name, values in part.items():
                columns[name][first : first + values.size] = values
            first += part["time"].size


def _notes(facts: tuple[str, str]) -> dict[str, str]:
    return {"long_name": facts[0], "units": facts[1]}
