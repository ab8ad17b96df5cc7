"""Zeros of an analytic function in a region, with a certified count: argument principle, then Newton from many starts."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from reduced.impedance import Complex, Jet
from slipwave.errors import NumericsError

Function = Callable[[Complex], Jet]

_STEP = 0.5
"""Largest |D'/D| ds along the contour, so that no turn of the argument is missed between two samples."""
_MOST_POINTS = 1_000_000
_SHORTEST, _FINEST = 1e-12, 1e-15
_NEWTON_ROUNDS = 40
_FEW = 6
_DEEPEST = 40
_CUTS = (0.5123, 0.4711, 0.5371, 0.4313, 0.5779)


def rectangle(low: complex, high: complex) -> Complex:
    """Corners of the rectangle between `low` (left, below) and `high` (right, above), counter-clockwise, closed."""
    return np.array([low, complex(high.real, low.imag), high, complex(low.real, high.imag), low])


class OnContour(NumericsError):
    """A zero lies on the contour, or too near to decide its side."""


def resolved(function: Function, corners: Complex, anchors: tuple[complex, ...] = ()) -> tuple[Complex, Jet]:
    """Points along a polyline, dense enough that no turn of the function's argument is missed, and the function there.

    Sides are halved until every piece meets three conditions: |D'/D| times its length is below 1/2 at both ends, D turns by less
    than 60 degrees over it, and it is shorter than its distance from each of the `anchors`, the points near which D varies on a
    short scale. Raises `OnContour` if a zero lies on it, NumericsError if more than a million points are needed.
    """
    floor = _SHORTEST * float(np.abs(corners).max())
    points = np.concatenate([np.linspace(a, b, 9)[:-1] for a, b in pairwise(corners)] + [corners[-1:]])
    while (long := _beside(points, anchors, floor)).any():  # halves of a piece that is short enough here are too
        points = np.insert(points, np.flatnonzero(long) + 1, 0.5 * (points[:-1] + points[1:])[long])
    jet = function(points)
    value, slope = jet.value, jet.slope
    while True:
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            turn = np.angle(value[1:] / value[:-1])
            rate = np.abs(slope / value)
        if not np.all(np.isfinite(rate)):
            bad = complex(points[int(np.argmin(np.isfinite(rate)))])
            raise OnContour(f"stability: the characteristic function is 0 or not finite on the contour at s = {bad:.6g}")
        pieces = np.abs(np.diff(points))
        long = (np.maximum(rate[1:], rate[:-1]) * pieces > _STEP) | (np.abs(turn) > np.pi / 3.0)
        if np.any(long & (pieces < _FINEST * np.abs(points[1:]))):
            raise OnContour(f"stability: a root lies on the contour near s = {points[int(np.argmax(rate))]:.6g}")
        if not long.any():
            return points, Jet(value, slope)
        if len(points) > _MOST_POINTS:
            raise NumericsError(
                f"stability: more than {_MOST_POINTS:,} points are needed to count the roots: too many waves fit into the slabs "
                "during one oscillation of friction"
            )
        at = np.flatnonzero(long) + 1
        middles = 0.5 * (points[:-1] + points[1:])[long]
        jet = function(middles)
        points, value, slope = (
            np.insert(old, at, new) for old, new in ((points, middles), (value, jet.value), (slope, jet.slope))
        )


def _beside(points: Complex, anchors: tuple[complex, ...], floor: float) -> NDArray[np.bool_]:
    """Which pieces between `points` are longer than `floor` and than their distance from one of the `anchors`."""
    pieces, middles = np.abs(np.diff(points)), 0.5 * (points[1:] + points[:-1])
    long = np.zeros(pieces.size, dtype=bool)
    for anchor in anchors:
        long |= pieces > np.maximum(np.abs(middles - anchor), floor)
    return long


def count_zeros(function: Function, corners: Complex, anchors: tuple[complex, ...] = ()) -> int:
    """Zeros of an analytic function inside a closed polyline: its winding number. A path from the real axis to the real axis is
    closed by its mirror image, for a function that is real there. Raises as `resolved`."""
    _, jet = resolved(function, corners, anchors)
    half = 1.0 if corners[0] == corners[-1] else 0.5
    return round(float(np.angle(jet.value[1:] / jet.value[:-1]).sum()) / (2.0 * np.pi * half))


def polish(function: Function, starts: Complex) -> Complex:
    """Newton's method from all starts; nan where it does not converge to rounding."""
    s = np.array(starts, dtype=np.complex128)
    step = np.full(s.shape, np.inf, dtype=np.complex128)
    with np.errstate(all="ignore"):
        for _ in range(_NEWTON_ROUNDS):
            jet = function(s)
            step = jet.value / jet.slope
            s = s - step
    converged = np.abs(step) <= 1e-10 * np.abs(s) + 1e-300
    return np.where(converged & np.isfinite(s), s, np.nan)


def zeros_in(
    function: Function, low: complex, high: complex, expected: int, anchors: tuple[complex, ...] = (), depth: int = 0
) -> Complex:
    """All `expected` zeros in the rectangle with corners `low` (left, below) and `high`, each once; for at most a few dozen
    zeros.

    `expected`: their number by `count_zeros`; `anchors` as in `resolved`. The rectangle is halved until Newton's method finds
    them all. Raises NumericsError if zeros lie too close to be distinguished.
    """
    if expected == 0:
        return np.empty(0, dtype=np.complex128)
    if expected <= _FEW:
        re, im = np.linspace(low.real, high.real, 7), np.linspace(low.imag, high.imag, 9)
        zeros = distinct(polish(function, (re[:, None] + 1j * im[None, :]).ravel()))
        inside = zeros[(low.real < zeros.real) & (zeros.real < high.real) & (low.imag < zeros.imag) & (zeros.imag < high.imag)]
        if inside.size == expected:
            return inside
    if depth > _DEEPEST:
        raise NumericsError(f"stability: {expected} roots near s = {0.5 * (low + high):.6g} are too close to be distinguished")
    halves = _halves(function, low, high, expected, anchors)
    return np.concatenate([zeros_in(function, *half, count, anchors, depth + 1) for half, count in halves])


def _halves(
    function: Function, low: complex, high: complex, expected: int, anchors: tuple[complex, ...]
) -> list[tuple[tuple[complex, complex], int]]:
    """Both halves of a rectangle, cut across its longer side, with their counts; the cut is shifted if it meets a zero."""
    size = high - low
    for share in _CUTS:
        if size.imag >= size.real:
            cut = low.imag + share * size.imag
            first, second = (low, complex(high.real, cut)), (complex(low.real, cut), high)
        else:
            cut = low.real + share * size.real
            first, second = (low, complex(cut, high.imag)), (complex(cut, low.imag), high)
        try:
            count = count_zeros(function, rectangle(*first), anchors)
        except NumericsError:
            continue
        return [(first, count), (second, expected - count)]
    raise NumericsError(f"stability: too many roots near s = {0.5 * (low + high):.6g}")


def distinct(zeros: Complex) -> Complex:
    """The finite ones of `zeros`, each once."""
    finite = zeros[np.isfinite(zeros)]
    unit = 1e-9 * 10.0 ** np.floor(np.log10(np.maximum(np.abs(finite), 1e-290)))
    _, first = np.unique(np.round(finite / unit) * unit, return_index=True)
    kept = np.empty(0, dtype=np.complex128)
    for zero in finite[first]:
        if not np.any(np.abs(zero - kept) <= 1e-8 * abs(zero)):
            kept = np.append(kept, zero)
    return kept
