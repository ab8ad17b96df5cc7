"""The solvers of the study: the delay system on short steps, and a grid whose march has no error in time."""

from functools import cache
from typing import Any

from reduced.delay.alike import Delay
from slipwave.scene import Scene
from slipwave.solve import Solver
from validation.measure.grid_ladders import Course
from validation.measure.orders import Measured, measure
from validation.registry.build import build
from validation.registry.families import explicit_time, grid_of

RESOLUTION = 1e-13
_STEPS = 32
"""Steps of the delay system per transit, at least. No quantity differs by more than 9e-13 from `dg:14` with 8 cells."""


@cache
def reference(course: Course) -> Measured:
    """What the delay system gives over the `course`."""
    return measure(Delay(course.scene, steps=_STEPS, tolerance=RESOLUTION), course)


def without_error_in_time(model: str, scene: Scene, cells: int, resolution: float = RESOLUTION, **options: Any) -> Solver:
    """The full wave `model` with its exact march, in steps that resolve friction to `resolution`. At order 2 as `build` makes it
    with `options`: grids are large, and explicit steps of order 4 leave 3 % of the error in space on 48 cells, less on finer."""
    family, number = grid_of(model)
    if family.order_interface(number) <= 2:
        return build(model, scene, cells=cells, **options, time=explicit_time(model))
    solver: Solver = family.maker()(scene, number, cells=cells, time="exact", resolution=resolution)
    return solver
