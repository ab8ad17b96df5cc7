"""Progress of anything that lasts longer than two seconds: on a terminal a bar with the time left, else lines for the logger
"slipwave", which the command line prints on stderr and a Python program leaves silent; and which
model is cheaper for a long run."""

import logging
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from slipwave.friction import respond, steady_state, unknown_of
from slipwave.scene import Scene
from slipwave.solve import Solver

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID

PATIENCE = 2.0
"""Seconds without news before progress is shown."""

_LINE_INTERVAL = 10.0

LONG = 60.0
"""Predicted run time (s) from which a cheaper model is recommended."""

_SOON = 5.0  # seconds after which the rest of the run is extrapolated
_DEAR = {"delay", "fd", "sbp", "fem", "dg"}


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
            if self._bar is None:
                from rich.console import Console
                from rich.markup import escape
                from rich.progress import Progress

                self._bar = Progress(console=Console(stderr=True), transient=True)
                self._task = self._bar.add_task(escape(self._label), total=self._total)
                self._bar.start()
            assert self._task is not None
            self._bar.update(self._task, completed=done)
        elif now - self._printed >= _LINE_INTERVAL:
            self._printed = now
            left = (now - self._first[0]) * (self._total - done) / max(done - self._first[1], 1e-9)
            news = f", {left:.0f} s left" if done > self._first[1] else ""
            logging.getLogger("slipwave").info("%s: %.0f%%%s", self._label, 100.0 * done / self._total, news)

    def close(self) -> None:
        """Remove the bar from the screen."""
        if self._bar is not None:
            self._bar.stop()


@contextmanager
def progress(label: str, total: float) -> Iterator[Callable[[float], None]]:
    """Context with a function that is called with the part of `total` that is done. The bar is removed at the end."""
    meter = _Meter(label, total)
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
            logging.getLogger("slipwave").info(text, *values)


def error_without_echoes(scene: Scene) -> float:
    """Largest relative change of v by one echo of a change of V, which quasidynamic leaves out: 2 Z v_z/F_z at the largest V."""
    velocity = max(scene.drive.velocities)
    slopes = respond(scene.law, unknown_of(scene.law, velocity), steady_state(scene.law, velocity))
    return float(2.0 * scene.impedance * slopes[1] / slopes[3])


class LongRunAdvice:
    """Progress of a run of `solver` to `until` (transits), passed on to `report`; logs once, if the run is long, the cheaper
    model with its estimated error."""

    def __init__(self, solver: Solver, until: float, report: Callable[[float], None]) -> None:
        self._solver, self._until, self._report = solver, until, report
        self._first: tuple[float, float] | None = None
        elastic = all(slab.viscosity is None for slab in solver.scene.slabs)
        self._silent = solver.model.partition(":")[0] not in _DEAR or not elastic

    def __call__(self, done: float) -> None:
        """Report the time `done` (transits)."""
        self._report(done)
        now = time.monotonic()
        began, start = self._first = self._first or (now, done)  # what came before may have been compilation
        if self._silent or now - began < _SOON or done <= start:
            return
        self._silent = True
        seconds = (now - began) * (self._until - start) / (done - start)
        if seconds > LONG:
            logging.getLogger("slipwave").info(
                "this run will take about %.0f s; --model quasidynamic is cheaper and leaves out the echoes of waves, each of "
                "which changes v by up to %.1g of itself (estimated; more where the motion stick-slips)",
                seconds,
                error_without_echoes(self._solver.scene),
            )
