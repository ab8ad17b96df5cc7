"""Runs that write checkpoints, and go on from the last one when they are started again."""

import math
from pathlib import Path

from slipwave.errors import SceneError
from slipwave.input.relate import moment
from slipwave.input.wording import shorten
from slipwave.scene import Scene
from slipwave.solve.checkpoint import saved_time
from validation.output import require_writable


def time_between(path: Path | None, every: float | str | None, scene: Scene) -> float | None:
    """The time between checkpoints in transits, if it is given; makes sure, before anything is computed, that checkpoints can be
    kept as asked. Raises SceneError naming the option if not."""
    if every is None:
        require_writable(path, (".npz",), "--checkpoint")
        return None
    label = f"--checkpoint-every = {shorten(every)}"
    if path is None:
        raise SceneError(f"{label}: needs --checkpoint FILE")
    try:
        found = moment("--checkpoint-every", every, scene)
    except SceneError:
        raise
    except ValueError:
        found = math.nan
    if not (math.isfinite(found) and found > 0.0):
        raise SceneError(f"{label}: must be a positive number of transits, or in scenes with SI units a time as in 10s")
    require_writable(path, (".npz",), "--checkpoint")
    return found


def way_on(path: Path | None) -> str:
    """How an interrupted run can be continued, for a message; `path` is where it was to keep checkpoints."""
    if path is None:
        return "no checkpoint was kept: --checkpoint FILE.npz keeps one to go on from"
    if path.exists():
        return f"{str(path)!r} holds the run up to t = {saved_time(path):.6g}: the same command goes on from there"
    return f"no checkpoint was due yet: --checkpoint-every TRANSITS|TIME keeps them more often in {str(path)!r}"
