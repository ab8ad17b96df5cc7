"""The timer of all comparisons of run times: pieces of work that alternate in the same process, and the ratios of their times.

Times are processor seconds (`validation.measure.stopwatch`), taken after the compiled code is loaded. Errors are those of the
mean over a run's last cycles, relative to given values. What is timed is defined in `validation.benchmark`, by
`validation.wave_race` and by studies; none of these has a clock of its own.
"""

import math
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple, TypeAlias, TypeVar

import numpy as np

import slipwave
from slipwave.errors import NumericsError
from slipwave.observe import EventObserver
from slipwave.scene import Scene
from slipwave.solve import Final, Solver, follow
from validation.compute.build import build
from validation.measure.cycle import watch
from validation.measure.stopwatch import timed

_WARM_UP = 2.0  # transits
UNLIKE_R = (0.0026, 0.0029)
"""r of the upper slab of the commensurate and of the irrational pair of `alike_and_unlike`."""

Name = TypeVar("Name")
Work: TypeAlias = Callable[[], Callable[[], object]]
"""Prepares, untimed, and returns the function to be timed."""


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
        """The options as text in the report's markup."""
        words = [f"{self.cells} cells"] if self.cells else []
        words += [f"CFL {self.cfl:g}"] if self.cfl else []
        words += [f"{self.time} in time"] if self.time else []
        words += [f"tolerance 10^{{{math.log10(self.tolerance):.2g}}}"] if self.tolerance else []
        return ", ".join(words)


@dataclass(frozen=True)
class March:
    """The work of `transits` of march and event detection by a solver that has been marched to `begin`."""

    setting: Setting
    scene: Scene
    transits: float
    begin: float = 0.0

    def __call__(self) -> Callable[[], Final]:
        """Prepare the march, untimed."""
        solver = solver_of(self.setting, self.scene)
        if self.begin:
            follow(solver, self.begin)
        return partial(follow, solver, self.begin + self.transits, [EventObserver(self.scene, solver.nodes)])


def whole(function: Callable[..., object], *given: Any, **named: Any) -> Work:
    """The work of one call, timed as a whole."""
    return lambda: partial(function, *given, **named)


class Race(NamedTuple):
    """The ratio of the times of two pieces of work, `first` over `second`, and its `name`."""

    name: str
    first: Work
    second: Work

    def measure(self, rounds: int) -> dict[str, float]:
        """Median and quartiles over `rounds`, after one round that loads the compiled code."""
        times = in_turn({"first": self.first, "second": self.second}, rounds + 1)[1:]
        low, median, high = np.quantile([pair["first"] / pair["second"] for pair in times], (0.25, 0.5, 0.75))
        return {"median": float(median), "low": float(low), "high": float(high)}


def in_turn(works: Mapping[Name, Work], rounds: int) -> list[dict[Name, float]]:
    """Processor seconds of each work in each round; works alternate, so that a slower machine slows all of them."""
    return [{name: timed(prepare())[0] for name, prepare in works.items()} for _ in range(rounds)]


def time_final(setting: Setting, scene: Scene, until: float, repeats: int = 3) -> tuple[float, float]:
    """(seconds, psi at `until`) of a run without observers."""
    warm_up(setting, scene)
    runs = [timed(lambda: follow(solver_of(setting, scene), until)) for _ in range(repeats)]
    return min(seconds for seconds, _ in runs), runs[0][1].psi


def solver_of(setting: Setting, scene: Scene) -> Solver:
    """The solver of `setting`, at the start of `scene`."""
    return build(setting.model, scene, cells=setting.cells, cfl=setting.cfl, tolerance=setting.tolerance, time=setting.time)


def warm(solver: Solver) -> None:
    """Load or compile the code for a march of `solver`, which is not changed, before timing."""
    before = solver.state()
    with suppress(NumericsError):
        EventObserver(solver.scene, solver.nodes).scan(solver.advance(solver.time + _WARM_UP))
    solver.restore(before)


def warm_up(setting: Setting, scene: Scene) -> None:
    """Load or compile the code for `setting`, before timing."""
    with suppress(NumericsError):  # a run that fails reports it itself
        watch(solver_of(setting, scene), _WARM_UP if scene.until is None else min(_WARM_UP, scene.until))


def alike_and_unlike() -> dict[str, Scene]:
    """An alike, a commensurate and an irrational pair whose slip events in the first 600 transits reach about the same rate, 3300
    to 3600 V*: larger r than the gallery's for the unlike ones."""
    commensurate, irrational = UNLIKE_R
    return {
        "alike": slipwave.read("paper"),
        "commensurate": slipwave.read("unlike", {"upper.r": commensurate, "lower.r": 2.0 * commensurate}),
        "irrational": slipwave.read("unlike-irrational", {"upper.r": irrational, "lower.r": irrational * math.sqrt(2.0)}),
    }
