"""Runs that write checkpoints, and go on from the last one when they are started again."""

import math
from pathlib import Path

from slipwave.errors import SceneError
from slipwave.observe.checkpoint import saved_time
from validation.output import require_writable


def require_checkpoint(path: Path | None, every: float | None) -> None:
    """Make sure, before anything is computed, that checkpoints can be kept as asked; SceneError naming the option if not."""
    if every is not None and path is None:
        raise SceneError(f"--checkpoint-every = {every:g}: needs --checkpoint FILE")
    if every is not None and not (math.isfinite(every) and every > 0.0):
        raise SceneError(f"--checkpoint-every = {every:g}: must be a positive number of transits")
    require_writable(path, (".npz",), "--checkpoint")


def way_on(path: Path | None) -> str:
    """How an interrupted run can be continued, for a message; `path` is where it was to keep checkpoints."""
    if path is None:
        return "no checkpoint was kept: --checkpoint FILE.npz keeps one to go on from"
    if path.exists():
        return f"{str(path)!r} holds the run up to t = {saved_time(path):.6g}: the same command goes on from there"
    return f"no checkpoint was due yet: --checkpoint-every TRANSITS keeps them more often in {str(path)!r}"
