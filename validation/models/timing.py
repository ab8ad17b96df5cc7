"""The timer of all comparisons of run times: works that alternate in one process, so that a slower machine slows all of them.

A time is the median over rounds, with its quartiles, taken after the compiled code is loaded. Processor time hardly depends on
other work of the machine.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from functools import partial
from typing import Any, TypeAlias, TypeVar, Unpack

import numpy as np

from slipwave.errors import NumericsError
from slipwave.observe import EventObserver
from slipwave.scene import Scene
from slipwave.solve import Final, Solver, follow
from validation.models import stopwatch
from validation.models.build import build
from validation.models.by_name import Options

WARM_UP = 2.0
"""Transits marched before timing, which load or compile the code."""
_warmed: set[tuple[object, ...]] = set()

Name = TypeVar("Name")
Answer = TypeVar("Answer")
Work: TypeAlias = Callable[[], Callable[[], Answer]]
"""Prepares, untimed, and returns the function to be timed."""


def alternating(
    works: Mapping[Name, Work[Answer]], rounds: int, clock: Callable[[], float] | None = None
) -> Iterator[tuple[Name, float, Answer]]:
    """(name, seconds, answer) of each work, in each of the `rounds`; processor seconds, unless there is another `clock`."""
    clock = clock or stopwatch.processor_seconds
    for _ in range(rounds):
        for name, prepare in works.items():
            work = prepare()
            began = clock()
            answer = work()
            yield name, clock() - began, answer


def in_turn(works: Mapping[Name, Work[Any]], rounds: int) -> list[dict[Name, float]]:
    """Processor seconds of each work in each round."""
    timed = [(name, seconds) for name, seconds, _ in alternating(works, rounds)]
    return [dict(timed[k : k + len(works)]) for k in range(0, len(timed), len(works))]


def quartiles(values: Iterable[float]) -> tuple[float, float, float]:
    """Lower quartile, median, upper quartile."""
    low, median, high = np.quantile(list(values), (0.25, 0.5, 0.75)).tolist()
    return low, median, high


def marching(model: str, scene: Scene, transits: float, begin: float = 0.0, **options: Unpack[Options]) -> Work[Final]:
    """The work of `transits` of march and event detection by a `model` with these `options` that has been marched to `begin`."""

    def prepared() -> Callable[[], Final]:
        """The march, to be timed."""
        solver = build(model, scene, **options)
        if begin:
            follow(solver, begin)
        return partial(follow, solver, begin + transits, [EventObserver(scene, solver.nodes)])

    return prepared


def warm(solver: Solver) -> None:
    """Load or compile the code for a march of `solver`, which is not changed, before timing; once for models and scenes of the
    same kinds."""
    scene = solver.scene
    slabs = ((type(slab.face), type(slab.viscosity), len(slab.layers)) for slab in scene.slabs)
    kinds = solver.model, type(solver), type(scene.law), type(scene.drive.compiled), *slabs
    if kinds in _warmed:
        return
    _warmed.add(kinds)
    before = solver.state()
    with suppress(NumericsError):
        EventObserver(solver.scene, solver.nodes).scan(solver.advance(solver.time + WARM_UP))
    solver.restore(before)
