"""Progress of anything that lasts longer than two seconds: on a terminal a bar with the time left, else lines for the logger
"slipwave", which the command line prints on stderr and a Python program leaves silent."""

import logging
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID

PATIENCE = 2.0
"""Seconds without news before progress is shown."""

_LINE_INTERVAL = 10.0


class _Meter:
    """Shows nothing until PATIENCE has passed; then a bar on a terminal, else a line every ten seconds for the logger."""

    def __init__(self, label: str, total: float) -> None:
        self._label, self._total = label, total
        self._began = self._printed = time.monotonic()
        self._first: tuple[float, float] | None = None
        self._bar: Progress | None = None
        self._task: TaskID | None = None

    def __call__(self, done: float) -> None:
        now = time.monotonic()
        self._first = self._first or (now, done)  # what came before may have been compilation
        if now - self._began < PATIENCE:
            return
        if sys.stderr.isatty():
            self._draw(done)
        elif now - self._printed >= _LINE_INTERVAL:
            self._printed = now
            left = (now - self._first[0]) * (self._total - done) / max(done - self._first[1], 1e-9)
            news = f", {left:.0f} s left" if done > self._first[1] else ""
            logging.getLogger("slipwave").info("%s: %.0f%%%s", self._label, 100.0 * done / self._total, news)

    def _draw(self, done: float) -> None:
        if self._bar is None:
            from rich.console import Console
            from rich.markup import escape
            from rich.progress import Progress

            self._bar = Progress(console=Console(stderr=True), transient=True)
            self._task = self._bar.add_task(escape(self._label), total=self._total)
            self._bar.start()
        assert self._task is not None
        self._bar.update(self._task, completed=done)

    def close(self) -> None:
        """Take the bar off the screen."""
        if self._bar is not None:
            self._bar.stop()


@contextmanager
def progress(label: str, total: float) -> Iterator[Callable[[float], None]]:
    """A function that takes how much of `total` is done. What it showed is removed when the block ends."""
    meter = _Meter(label, total)
    try:
        yield meter
    finally:
        meter.close()
