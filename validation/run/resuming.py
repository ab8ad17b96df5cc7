"""Runs that leave checkpoints on their way and go on from the last one when they are started again."""

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, cast

from slipwave.errors import SceneError
from slipwave.observe import Final, Solver, follow
from slipwave.observe.follow import Observer
from slipwave.scene.start import StartKind
from validation.output import require_writable
from validation.run.simulate import March

if TYPE_CHECKING:
    from slipwave.observe.checkpoint import ResumableObserver, ResumableSolver


class CheckpointMarch:
    """Marches a full-wave solver as `follow` does, from `path` if that exists, saving to it every `every` transits.

    Raises SceneError for a solver that keeps no checkpoints, an `every` out of range, a path that cannot be written and, when
    called, for a file that belongs to another scene, model or setting.
    """

    def __init__(self, solver: Solver, path: Path, every: float) -> None:
        if not (math.isfinite(every) and every > 0.0):
            raise SceneError(f"--checkpoint-every = {every:g}: must be a positive number of transits")
        if not (hasattr(solver, "snapshot") and hasattr(solver, "restore")):
            orbiting = solver.scene.start.kind is StartKind.ORBIT
            reason = (
                "a start on the orbit keeps none" if orbiting else f"model {solver.model} keeps none; it is cheap to run again"
            )
            raise SceneError(f"--checkpoint = {str(path)!r}: {reason}; only full-wave models from other starts do")
        require_writable(path, (".npz",), "--checkpoint")
        self._path, self._every = path, every

    def __call__(
        self, solver: Solver, until: float, observers: Sequence[Observer] = (), progress: Callable[[float], None] | None = None
    ) -> Final:
        """March to `until` (transits), as `follow`."""
        from slipwave.observe.checkpoint import follow_with_checkpoints

        watching = {type(observer).__name__: cast("ResumableObserver", observer) for observer in observers}
        return follow_with_checkpoints(cast("ResumableSolver", solver), until, self._path, self._every, watching, progress)


def way_on(solver: Solver, path: Path | None) -> str:
    """How an interrupted run can be taken up again, for a message; `path` is where it was to keep checkpoints."""
    if path is not None and path.exists():
        from slipwave.observe.checkpoint import saved_time

        return f"{str(path)!r} holds the run up to t = {saved_time(path):.6g}: the same command goes on from there"
    if path is not None:
        return f"no checkpoint was due yet: --checkpoint-every TRANSITS keeps them more often in {str(path)!r}"
    if hasattr(solver, "restore"):
        return "no checkpoint was kept: --checkpoint FILE.npz keeps one to go on from"
    return f"no checkpoint was kept, model {solver.model} has none: a full-wave model with --checkpoint FILE.npz keeps one"


def march_for(solver: Solver, path: Path | None, every: float | None, otherwise: March) -> March:
    """What takes `solver` to the end of a run: by checkpoints if there is a `path` for them, else `otherwise`.

    Raises SceneError for `every` without a path and for fields asked for besides (their window is not saved).
    """
    if path is None:
        if every is not None:
            raise SceneError(f"--checkpoint-every = {every:g}: needs --checkpoint FILE")
        return otherwise
    if otherwise is not follow:
        raise SceneError(f"--checkpoint = {str(path)!r}: cannot be combined with --fields, whose window is not saved")
    return CheckpointMarch(solver, path, 1000.0 if every is None else every)
