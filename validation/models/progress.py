"""Progress of anything that lasts longer than two seconds: on a terminal a bar with the time left, else lines for the logger
"slipwave", which the command line prints on stderr and a Python program leaves silent; and which
model is cheaper for a long run."""

import logging
import math
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from slipwave.friction import respond, steady_state, unknown_of
from slipwave.scene import Scene
from slipwave.scene.drive import Drive
from slipwave.solve import Solver

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID

log = logging.getLogger("slipwave")
"""Automatic choices and the progress of long work, at level INFO; the command line prints it on stderr."""

PATIENCE = 2.0
"""Seconds without news before progress is shown."""

_LINE_INTERVAL = 10.0

LONG = 60.0
"""Predicted rest of a run (s) from which a cheaper model is recommended."""

_TENTH = 0.1 - 1e-9  # share of the work, less rounding, before which nothing is predicted, and of its last stretch
_MARK = 0.1  # of that share: between two times that are remembered
_UNSURE = 2.0  # ratio of two predictions from which both are told
_DEAR = {"delay", "fd", "sbp", "fem", "dg"}


Advise: TypeAlias = Callable[[tuple[float, float]], None]
"""Takes the seconds that a work still needs: the smaller and the larger prediction."""


class RemainingTime:
    """The seconds that a work still needs, by the `share` of it that is done. Nothing is predicted before a tenth of it is done;
    from then on once at its mean speed so far and once at that of its last tenth. What came before the first news may have been
    compilation and does not count."""

    def __init__(self) -> None:
        self._marks: list[tuple[float, float]] = []

    def __call__(self, share: float, now: float) -> tuple[float, float] | None:
        """The smaller and the larger prediction when the `share` (0 to 1) is done at the time `now` (s); None without one."""
        tenth = _TENTH * (1.0 - (self._marks[0][0] if self._marks else share))
        if not self._marks or share >= self._marks[-1][0] + _MARK * tenth:
            self._marks.append((share, now))
        if share - self._marks[0][0] < tenth or tenth <= 0.0:
            return None
        last = next(mark for mark in reversed(self._marks) if share - mark[0] >= tenth)
        low, high = sorted((now - when) * max(1.0 - share, 0.0) / (share - then) for then, when in (self._marks[0], last))
        return low, high


def share_of_run(drive: Drive, until: float) -> Callable[[float], float]:
    """The share of a run to `until` (transits) that is done at a time: the mean of the shares of time and of the distance that
    the `drive` has travelled, since steps follow the motion, which a hold stops."""
    start, whole = drive.travel(np.array([0.0, until]))
    if drive.is_constant or not (min(drive.velocities) >= 0.0 and whole > start):
        return lambda time: time / until
    return lambda time: 0.5 * (time / until + float(drive.travel(np.array([time]))[0] - start) / (whole - start))


class _Meter:
    """Shows nothing until PATIENCE has passed; then a bar on a terminal, else a line every ten seconds for the logger."""

    def __init__(self, label: str, total: float, share: Callable[[float], float] | None, advise: Advise | None) -> None:
        self._label, self._total, self._advise = label, total, advise
        self._share = share or (lambda done: done / total)
        self._began = self._printed = time.monotonic()
        self._remaining = RemainingTime()
        self._bar: Progress | None = None
        self._task: TaskID | None = None

    def __call__(self, done: float) -> None:
        now = time.monotonic()
        left = self._remaining(self._share(done), now)
        if left and self._advise:
            self._advise(left)
        if now - self._began < PATIENCE:
            return
        if sys.stderr.isatty():
            if self._bar is None:
                from rich.console import Console
                from rich.markup import escape
                from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn

                columns = ("{task.description}", BarColumn(), TaskProgressColumn(), TextColumn("{task.fields[left]}"))
                self._bar = Progress(*columns, console=Console(stderr=True), transient=True)
                self._task = self._bar.add_task(escape(self._label), total=self._total, left="")
                self._bar.start()
            assert self._task is not None
            self._bar.update(self._task, completed=done, left=_in_words(left))
        elif now - self._printed >= _LINE_INTERVAL:
            self._printed = now
            news = [f"{100.0 * done / self._total:.0f}%", *([_in_words(left)] if left else [])]
            log.info("%s: %s", self._label, ", ".join(news))

    def close(self) -> None:
        """Remove the bar from the screen."""
        if self._bar is not None:
            with suppress(OSError):  # a terminal that was closed
                self._bar.stop()


def _in_words(left: tuple[float, float] | None) -> str:
    """The time `left` (s), as a range where its two predictions disagree."""
    if left is None:
        return ""
    low, high = left
    return f"{low:.0f} to {high:.0f} s left" if high > _UNSURE * low else f"{math.sqrt(low * high):.0f} s left"


@contextmanager
def progress(
    label: str, total: float, share: Callable[[float], float] | None = None, advise: Advise | None = None
) -> Iterator[Callable[[float], None]]:
    """Context with a function that is called with the part of `total` that is done. The time left is predicted from the `share`
    of the work that this is, as a rule done / total, and given to `advise` too. The bar is removed at the end."""
    meter = _Meter(label, total, share, advise)
    try:
        yield meter
    finally:
        meter.close()


class News:
    """Lines for the logger on work of unknown length, at most one every ten seconds."""

    def __init__(self) -> None:
        self._printed = time.monotonic()

    def __call__(self, text: str, *values: object) -> None:
        """Log the `text` with its `values`, if it is time."""
        if (now := time.monotonic()) - self._printed >= _LINE_INTERVAL:
            self._printed = now
            log.info(text, *values)


class LongRunAdvice:
    """Logs once, if a run of `solver` is long, the cheaper model with its estimated error."""

    def __init__(self, solver: Solver) -> None:
        self._solver = solver
        self._silent = solver.model.partition(":")[0] not in _DEAR

    def foretell(self, seconds: float) -> None:
        """Take the run time (s) predicted before the run, or NaN: no figure to tell so early, but from ten times LONG on
        `RemainingTime` would be silent for more than LONG."""
        if seconds > 10.0 * LONG:
            self._tell("this run is long")

    def __call__(self, left: tuple[float, float]) -> None:
        """Take the time `left` (s), as `RemainingTime` predicts it."""
        if math.sqrt(left[0] * left[1]) >= LONG:
            self._tell(f"{_in_words(left)} of this run")

    def _tell(self, news: str) -> None:
        if not self._silent:
            log.info("%s; --model %s", news, _cheaper(self._solver.scene))
        self._silent = True


def _cheaper(scene: Scene) -> str:
    """A model that is cheaper for a scene than those without an error of their own, and what it leaves out. One echo of a change
    of V says what echoes do; viscous slabs also creep, which the fit keeps."""
    if any(slab.viscosity for slab in scene.slabs):
        return "fitted:8 is cheaper and computes the slabs by a fit of their exact impedance"
    velocity = max(scene.drive.velocities)
    _, v_z, _, friction_z, *_ = respond(scene.law, unknown_of(scene.law, velocity), steady_state(scene.law, velocity))
    echo = 2.0 * scene.impedance * v_z / friction_z
    return (
        f"quasidynamic is cheaper and leaves out the echoes of waves, each of which changes v by up to {echo:.1g} of itself "
        "(estimated; more where the motion stick-slips)"
    )
