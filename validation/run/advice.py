"""Where a run will take more than a minute: one line that names the cheaper model, and its estimated error there."""

import logging
import time
from collections.abc import Callable

from slipwave.friction import respond, steady_state, unknown_of
from slipwave.scene import Scene
from slipwave.solve import Solver

LONG = 60.0
"""Seconds."""

_SOON = 5.0  # seconds after which the rest of the run is extrapolated
_DEAR = {"delay", "fd", "sbp", "fem", "dg"}


def error_without_echoes(scene: Scene) -> float:
    """Largest relative change of v by one echo of a change of V, which quasidynamic leaves out: 2 Z v_z/F_z at the largest V."""
    velocity = max(scene.drive.velocities)
    slopes = respond(scene.law, unknown_of(scene.law, velocity), steady_state(scene.law, velocity))
    return float(2.0 * scene.impedance * slopes[1] / slopes[3])


class Advice:
    """Takes how far a run of `solver` to `until` (transits) has come; says once that it is long. `clock` gives seconds."""

    def __init__(self, solver: Solver, until: float, clock: Callable[[], float] = time.monotonic) -> None:
        self._solver, self._until, self._clock = solver, until, clock
        self._began, self._start = clock(), solver.time
        elastic = all(slab.viscosity is None for slab in solver.scene.slabs)
        self._silent = solver.model.partition(":")[0] not in _DEAR or not elastic

    def __call__(self, done: float) -> None:
        """The time `done` (transits) is reached."""
        elapsed = self._clock() - self._began
        if self._silent or elapsed < _SOON or done <= self._start:
            return
        self._silent = True
        seconds = elapsed * (self._until - self._start) / (done - self._start)
        if seconds > LONG:
            logging.getLogger("slipwave").info(
                "this run will take about %.0f s; --model quasidynamic is cheaper and leaves out the echoes of waves, each of "
                "which changes v by up to %.1g of itself (estimated; more where the motion stick-slips)",
                seconds,
                error_without_echoes(self._solver.scene),
            )
