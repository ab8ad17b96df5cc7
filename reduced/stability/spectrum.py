"""The spectrum of steady sliding: the certified number of unstable roots, and the leading roots."""

import numpy as np

from reduced.impedance import Complex
from reduced.stability.characteristic import Characteristic
from reduced.stability.roots import count_zeros, half_disc, polish, rectangle, zeros_in
from slipwave.errors import NumericsError

_INSETS = (1e-9, 1e-11, 1e-7)
"""Distances of the contour from the imaginary axis, to the right, relative to its radius; the first that meets no root is used. A
neutral root does not count as unstable."""

_RIPPLES = 4.6
"""Leading roots are searched up to this many times pi per longer round trip: two pairs of reverberations."""

_CROWD = 60
_THINNEST_STRIP = 1e-9
_DEEPEST_STRIP = 6.0
_TRIES = 5


def unstable_count(problem: Characteristic, active: bool = False) -> int:
    """Roots with Re s > 0, by the argument principle.

    For passive slabs all of them lie within `FrictionSlopes.reach` of -G_phi, so the count is complete. For an `active` slab
    (with unstable poles of its own) it counts up to 20 per transit. Raises NumericsError if a root lies on the contour.
    """
    radius = problem.slopes.reach
    if active:
        radius = max(radius, 20.0 / problem.transit)
    elif not problem.slopes.weakening:
        return 0
    for inset in _INSETS:
        try:
            return count_zeros(problem.jet, half_disc(1.001 * radius, inset * radius), problem.anchors)
        except NumericsError as error:  # a neutral root lies on the contour: move the contour to its other side
            failure = error
    raise failure


def leading_roots(problem: Characteristic, most: int = 8) -> Complex:
    """The `most` roots with the largest real parts among those with |Im s| below two ripple frequencies, including conjugates.

    The searched rectangle grows to the left until it holds enough roots, or shrinks until it does not hold too many; their number
    is certified. Sorted by falling real part; 1/(L/V*). Raises NumericsError if roots lie too close to be distinguished.
    """
    low, count = _rectangle(problem, most)
    roots = zeros_in(problem.jet, low, _mirrored(problem, low), count, problem.anchors)
    roots = roots[~problem.idle(roots)]
    real = np.abs(roots.imag) < 1e-10 * np.abs(roots)
    upper = np.concatenate([roots[real].real + 0j, roots[~real & (roots.imag > 0.0)]])
    upper = upper[np.argsort(-upper.real)]
    pairs = np.column_stack([upper, upper.conj()]).ravel()
    kept = np.column_stack([np.full(upper.shape, True), upper.imag > 0.0]).ravel()
    return np.asarray(pairs[kept][:most], dtype=np.complex128)


def _mirrored(problem: Characteristic, low: complex) -> complex:
    """Upper right corner of the search rectangle with lower left corner `low`."""
    return complex(max(problem.slopes.reach, 1.0 / problem.longest), -low.imag)


def _counted(problem: Characteristic, left: float, top: float) -> tuple[complex, int]:
    """(lower left corner, number of roots inside) of the search rectangle, moved slightly if a root lies on its boundary."""
    for _ in range(_TRIES):
        corner = complex(-left, -top)
        try:
            return corner, count_zeros(problem.jet, rectangle(corner, _mirrored(problem, corner)), problem.anchors)
        except NumericsError:
            left, top = 0.983 * left, 0.983 * top
    raise NumericsError(f"stability: too many roots near Re s = {-left:.6g}")


def _rectangle(problem: Characteristic, most: int) -> tuple[complex, int]:
    """A search rectangle that holds enough roots but not too many: (lower left corner, number of roots)."""
    unit, wall = 1.0 / problem.longest, -0.9 * problem.leftmost
    left, top = min(0.3 * unit, wall), max(1.05 * problem.slopes.reach, _RIPPLES * np.pi * unit)
    found = _counted(problem, left, top)
    if found[1] > _CROWD and (growing := _counted(problem, _THINNEST_STRIP * unit, top))[1] > _CROWD:
        left, found = _THINNEST_STRIP * unit, growing
    while found[1] > _CROWD and left > _THINNEST_STRIP * unit:
        fewer = _counted(problem, left / 3.0, top)
        if fewer[1] < most:
            break
        left, found = left / 3.0, fewer
    while found[1] > _CROWD:  # fast roots grow, or lie in one thin strip: search only the slow ones
        top /= 3.0
        found = _counted(problem, left, top)
    while found[1] < most and left < min(_DEEPEST_STRIP * unit, wall):
        left = min(3.0 * left, wall)
        found = _counted(problem, left, top)
    return found


def follow_root(problem: Characteristic, start: complex) -> complex:
    """The root to which Newton's method converges from `start`; nan if it does not converge."""
    return complex(polish(problem.jet, np.array([start]))[0])
