"""What a run keeps: events, the envelope for its figure, and if it is asked to the interface's history, the fields of the last
transits, checkpoints."""

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Self

from slipwave.errors import SceneError
from slipwave.files import part_of, remove_leftovers, require_writable
from slipwave.friction.law import name_of
from slipwave.input.assemble import moment
from slipwave.input.wording import shorten
from slipwave.observe import EventObserver
from slipwave.observe.envelope import Envelope
from slipwave.observe.protocol import ProtocolObserver
from slipwave.scene import Scene
from slipwave.solve import FieldSolver, Mark, Observer, Resumable, Solver
from slipwave.solve.checkpoint import Checkpoints
from slipwave.solve.follow import NamedObserver, named_observers
from validation.models.history_file import ALL, HistoryFile, Kept
from validation.models.own import digests
from validation.models.run import Length

if TYPE_CHECKING:
    from fullwave.fields.record import FieldRecord

_EVERY = 1000.0  # transits between two checkpoints

FIELD_FILES = (".vtu", ".xdmf", ".nc")
"""Kinds of file that fields are written to."""

FIELD_WINDOW = 100.0
"""Transits before the end of the run whose fields are kept: more than a cycle of the paper's scenes, never all of a long run."""


@dataclass(frozen=True)
class Records:
    """Records of a run: events by `watch`, the `envelope` for its figure, the stages of a `protocol`, and, if requested, the
    interface's history, the last fields, checkpoints and the observers `named` by the scene."""

    watch: EventObserver
    envelope: Envelope
    protocol: ProtocolObserver | None
    history: HistoryFile | None
    fields: "FieldRecord | None"
    checkpoints: Checkpoints | None
    named: Mapping[str, NamedObserver]

    @classmethod
    def of(
        cls,
        solver: Solver,
        length: Length,
        interface: bool | None = None,
        fields: bool | None = None,
        kept: Kept = ALL,
        samples: Path | None = None,
        checkpoint: Path | None = None,
        every: float | None = None,
    ) -> Self:
        """The records of a run of `solver` of this length, which continues from its `checkpoint` if that exists: the history of
        the `interface` and the last `fields` (None: by the scene's `record`); which samples of the history are `kept`, and the
        file of the `samples` during the run (default: temporary). A checkpoint is written `every` so many transits (1000).

        Raises SceneError for fields of a model that has none and for a checkpoint of another run.
        """
        scene, until = solver.scene, length.until
        history = record = None
        if "interface" in scene.record if interface is None else interface:
            history = _history(solver, min(until, next(length.ends(0.0), math.inf)), kept, samples, checkpoint)
        if "fields" in scene.record if fields is None else fields:
            record = _fields(solver, until, fields)
        watch = EventObserver(scene, solver.nodes)
        envelope = Envelope(scene, solver.nodes, kept.begin, kept.end)
        protocol = None if scene.drive.is_constant else ProtocolObserver(scene, solver.nodes, until)
        watched, named = watch if scene.record else None, named_observers(solver)
        parts = {"events": watched, "envelope": envelope, "protocol": protocol, "interface": history, "fields": record}
        saved: dict[str, Resumable] = {label: part for label, part in (parts | named).items() if part is not None}
        marks = None
        if checkpoint is not None:
            files = digests([name_of(scene.law)], [solver.model])
            marks = Checkpoints(solver, saved, checkpoint, until, every or _EVERY, files)
        records = cls(watch, envelope, protocol, history, record, marks, named)
        if marks is not None and checkpoint is not None and checkpoint.exists():
            try:
                marks.resume()
            except BaseException:
                records.close()
                raise
        return records

    @property
    def observers(self) -> list[Observer]:
        """The observers of the run except `watch`."""
        every = (self.envelope, self.protocol, self.history, *self.named.values())
        return [observer for observer in every if observer is not None]

    @property
    def marks(self) -> list[Mark]:
        """The marks of the run: fields first, so that a checkpoint contains them."""
        return [mark for mark in (self.fields, self.checkpoints) if mark is not None]

    def close(self) -> None:
        """Close the history's file, which is removed unless it belongs to a checkpoint."""
        if self.history is not None:
            self.history.close()


def _fields(solver: Solver, until: float, fields: bool | None) -> "FieldRecord | None":
    """The record of the last FIELD_WINDOW transits, for which `fields` asks or, where that is None, the scene's `record`.

    Raises SceneError, naming what asked, if the solver has no fields.
    """
    if not isinstance(solver, FieldSolver):
        asked = "fields" if fields else 'run.record: "fields"'
        raise SceneError(f"{asked}: model {solver.model} has no grid to take fields from; use a full-wave model")
    if math.isinf(until):
        raise SceneError(
            f"run.until: missing; the fields of a run's last {FIELD_WINDOW:g} transits are kept, so it needs a length"
        )
    from fullwave.fields.record import FieldRecord

    return FieldRecord(solver, max(until - FIELD_WINDOW, 0.0), until)


def _history(solver: Solver, until: float, kept: Kept, samples: Path | None, checkpoint: Path | None) -> HistoryFile:
    """The observer of the interface's history in a run to `until` (transits).

    The samples that are `kept` are in the file `samples`, or in a temporary one, until it is closed. With a `checkpoint` they are
    in a file in its folder, which stays for continued runs.
    """
    path = checkpoint.with_name(f"{checkpoint.name}.samples") if checkpoint else samples or _temporary_samples()
    history = HistoryFile(solver.scene.law, solver.nodes, path, until, stays=checkpoint is not None, kept=kept)
    try:
        length = solver.transits_per_piece
        history.expect((min(until, kept.end) - kept.begin) / length * solver.nodes.size if length > 0.0 else 0.0)
    except SceneError:
        history.close()
        raise
    return history


def _temporary_samples() -> Path:
    import tempfile

    folder = Path(tempfile.gettempdir())
    remove_leftovers(folder)
    handle, name = tempfile.mkstemp(prefix=".slipwave-", suffix=part_of(folder, ".samples").name)
    os.close(handle)
    return Path(name)


def time_between(path: Path | None, every: float | str | None, scene: Scene) -> float | None:
    """The time between checkpoints in transits, if given. Raises SceneError, naming the option, if checkpoints cannot be written
    as requested."""
    if every is None:
        if path is not None:
            require_writable(path, (".npz",), "--checkpoint")
        return None
    label = f"--checkpoint-every = {shorten(every)}"
    if path is None:
        raise SceneError(f"{label}: needs --checkpoint FILE")
    found = moment("--checkpoint-every", every, scene)
    if not (math.isfinite(found) and found > 0.0):
        raise SceneError(f"{label}: must be a positive number of transits, or in scenes with SI units a time as in 10s")
    require_writable(path, (".npz",), "--checkpoint")
    return found
