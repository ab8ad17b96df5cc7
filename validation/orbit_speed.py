"""Processor time of orbits and branches; nothing is judged.

python -m validation.orbit_speed       # half a minute
"""

import math
from collections.abc import Callable, Iterator
from functools import partial
from typing import NamedTuple

from reduced.orbit import periodic_orbit
from reduced.orbit.approach import Guess, approach
from slipwave.observe.pieces import Array
from slipwave.step.flow import Flow
from validation.output import print_table
from validation.registry.flows import moving
from validation.registry.orbits import find_orbit
from validation.run.timing import timed
from validation.study.over_r import FAR, branch_of, scene_at

_REPEATS = 5
_TOLERANCE = 1e-10
_FINER = 4.0  # of two meshes or periods whose costs are compared


class Row(NamedTuple):
    """What was timed, in words, and what was measured."""

    what: str
    measured: str


def rows() -> Iterator[Row]:
    """Orbits, how their cost grows, and branches."""
    scene = scene_at(-2.68)
    find_orbit(moving("delay", scene, _TOLERANCE), _TOLERANCE)  # compiled
    seconds = _least(lambda: find_orbit(moving("delay", scene, _TOLERANCE), _TOLERANCE))
    yield Row("delay orbit at log10 r = -2.68 to 1e-10, run included", f"{1e3 * seconds:.0f} ms")
    for model in ("delay", "kelvin-voigt"):
        guess = _guess(model)
        seconds = _least(partial(periodic_orbit, *guess[:3], _TOLERANCE))
        yield Row(f"{model}: from the run's last cycle to errors of 1e-10", f"{1e3 * seconds:.0f} ms")
        yield Row(f"{model}: power of the cost of an orbit in mesh points", f"{_in_mesh(guess):.2f}")
        yield Row(f"{model}: power of the cost in T", f"{_in_period(guess):.2f}")
    for model, longest in (("kelvin-voigt", FAR), ("delay", 85.0)):
        seconds, branch = timed(partial(branch_of, model, -2.3, longest))
        end = branch.points[-1]
        what = f"{model} branch from the Hopf point to log10 r = {end.parameter:.3f}, T = {end.closed.cycle.period:.2f}"
        yield Row(what, f"{seconds:.1f} s, {1 + len(branch.special)} special points")


def _guess(model: str) -> Guess:
    known = moving(model, scene_at(-2.68), _TOLERANCE)
    return approach(known.solver, known.freeze)


def _in_mesh(guess: Guess) -> float:
    """Of a march with its derivative, on two meshes."""
    cycle = guess.flow.march(guess.state, guess.period)
    coarse, fine = (guess.flow.remeshed(cycle, finer) for finer in (1.0, _FINER))
    points = [flow.march(state, guess.period).pieces.length.size for flow, state in (coarse, fine)]
    first, last = (_cost(flow, state, guess.period) for flow, state in (coarse, fine))
    return _power(first, last, points[1] / points[0])


def _in_period(guess: Guess) -> float:
    """Of a march with its derivative, over one period and over several with the same steps."""
    cycle = guess.flow.march(guess.state, guess.period)
    once, often = (guess.flow.remeshed(cycle._replace(period=times * guess.period), 1.0) for times in (1.0, _FINER))
    return _power(_cost(*once, guess.period), _cost(*often, _FINER * guess.period), _FINER)


def _cost(flow: Flow, state: Array, period: float) -> float:
    return _least(lambda: flow.tangent(flow.march(state, period)))


def _power(first: float, second: float, ratio: float) -> float:
    return math.log(second / first) / math.log(ratio)


def _least(work: Callable[[], object]) -> float:
    return min(timed(work)[0] for _ in range(_REPEATS))


if __name__ == "__main__":
    print_table(["what", "measured"], [list(row) for row in rows()])
