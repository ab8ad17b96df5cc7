"""What is kept of a run on its way: events, the interface's history, the fields of the last transits, checkpoints."""

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

from slipwave.errors import SceneError
from slipwave.files import part_of, remove_leftovers
from slipwave.input.assemble import moment
from slipwave.input.wording import shorten
from slipwave.observe import EventObserver
from slipwave.observe.envelope import Envelope
from slipwave.observe.protocol import ProtocolObserver
from slipwave.scene import Scene
from slipwave.solve import FieldSolver, Mark, Observer, Resumable, Solver
from slipwave.solve.checkpoint import Checkpoints, saved_time
from slipwave.solve.follow import NamedObserver, named_observers
from validation.compute.history_file import ALL, HistoryFile, Kept
from validation.output import require_writable

if TYPE_CHECKING:
    from fullwave.fields.record import FieldRecord

_EVERY = 1000.0  # transits between two checkpoints

FIELD_FILES = (".vtu", ".xdmf", ".nc")
"""Kinds of file that fields are written to."""

FIELD_WINDOW = 100.0
"""Transits before the end of the run whose fields are kept: more than a cycle of the paper's scenes, never all of a long run."""


Window: TypeAlias = str | Sequence[float | str]
"""(20, 45) or "20:45" in transits, or times with a unit: "10s:60s"."""


class Wanted(NamedTuple):
    """What a run is asked to keep: the history of the `interface` and the last `fields`, as the scene's `record` says where None;
    which samples of the history, and in which file during the run (default: a temporary one). `shortest` is the length (transits)
    of the run that is known if its end is not. A `checkpoint` is written every so often (transits, default 1000)."""

    interface: bool | None = None
    fields: bool | None = None
    kept: Kept = ALL
    samples: Path | None = None
    shortest: float = math.inf
    checkpoint: Path | None = None
    checkpoint_every: float | None = None


@dataclass(frozen=True)
class Records:
    """What is kept of a run on its way: `watch` for events, the `envelope` that its figure shows, the figures of the stages of a
    `protocol`, and, where asked for, the interface's history, the last fields, checkpoints and what observers `named` by the
    scene give."""

    watch: EventObserver
    envelope: Envelope
    protocol: ProtocolObserver | None
    history: HistoryFile | None
    fields: "FieldRecord | None"
    checkpoints: Checkpoints | None
    named: Mapping[str, NamedObserver]

    @property
    def observers(self) -> list[Observer]:
        """The observers of the run besides `watch`."""
        every = (self.envelope, self.protocol, self.history, *self.named.values())
        return [observer for observer in every if observer is not None]

    @property
    def marks(self) -> list[Mark]:
        """What is done at certain times of the run: fields first, so that a checkpoint has them."""
        return [mark for mark in (self.fields, self.checkpoints) if mark is not None]

    def close(self) -> None:
        """Close the history's file, which is removed unless it belongs to a checkpoint."""
        if self.history is not None:
            self.history.close()


def records_of(solver: Solver, until: float, wanted: Wanted) -> Records:
    """What is `wanted` of a run of `solver` to `until` (transits). It goes on from its checkpoint if that exists.

    Raises SceneError for fields of a model that has none and for a checkpoint of another run.
    """
    checkpoint, every = wanted.checkpoint, wanted.checkpoint_every
    samples = history_for(solver, until, wanted)
    watch, kept = EventObserver(solver.scene, solver.nodes), fields_for(solver, until, wanted.fields)
    envelope = Envelope(solver.scene, solver.nodes, wanted.kept.begin, wanted.kept.end)
    protocol = None if solver.scene.drive.is_constant else ProtocolObserver(solver.scene, solver.nodes, until)
    watched, named = watch if solver.scene.record else None, named_observers(solver)
    parts = {"events": watched, "envelope": envelope, "protocol": protocol, "interface": samples, "fields": kept}
    saved: dict[str, Resumable] = {label: part for label, part in (parts | named).items() if part is not None}
    marks = None if checkpoint is None else Checkpoints(solver, saved, checkpoint, until, _EVERY if every is None else every)
    records = Records(watch, envelope, protocol, samples, kept, marks, named)
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
    if math.isinf(until):
        raise SceneError(
            f"run.until: missing; the fields of a run's last {FIELD_WINDOW:g} transits are kept, so it needs a length"
        )
    from fullwave.fields.record import FieldRecord

    return FieldRecord(solver, max(until - FIELD_WINDOW, 0.0), until)


def history_for(solver: Solver, until: float, wanted: Wanted) -> HistoryFile | None:
    """The observer of the interface's history, if `wanted.interface` asks for it or, where that is None, the scene's `record`.

    Its samples are kept in the file `wanted.samples`, or in a temporary one, until it is closed. With checkpoints they are kept
    in a file beside those, which stays for runs that go on.
    """
    if wanted.interface is False or (wanted.interface is None and "interface" not in solver.scene.record):
        return None
    checkpoint = wanted.checkpoint
    if checkpoint is not None:
        path = checkpoint.with_name(f"{checkpoint.name}.samples")
    else:
        path = wanted.samples or _temporary_samples()
    until, kept = min(until, wanted.shortest), wanted.kept
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


def kept_of(every: int | None, window: Window | None, scene: Scene) -> Kept:
    """One in `every` samples from the beginning of the `window` to its end; all of them where None. Raises SceneError for a
    choice that makes no sense, and for a unit of time in a scene without one."""
    if window is None:
        return Kept(every or 1, 0.0, math.inf)
    ends = window.split(":") if isinstance(window, str) else list(window)
    times = [moment("window", one, scene) for one in ends]
    if len(times) != 2 or not 0.0 <= times[0] < times[1]:
        label = f"window = {shorten(':'.join(map(str, ends)))}"
        raise SceneError(f"{label}: must be BEGIN:END in transits or with a unit of time, BEGIN before END and not negative")
    return Kept(every or 1, *times)


def time_between(path: Path | None, every: float | str | None, scene: Scene) -> float | None:
    """The time between checkpoints in transits, if it is given; makes sure, before anything is computed, that checkpoints can be
    kept as asked. Raises SceneError naming the option if not."""
    if every is None:
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


def how_to_resume(path: Path | None) -> str:
    """How an interrupted run can be continued, for a message; `path` is where it was to keep checkpoints."""
    if path is None:
        return "no checkpoint was kept: --checkpoint FILE.npz keeps one to go on from"
    if path.exists():
        return f"{str(path)!r} holds the run up to t = {saved_time(path):.6g}: the same command goes on from there"
    return f"no checkpoint was due yet: --checkpoint-every TRANSITS|TIME keeps them more often in {str(path)!r}"
