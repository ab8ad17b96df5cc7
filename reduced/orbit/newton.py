"""Newton's method with a derivative that serves as long as it contracts, corrected by each step (Broyden 1965), and steps
shortened until they help."""

from collections.abc import Callable
from typing import Generic, NamedTuple, Protocol, TypeVar

import numpy as np

from slipwave.errors import NumericsError
from slipwave.observe.pieces import Array

_MOST_ITERATIONS = 25
_MOST_HALVINGS = 6
_SERVES = 0.25  # reduction of the residual from which the corrected derivative serves again
_STALLED = 0.5  # reduction that counts as none
_ROUNDING = 1e-9  # residuals that no longer shrink are accepted below this


class Evaluated(Protocol):
    """The equations at some unknowns u (m,): their residual (m,)."""

    @property
    def unknowns(self) -> Array:
        """u."""

    @property
    def residual(self) -> Array:
        """What should be zero."""


At = TypeVar("At", bound=Evaluated)


class Solved(NamedTuple, Generic[At]):
    """`at` the solution, the `derivative` (m, m) taken at most `away` from it, and the `iterations`."""

    at: At
    derivative: Array
    away: float
    iterations: int


def solve(
    evaluate: Callable[[Array], At],
    derivative: Callable[[At], Array],
    guess: Array,
    tolerance: float,
    near: float,
    first: Array | None = None,
) -> Solved[At]:
    """Unknowns near `guess` at which the largest residual is below `tolerance`, or where rounding does not let it shrink. The
    derivative returned was taken at a distance (largest change of an unknown) of at most `near`. `first` may be a derivative from
    the neighbourhood, with which to begin.

    Raises NumericsError if there is no convergence, and what `evaluate` raises at the guess.
    """
    now, away, taken, matrix = evaluate(guess), np.inf, first, first
    for iteration in range(_MOST_ITERATIONS):
        if _size(now) <= tolerance:
            return _finished(derivative, now, taken, away, near, iteration)
        if matrix is None:
            taken = matrix = derivative(now)
            away = 0.0
        step = _solved(matrix, -now.residual)
        fresh = away == 0.0
        new = _shortened(evaluate, now, step, fresh)
        if not _size(new) < _STALLED * _size(now) and _size(now) < _ROUNDING:
            return _finished(derivative, now, taken, away, near, iteration)
        matrix = _corrected(matrix, now, new) if _size(new) < _SERVES * _size(now) else None
        if not fresh and not _size(new) < _size(now):
            continue  # once more from here, with a derivative of its own
        away += float(np.abs(new.unknowns - now.unknowns).max())
        now = new
    raise NumericsError(f"no convergence in {_MOST_ITERATIONS} iterations: a residual of {_size(now):.2g} is left")


def _solved(matrix: Array, right: Array) -> Array:
    try:
        step = np.linalg.solve(matrix, right)
    except np.linalg.LinAlgError:
        step = np.full_like(right, np.nan)
    if not np.isfinite(step).all():
        raise NumericsError("the linearised equations are singular")
    return np.asarray(step)


def _corrected(matrix: Array, before: Evaluated, after: Evaluated) -> Array:
    """The nearest matrix that explains the change of the residual along the step."""
    step, change = after.unknowns - before.unknowns, after.residual - before.residual
    return np.asarray(matrix + np.outer(change - matrix @ step, step / (step @ step)))


def _finished(
    derivative: Callable[[At], Array], now: At, taken: Array | None, away: float, near: float, iterations: int
) -> Solved[At]:
    if taken is not None and away < near:
        return Solved(now, taken, away, iterations)
    return Solved(now, derivative(now), 0.0, iterations)


def _size(at: Evaluated) -> float:
    return float(np.abs(at.residual).max())


def _shortened(evaluate: Callable[[Array], At], now: At, step: Array, fresh: bool) -> At:
    """The equations after `step` or, if that does not help though the derivative is `fresh`, after a half, a quarter ... of it:
    the best one found.

    Raises NumericsError if none of them can be evaluated.
    """
    best: At | None = None
    for halving in range(_MOST_HALVINGS):
        try:
            new = evaluate(now.unknowns + 0.5**halving * step)
        except NumericsError:
            continue
        if best is None or _size(new) < _size(best):
            best = new
        if not fresh or _size(new) < _size(now) or _size(now) < _ROUNDING:
            return best
    if best is None:
        raise NumericsError("no motion can be computed along Newton's step")
    return best
