"""Orders in space: full waves without error in time against the delay system."""

from functools import cache
from typing import Any

from reduced.delay.alike import Delay
from slipwave.scene import Scene
from slipwave.solve import Solver
from validation.measure.grid_ladders import LadderRun, in_space, ladder_of
from validation.measure.orders import Climb, Measured, climb, measure
from validation.models.build import build
from validation.models.by_name import explicit_time, grid_of

RESOLUTION = 1e-13
_STEPS = 32
"""Least steps of the delay system per transit. No quantity differs by more than 9e-13 from `dg:14` with 8 cells."""


def climb_of(model: str) -> Climb:
    """Errors of the family without error in time (except for the leapfrog)."""
    ladder = in_space(ladder_of(*grid_of(model)))
    return climb(ladder, delay_reference(ladder.run), without_error_in_time)


@cache
def delay_reference(run: LadderRun) -> Measured:
    """The outputs of the delay system over the `run`."""
    return measure(Delay(run.scene, steps=_STEPS, tolerance=RESOLUTION), run)


def without_error_in_time(model: str, scene: Scene, cells: int, resolution: float = RESOLUTION, **options: Any) -> Solver:
    """The full wave `model` with its exact march, in steps that resolve friction to `resolution`. At order 2 as `build` makes it
    with `options`: grids are large, and explicit steps of order 4 leave 3 % of the error in space on 48 cells, less on finer."""
    family, number = grid_of(model)
    if family.order_interface(number) <= 2:
        return build(model, scene, cells=cells, **options, time=explicit_time(model))
    solver: Solver = family.maker()(scene, number, cells=cells, time="exact", resolution=resolution)
    return solver
