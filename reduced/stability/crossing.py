"""Locates the loss of stability of steady sliding as one parameter varies: counts of roots bracket it, and the root that crosses
the imaginary axis is followed through the bracket."""

import math
from collections.abc import Callable

from reduced.stability.characteristic import Characteristic, characteristic
from reduced.stability.spectrum import follow_root, leading_roots, unstable_count
from slipwave.errors import NumericsError
from slipwave.scene import Scene

FIRST_OCTAVE, LAST_OCTAVE = -20, 10
"""Exponents of two of the least and the largest factor that is tried."""

_FIRST_STEP = 0.125
_OFFSETS = (1e-6, 1e-4, 1e-2)
"""Relative distances from a critical value at which roots are counted; the next one if all roots are neutral at the smaller."""


def between(problem_at: Callable[[float], Characteristic], low: float, high: float, root: complex) -> tuple[float, float]:
    """(parameter, omega) between `low` and `high` at which the `root` at `high`, which grows, crosses the imaginary axis.

    Newton's method follows the root. Raises NumericsError if not a single pair crosses in between.
    """
    from scipy.optimize import brentq

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


def is_lost(problem_at: Callable[[float], Characteristic], value: float, rising: bool = True) -> bool:
    """Whether stability is lost at `value` as the parameter rises (or falls): no root grows just before it, by a count."""
    for aside in _OFFSETS:
        before, after = (unstable_count(problem_at(value * (1.0 + (aside if rising else -aside) * way))) for way in (-1.0, 1.0))
        if before > 0 or after > 0:
            return before == 0
    return False


def critical_factor(at: Callable[[float], Scene], model: str, start: float = 1.0) -> tuple[float, float]:
    """(factor, omega): the factor next to `start` at which steady sliding of the scene `at(factor)` loses stability, and the
    frequency there: above `start` if it is stable there, below if not. (nan, nan) if there is none from 2^-20 to 2^10.

    Roots are counted in steps of an eighth to one octave until the stability changes; the bracket is halved, and the crossing
    root is followed through it. No root grows just below the result, and one does just above.
    """

    def problem(exponent: float) -> Characteristic:
        """The characteristic function for the factor 2^exponent."""
        return characteristic(at(2.0**exponent), model)

    def unstable(exponent: float) -> bool:
        """Whether a root lies in the right half plane for this exponent."""
        return unstable_count(problem(exponent)) > 0

    def growing(exponent: float) -> complex:
        """The leading root for this exponent."""
        roots = leading_roots(problem(exponent), 2)
        if not roots.size:
            raise NumericsError("stability: the root that grows is neutral within rounding: friction and slabs balance at rest")
        return complex(roots[0])

    last, step = math.log2(start), _FIRST_STEP
    began = unstable(last)
    while True:
        here = last - step if began else last + step
        if not FIRST_OCTAVE <= here <= LAST_OCTAVE:
            return math.nan, math.nan
        if unstable(here) != began:
            break
        last, step = here, min(2.0 * step, 1.0)
    low, high = min(last, here), max(last, here)
    for width in (1.0, 1e-4):
        low, high = _halved(unstable, low, high, width)
        try:
            exponent, omega = between(problem, low, high, growing(high))
        except NumericsError:  # no single root can be followed from one end to the other
            continue
        if is_lost(lambda factor: problem(math.log2(factor)), 2.0**exponent):
            return 2.0**exponent, omega
    _, high = _halved(unstable, low, high, 1e-12 * max(1.0, abs(low)))
    return 2.0**high, abs(growing(high).imag)


def _halved(unstable: Callable[[float], bool], low: float, high: float, width: float) -> tuple[float, float]:
    """The bracket of a change to `unstable`, halved until it is no wider than `width`."""
    while high - low > width:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if unstable(middle) else (middle, high)
    return low, high
