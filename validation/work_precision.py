"""Run time against error: one model at several settings, each timed on the same stretch of the same scene.

Every point is a whole run (march and event detection) after a warm-up that loads the compiled code. The processor time is the
least of a few repetitions. Errors are those of the mean over the run's last cycles, relative to given values.
"""

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial

from slipwave.errors import NumericsError
from slipwave.observe import EventObserver
from slipwave.scene import Scene
from slipwave.solve import Final, Solver, follow
from validation.measure.cycle import watch
from validation.measure.settle import estimate
from validation.registry.build import build
from validation.run.timing import timed

_WARM_UP = 2.0  # transits


@dataclass(frozen=True)
class Setting:
    """A model with its numerical options; `None` leaves one to the model."""

    model: str
    tolerance: float | None = None
    cells: int | None = None
    cfl: float | None = None
    time: str | None = None

    @property
    def words(self) -> str:
        """The options in words, in the report's markup."""
        words = [f"{self.cells} cells"] if self.cells else []
        words += [f"CFL {self.cfl:g}"] if self.cfl else []
        words += [f"{self.time} in time"] if self.time else []
        words += [f"tolerance 10^{{{math.log10(self.tolerance):.2g}}}"] if self.tolerance else []
        return ", ".join(words)


@dataclass(frozen=True)
class Point:
    """One timed run: seconds, relative errors of period and stress drop (signed), period in transits."""

    setting: Setting
    seconds: float
    period: float
    period_error: float
    drop_error: float


def time_run(setting: Setting, scene: Scene, until: float, exact: Mapping[str, float], repeats: int = 3) -> Point:
    """Run `setting` on `scene` to `until` (transits) and compare its last cycles with `exact` (names of `Orbit`)."""
    warm_up(setting, scene)
    runs = [timed(lambda: watch(solver_of(setting, scene), until)) for _ in range(repeats)]
    orbit = estimate(runs[0][1].events()).values()
    period, drop = (orbit[name] / exact[name] - 1.0 for name in ("period", "stress_drop"))
    return Point(setting, min(seconds for seconds, _ in runs), orbit["period"], period, drop)


def time_final(setting: Setting, scene: Scene, until: float, repeats: int = 3) -> tuple[float, float]:
    """(seconds, psi at `until`) of a run that observes nothing."""
    warm_up(setting, scene)
    runs = [timed(lambda: follow(solver_of(setting, scene), until)) for _ in range(repeats)]
    return min(seconds for seconds, _ in runs), runs[0][1].psi


def cheapest(points: Sequence[Point], error: float) -> Point | None:
    """The fastest point whose period is right to `error`, if there is one."""
    able = [point for point in points if abs(point.period_error) <= error]
    return min(able, key=lambda point: point.seconds) if able else None


def solver_of(setting: Setting, scene: Scene) -> Solver:
    """The solver that `setting` asks for, at the start of `scene`."""
    return build(setting.model, scene, cells=setting.cells, cfl=setting.cfl, tolerance=setting.tolerance, time=setting.time)


def march_of(setting: Setting, scene: Scene, transits: float, begin: float = 0.0) -> "partial[Final]":
    """The work that is timed: `transits` of march and event detection, by a solver that has been marched to `begin`."""
    solver = solver_of(setting, scene)
    if begin:
        follow(solver, begin)
    return partial(follow, solver, begin + transits, [EventObserver(scene, solver.nodes)])


def warm(solver: Solver) -> None:
    """Load or compile what a march of `solver` needs, before a clock starts; the solver itself stays where it is."""
    before = solver.state()
    with suppress(NumericsError):
        EventObserver(solver.scene, solver.nodes).scan(solver.advance(solver.time + _WARM_UP))
    solver.restore(before)


def warm_up(setting: Setting, scene: Scene) -> None:
    """Load or compile what `setting` needs, before a clock starts."""
    with suppress(NumericsError):  # a run that fails reports it itself
        watch(solver_of(setting, scene), _WARM_UP if scene.until is None else min(_WARM_UP, scene.until))
