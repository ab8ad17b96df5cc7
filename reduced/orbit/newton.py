"""Newton's method: the Jacobian is kept, with Broyden's (1965) updates, while the residual contracts; steps are shortened until
they reduce it."""

from collections.abc import Callable
from typing import Generic, NamedTuple, TypeVar

import numpy as np

from slipwave.errors import NumericsError
from slipwave.observe.pieces import Array
from slipwave.threads import one_thread

_MOST_ITERATIONS = 25
_MOST_HALVINGS = 6
_SERVES = 0.25  # reduction of the residual from which the corrected derivative serves again
_STALLED = 0.5  # reduction that counts as none
_ROUNDING = 1e-9  # residuals that no longer shrink are accepted below this

_Motion = TypeVar("_Motion")


class Evaluated(NamedTuple, Generic[_Motion]):
    """The `residual` (m,) of the equations at `unknowns` u (m,), and the `motion` from which it follows."""

    unknowns: Array
    residual: Array
    motion: _Motion

    @property
    def size(self) -> float:
        """The largest residual."""
        return float(np.abs(self.residual).max())


class Root(NamedTuple, Generic[_Motion]):
    """The solution `at`, a `derivative` (m, m) evaluated at the distance `away` from it, and the number of `iterations`."""

    at: Evaluated[_Motion]
    derivative: Array
    away: float
    iterations: int


def solve_by_newton(
    evaluate: Callable[[Array], Evaluated[_Motion]],
    derivative: Callable[[Evaluated[_Motion]], Array],
    guess: Array,
    tolerance: float,
    near: float,
    first: Array | None = None,
) -> Root[_Motion]:
    """Unknowns near `guess` at which the largest residual is below `tolerance`, or no longer shrinks by rounding. The returned
    derivative is evaluated within a distance (largest change of an unknown) of `near`. `first`: a derivative to start with, from
    a nearby point.

    Raises NumericsError if there is no convergence, and the errors of `evaluate` at the guess.
    """

    def finished(iterations: int) -> Root[_Motion]:
        if taken is None or away >= near:
            return Root(now, derivative(now), 0.0, iterations)
        return Root(now, taken, away, iterations)

    now, away, taken, matrix = evaluate(guess), np.inf, first, first
    for iteration in range(_MOST_ITERATIONS):
        if now.size <= tolerance:
            return finished(iteration)
        if matrix is None:
            taken = matrix = derivative(now)
            away = 0.0
        fresh = away == 0.0
        try:
            with one_thread():
                step = np.linalg.solve(matrix, -now.residual)
        except np.linalg.LinAlgError:
            step = np.full_like(now.residual, np.nan)
        if not np.isfinite(step).all():
            raise NumericsError("the linearised equations are singular")
        new = _shortened(evaluate, now, np.asarray(step), fresh)
        if not new.size < _STALLED * now.size and now.size < _ROUNDING:
            return finished(iteration)
        if new.size < _SERVES * now.size:  # Broyden: the nearest matrix that gives the change of the residual along the step
            along = new.unknowns - now.unknowns
            matrix = matrix + np.outer(new.residual - now.residual - matrix @ along, along / (along @ along))
        else:
            matrix = None
        if fresh or new.size < now.size:  # otherwise once more from here, with a derivative of its own
            away += float(np.abs(new.unknowns - now.unknowns).max())
            now = new
    raise NumericsError(f"no convergence in {_MOST_ITERATIONS} iterations: a residual of {now.size:.2g} is left")


def _shortened(
    evaluate: Callable[[Array], Evaluated[_Motion]], now: Evaluated[_Motion], step: Array, fresh: bool
) -> Evaluated[_Motion]:
    """The equations after `step` or, if that does not reduce the residual although the derivative is `fresh`, after the best of
    its halves, quarters ... Raises NumericsError if none of them can be evaluated."""
    best: Evaluated[_Motion] | None = None
    for halving in range(_MOST_HALVINGS):
        try:
            new = evaluate(now.unknowns + 0.5**halving * step)
        except NumericsError:
            continue
        best = new if best is None or new.size < best.size else best
        if not fresh or new.size < now.size or now.size < _ROUNDING:
            return best
    if best is None:
        raise NumericsError("no motion can be computed along Newton's step")
    return best
