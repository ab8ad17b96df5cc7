"""Which samples of the interface's history are kept, in the terms of the user."""

import math
from collections.abc import Sequence
from typing import TypeAlias

from slipwave.errors import SceneError
from slipwave.input.relate import moment
from slipwave.input.wording import shorten
from slipwave.scene import Scene
from validation.run.history_file import Kept

Window: TypeAlias = str | Sequence[float | str]
"""(20, 45) or "20:45" in transits, or times with a unit: "10s:60s"."""


def kept_of(every: int | None, window: Window | None, scene: Scene) -> Kept:
    """One in `every` samples from the beginning of the `window` to its end; all of them where None. Raises SceneError for a
    choice that makes no sense, and for a unit of time in a scene without one."""
    if window is None:
        return Kept(every or 1, 0.0, math.inf)
    ends = window.split(":") if isinstance(window, str) else list(window)
    shown = ":".join(map(str, ends))
    problem = SceneError(
        f"window = {shorten(shown)}: must be BEGIN:END in transits or with a unit of time, BEGIN before END and not negative"
    )
    try:
        begin, end = (moment("window", one, scene) for one in ends)
    except SceneError:
        raise
    except ValueError:
        raise problem from None
    if not 0.0 <= begin < end:
        raise problem
    return Kept(every or 1, begin, end)
