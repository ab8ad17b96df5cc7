"""What a run keeps if it is asked to: the interface's history, the fields of the last transits, checkpoints."""

import math
import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from slipwave.errors import SceneError
from slipwave.files import part_of, remove_leftovers, require_writable
from slipwave.input.assemble import moment
from slipwave.input.quantity import looks_measured, quantity
from slipwave.input.wording import shorten
from slipwave.scene import Scene
from slipwave.solve import FieldSolver, Solver
from slipwave.solve.checkpoint import saved_time
from validation.models.history_file import HistoryFile, Kept

if TYPE_CHECKING:
    from fullwave.fields.record import FieldRecord

FIELD_FILES = (".vtu", ".xdmf", ".nc")
"""Kinds of file that fields are written to."""

FIELD_WINDOW = 100.0
"""Transits before the end of the run whose fields are kept: more than a cycle of the paper's scenes, never all of a long run."""

Window: TypeAlias = str | Sequence[float | str]
"""(20, 45) or "20:45" in transits, or times with a unit: "10s:60s"."""


def fields_for(solver: Solver, until: float, fields: bool | None) -> "FieldRecord | None":
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


def history_for(solver: Solver, until: float, kept: Kept, samples: Path | None, checkpoint: Path | None) -> HistoryFile:
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


def kept_of(every: int | None, window: Window | None, scene: Scene, rate: float | str | None = None) -> Kept:
    """One in `every` samples from the beginning of the `window` to its end, or even ones at a `rate`; all of them where None.
    Raises SceneError for a choice that makes no sense, and for a unit of time in a scene without one."""
    step = 0.0 if rate is None else _step(rate, scene)
    if window is None:
        return Kept(every or 1, 0.0, math.inf, step)
    ends = window.split(":") if isinstance(window, str) else list(window)
    times = [moment("window", one, scene) for one in ends]
    if len(times) != 2 or not 0.0 <= times[0] < times[1]:
        label = f"window = {shorten(':'.join(map(str, ends)))}"
        raise SceneError(f"{label}: must be BEGIN:END in transits or with a unit of time, BEGIN before END and not negative")
    return Kept(every or 1, times[0], times[1], step)


def _step(rate: float | str, scene: Scene) -> float:
    """Transits between two samples. Raises SceneError unless the rate is a positive number per transit or a frequency."""
    measured = isinstance(rate, str) and looks_measured(rate)
    try:
        per = quantity(str(rate), "Hz").value if measured else float(rate)
    except ValueError:
        per = math.nan
    if not 0.0 < per < math.inf:
        raise SceneError(f"rate = {shorten(rate)}: must be a positive number of samples per transit, or a frequency as in 1kHz")
    return moment("rate", f"{1.0 / per:.17g} s", scene) if measured else 1.0 / per


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


def how_to_resume(path: Path | None) -> str:
    """How an interrupted run can be continued, for a message; `path`: its checkpoint."""
    if path is None:
        return "no checkpoint was kept: --checkpoint FILE.npz keeps one to go on from"
    if path.exists():
        return f"{str(path)!r} holds the run up to t = {saved_time(path):.6g}: the same command goes on from there"
    return f"no checkpoint was due yet: --checkpoint-every TRANSITS|TIME keeps them more often in {str(path)!r}"
