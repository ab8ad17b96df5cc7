"""A crossing of the imaginary axis as one parameter varies, by Newton's method for the parameter and the frequency."""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from reduced.stability.characteristic import Characteristic
from reduced.stability.spectrum import follow_root, leading_roots
from slipwave.errors import NumericsError

Real = NDArray[np.float64]
_DIFFERENCE = 1e-6


def crossing(problem_at: Callable[[float], Characteristic], start: float) -> tuple[float, float]:
    """(parameter, omega), nearest to `start`, at which a root is i omega: Newton from the minima of |D(i omega)| over omega.

    Raises NumericsError if no start converges.
    """
    here = problem_at(start)
    omega = here.slopes.reach * np.geomspace(1e-8, 1.0, 1600)
    size = np.abs(here.imbalance(1j * omega))
    minima = np.flatnonzero((size[1:-1] <= size[:-2]) & (size[1:-1] <= size[2:])) + 1
    best = (math.inf, math.nan, math.nan)
    for i in minima:
        parameter, frequency = _newton(problem_at, start, float(omega[i]))
        best = min(best, (abs(parameter - start) if math.isfinite(parameter) else math.inf, parameter, frequency))
    if not math.isfinite(best[0]):
        raise NumericsError(f"stability: no crossing found near parameter {start:.6g}")
    return best[1], best[2]


def between(problem_at: Callable[[float], Characteristic], low: float, high: float) -> tuple[float, float]:
    """(parameter, omega) at which the leading root at `high`, where roots grow that do not at `low`, crosses the imaginary axis.

    Newton's method follows it from parameter to parameter. Raises NumericsError if it is no single pair that crosses in between.
    """
    from scipy.optimize import brentq

    root = complex(leading_roots(problem_at(high), 2)[0])

    def followed(parameter: float) -> float:
        """Re s of the root at `parameter`."""
        nonlocal root
        root = follow_root(problem_at(parameter), root)
        if math.isnan(root.real):
            raise ValueError
        return root.real

    try:
        at = brentq(followed, low, high, xtol=1e-13 * max(abs(low), abs(high)), rtol=1e-13)
    except ValueError:
        raise NumericsError(f"stability: no single pair of roots crosses between {low:.6g} and {high:.6g}") from None
    return float(at), abs(root.imag)


def central_differences(residual: Callable[[Real], Real], x: Real) -> Real:
    """The Jacobian of `residual` at x."""
    shifts = _DIFFERENCE * np.eye(x.size)
    return np.column_stack([(residual(x + d) - residual(x - d)) / (2.0 * _DIFFERENCE) for d in shifts])


def _newton(problem_at: Callable[[float], Characteristic], start: float, omega: float) -> tuple[float, float]:
    def residual(x: Real) -> Real:
        """(Re, Im) of the imbalance at x = (exponent, ln omega)."""
        value = complex(problem_at(float(x[0])).imbalance(1j * math.exp(x[1])))
        return np.array([value.real, value.imag])

    x = np.array([start, math.log(omega)])
    for _ in range(30):
        try:
            change = np.linalg.solve(central_differences(residual, x), -residual(x))
        except np.linalg.LinAlgError:
            break
        x = x + change * min(1.0, 0.5 / max(float(np.linalg.norm(change)), 1e-300))
        if not np.all(np.isfinite(x)) or abs(x[0] - start) > 3.0:
            break
        if np.linalg.norm(change) < 1e-12:
            return float(x[0]), math.exp(x[1])
    return math.nan, math.nan
