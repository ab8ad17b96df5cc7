"""The largest Lyapunov exponent of a motion: the mean rate at which a second, nearby motion departs from it.

Both are marched. After each interval, about a cycle, their distance is measured, and the second state is moved along the
difference back to the initial distance (Benettin et al., Meccanica 15, 1980). The exponent is the mean of the logarithm of the
growth over its interval; neighbouring intervals depend on each other, so that its margin comes from batch means. It is zero for a
motion that repeats or lies on a torus: a shift in time neither grows nor decays.
"""

import math
from collections.abc import Callable
from typing import NamedTuple, cast

import numpy as np

from slipwave.errors import NumericsError
from slipwave.observe.pieces import SAME, Array
from slipwave.observe.statistics import margin_of_mean
from slipwave.solve.follow import DAY, Foresight, follow, offers
from slipwave.solve.solver import Solver, State, Stopping

WHOLE = 2.0
"""Transits: every march of equal or halved steps has a step that ends at their multiples; others are told to end one there."""

INTERVALS = 200
"""Intervals over which the growth is averaged."""

TRANSIENT = 40
"""Intervals before these, in which the difference turns to the direction of largest growth."""

# of the change of the state in WHOLE transits: far above the errors of the marches, and small enough to be linear
_DISTANCE = 1e-5


class Exponent(NamedTuple):
    """`rate` per transit with half the width of its 95 % interval, `margin`, over so many `transits`."""

    rate: float
    margin: float
    transits: float


def largest_exponent(
    solver: Solver,
    twin: Solver,
    cycle: float,
    progress: Callable[[float], None] | None = None,
    intervals: int = INTERVALS,
    most_seconds: float = DAY,
) -> Exponent:
    """Largest Lyapunov exponent of the motion of `solver` from its present time, over `intervals` intervals of about a `cycle`
    (transits). `twin`: another solver of the same scene and model, whose state is overwritten. `progress` is called with the
    intervals done.

    Raises NumericsError where a march fails and where the motion is steady sliding; SceneError if it would take more than
    `most_seconds`.
    """
    _stop([solver], math.inf)
    interval, time = WHOLE * max(1, round(cycle / WHOLE)), WHOLE * math.ceil(solver.time / WHOLE + SAME)
    both = [(marched, Foresight(marched, time + (TRANSIENT + intervals) * interval, most_seconds)) for marched in (solver, twin)]
    _stop([solver], time)
    _march(both[:1], time)
    before, now = State(), _moving(solver)
    while not _fits(before, now):  # once, and again where the solver has refined its steps meanwhile
        time += WHOLE
        _stop([solver], time)
        _march(both[:1], time)
        before, now = now, _moving(solver)
    difference = {name: array - before[name] for name, array in now.items()}
    sizes, rounding = {name: _largest(array) for name, array in difference.items()}, np.finfo(float).eps
    scales = {name: size if _DISTANCE * size > rounding * _largest(before[name]) else 0.0 for name, size in sizes.items()}
    if not any(scales.values()):
        raise NumericsError(
            f"{solver.model}: it slides steadily within rounding at t = {solver.time:.6g} transits, so that no exponent can be "
            f"measured; slipwave stability gives the rate of small disturbances (scene {solver.scene.name!r})"
        )
    rates: list[float] = []
    for count in range(TRANSIENT + intervals):
        time += interval
        _stop([solver, twin], time)
        share, state = _DISTANCE / _size(difference, scales), solver.state()
        twin.restore(state | {name: state[name] + share * array for name, array in difference.items()})
        _march(both, time)
        difference = _difference(solver, twin)
        rates.append(math.log(_size(difference, scales) / _DISTANCE) / interval)
        if progress is not None:
            progress(count + 1.0)
    kept = np.array(rates[TRANSIENT:])
    return Exponent(float(kept.mean()), margin_of_mean(kept), intervals * interval)


def _march(solvers: list[tuple[Solver, Foresight]], time: float) -> None:
    """March to `time` (transits), or to the first end of a piece beyond; without leaps, in which the solvers might differ."""
    for solver, foresight in solvers:
        follow(solver, time, [foresight], leaps=False)


def _stop(solvers: list[Solver], time: float) -> None:
    """Let those that follow the motion alone end a step at `time` (transits)."""
    for solver in solvers:
        if offers(solver, Stopping):
            cast(Stopping, solver).stop_at(time)


def _moving(solver: Solver) -> State:
    """The state without its bookkeeping and, in `now`, without the time, its first entry, and what helps the next guess, after
    the fourth."""
    state = {name: array for name, array in solver.state().items() if name not in solver.bookkeeping}
    if "now" in state:
        state["now"][[0, *range(4, state["now"].size)]] = 0.0
    return state


def _difference(solver: Solver, twin: Solver) -> State:
    """State of `twin` minus that of `solver`. Raises NumericsError if their steps differ."""
    ours, theirs = _moving(solver), _moving(twin)
    if abs(solver.time - twin.time) > SAME or not _fits(ours, theirs):
        raise NumericsError(
            f"{solver.model}: two motions close by take different steps near t = {solver.time:.6g} transits, so that they cannot "
            f"be compared (scene {solver.scene.name!r})"
        )
    return {name: theirs[name] - array for name, array in ours.items()}


def _fits(state: State, other: State) -> bool:
    return {name: array.shape for name, array in state.items()} == {name: array.shape for name, array in other.items()}


def _size(difference: State, scales: dict[str, float]) -> float:
    """Largest component of a difference, each array in units of its scale."""
    return max(_largest(array) / scales[name] for name, array in difference.items() if scales[name])


def _largest(array: Array) -> float:
    return float(np.abs(array).max(initial=0.0))
