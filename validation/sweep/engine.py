"""Computes the points of a plan on any `concurrent.futures.Executor`, part by part, and writes each finished part."""

import math
import time
from collections import deque
from collections.abc import Callable, Iterable
from concurrent.futures import FIRST_COMPLETED, CancelledError, Executor, Future, wait
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numba.core.errors import NumbaError

from slipwave.errors import NumericsError, SceneError
from slipwave.friction.own import LAW_FILES, refused_by_compiler
from validation.data.variables import in_si
from validation.models.own import load_own, own_files
from validation.sweep.measures import MOST_CYCLES, Figures, Measure, measure_of
from validation.sweep.plan import Indices, Plan
from validation.sweep.store import STATUS, Columns, Store

PART_SECONDS, SLOW_PART_SECONDS = 10.0, 60.0
"""Target time (s) of a part, and of a part with points of more than a second each."""

IN_FLIGHT = 3
"""Most submitted and unfinished parts per worker: more would fill the memory of a scheduler."""

_LARGEST = 20_000
_TRIES = 3
_PATIENCE = 5.0  # seconds between looks at the scheduler


Computed: TypeAlias = tuple[Columns, float]
"""Columns of the points of a part, and the time that they took (s)."""


def compute(plan: Plan, points: Indices, laws: Iterable[Path] = (), families: Iterable[Path] = ()) -> Computed:
    """The figures of these points, computed in this process, and the time that took (s); the user's files of laws and families
    are loaded before. Never raises, but a SceneError for one of these: a point that cannot be computed has a status and a
    reason."""
    load_own(laws, families)
    began = time.perf_counter()
    measure = measure_of(plan.measure)
    rows = [_point(plan, measure, int(point)) for point in points]
    return _columns_of(measure, rows), time.perf_counter() - began


def _point(plan: Plan, measure: Measure, point: int) -> Figures:
    try:
        scene = plan.scene(point)
        figures = measure.of(scene, plan.model(point), plan.options)
        return {"status": "done", **figures, **in_si(figures, measure.columns, scene)}
    except SceneError as refusal:
        return {"status": "refused", "reason": str(refusal)}
    except NumericsError as failure:
        return {"status": "failed", "reason": str(failure)}
    except NumbaError as error:
        return {"status": "failed", "reason": str(refused_by_compiler(error)).partition("\n")[0]}
    except Exception as bug:
        return {"status": "failed", "reason": " ".join(f"{type(bug).__name__}: {bug}".split())}


def _columns_of(measure: Measure, rows: list[Figures]) -> Columns:
    """Rows as one array per figure: numbers, NaN if missing; words as their numbers, -1 if missing."""
    names = dict.fromkeys([*measure.columns, *(name for row in rows for name in row if name not in ("status", "reason"))])
    columns: dict[str, Any] = {"status": np.array([STATUS.index(str(row["status"])) for row in rows], dtype=np.int8)}
    columns["reason"] = np.array([str(row.get("reason", "")) for row in rows])
    for name in names:
        values = [row.get(name) for row in rows]
        if name.startswith(measure.lists) and measure.lists:
            columns[name] = np.array([_padded(value) for value in values])
        elif name in measure.words:
            columns[name] = np.array([_word(measure.words[name], value) for value in values], dtype=np.int8)
        else:
            columns[name] = np.array([math.nan if value is None else float(value) for value in values])
    return columns


def _padded(values: Any) -> Any:
    row = np.full(MOST_CYCLES, math.nan)
    row[: np.size(values)] = math.nan if values is None else values
    return row


def _word(words: tuple[str, ...], value: Any) -> int:
    if value is None:
        return -1
    return int(value) if isinstance(value, bool) else words.index(str(value))


@dataclass
class Engine:
    """Runs parts of `plan` on executors made by `start`, with `workers` workers, and writes finished parts to the `store`. Their
    size follows from the time of earlier ones; at the end they become smaller, so that all workers end together."""

    plan: Plan
    store: Store
    start: Callable[[], Executor]
    workers: int
    report: Callable[[int], None] = lambda points: None
    alive: Callable[[], bool] = lambda: True

    def __post_init__(self) -> None:
        self.seconds_per_point = math.nan
        self._size, self._largest = 1.0, 0  # points of a part, and of the largest one so far
        self._refusals = 0  # of parts, since the executor last took one

    def run(self, points: Indices) -> None:
        """Compute these points, in this order. A part whose process was killed is repeated; a point whose process was killed
        three times in a row gets that status. Raises NumericsError if the executor disappears or accepts no parts; finished parts
        are kept.
        """
        waiting: deque[tuple[Indices, int]] = deque([(points, 0)] if points.size else [])
        while waiting:
            flying: dict[Future[Computed], tuple[Indices, int]] = {}
            try:
                self._drain(self.start(), waiting, flying)
            finally:
                for future in flying:
                    future.cancel()

    def _drain(
        self, executor: Executor, waiting: deque[tuple[Indices, int]], flying: dict["Future[Computed]", tuple[Indices, int]]
    ) -> None:
        """Run until nothing is left, or the executor breaks: parts in flight are then `waiting` again."""
        broken = False
        while flying or (waiting and not broken):
            while waiting and not broken and len(flying) < self._most(waiting, flying):
                part, deaths = self._next(waiting)
                try:
                    flying[executor.submit(compute, self.plan, part, [*LAW_FILES], own_files())] = part, deaths
                    self._refusals = 0
                except Exception as error:  # whatever the executor raises: `compute` itself never does
                    waiting.appendleft((part, deaths))
                    broken, self._refusals = True, self._refusals + 1
                    if self._refusals > _TRIES:
                        raise NumericsError(f"the executor takes no parts: {error}; finished parts are kept") from None
            alone = len(flying) == 1
            for future in wait(flying, _PATIENCE, FIRST_COMPLETED).done:
                part, deaths = flying.pop(future)
                try:
                    columns, seconds = future.result()
                except SceneError as error:
                    raise NumericsError(f"no part can be computed there: {error}; finished parts are kept") from None
                except (Exception, CancelledError):
                    broken = True
                    self._again(waiting, part, max(deaths, 1) + alone)
                    continue
                self._learn(part.size, seconds)
                self.store.write(part, columns)
                self.report(part.size)
            if not self.alive():
                raise NumericsError(
                    "the scheduler went away; finished parts are kept, the same command goes on without --scheduler"
                )

    def _most(self, waiting: deque[tuple[Indices, int]], flying: dict["Future[Computed]", tuple[Indices, int]]) -> int:
        """Most parts in flight; one if a process was killed, to identify the part that kills."""
        return 1 if any(deaths for _, deaths in (waiting[0], *flying.values())) else IN_FLIGHT * self.workers

    def _learn(self, count: int, seconds: float) -> None:
        """Take a finished part of `count` points into account, but only the largest so far: the first points of a process include
        its start. The size grows at most eightfold at a time."""
        if count < 0.5 * self._largest:
            return
        self._largest = max(self._largest, count)
        self.seconds_per_point = max(seconds / count, 1e-6)
        wanted = (SLOW_PART_SECONDS if self.seconds_per_point > 1.0 else PART_SECONDS) / self.seconds_per_point
        self._size = min(max(1.0, wanted), 8.0 * self._size, _LARGEST)

    def _next(self, waiting: deque[tuple[Indices, int]]) -> tuple[Indices, int]:
        rest, deaths = waiting.popleft()
        usual = max(min(self._size, rest.size / (2 * self.workers)), self._size / 16.0, 1.0)
        count = rest.size if deaths else int(min(rest.size, usual))
        if rest.size > count:
            waiting.appendleft((rest[count:], deaths))
        return rest[:count], deaths

    def _again(self, waiting: deque[tuple[Indices, int]], part: Indices, deaths: int) -> None:
        """Requeue a part whose process was killed, to be computed alone (another part may have killed it); after three kills in a
        row, in halves, down to the point that kills."""
        if deaths <= _TRIES:
            waiting.appendleft((part, deaths))
        elif part.size > 1:
            middle = part.size // 2
            waiting.extendleft([(part[middle:], 1), (part[:middle], 1)])
        else:
            why = f"the process was killed {_TRIES} times in a row (out of memory?)"
            self.store.write(part, _columns_of(measure_of(self.plan.measure), [{"status": "died", "reason": why}]))
            self.report(1)
