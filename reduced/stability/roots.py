"""Zeros of an analytic function in a region, with a certified count: argument principle, then Newton from a cloud of starts."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from reduced.impedance import Complex, Jet
from scene.errors import NumericsError

Function = Callable[[Complex], Jet]

_STEP = 0.5
"""Largest |D'/D| ds along the contour: the argument cannot turn unseen between two samples."""
_MOST_POINTS = 400_000
_NEWTON_ROUNDS = 60


def half_disc(radius: float, inset: float) -> Complex:
    """Corners of a polyline round {Re s > inset, |s| < radius}, counter-clockwise, closed; the arc is cut into 64 chords."""
    angle = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 65)
    arc = inset + radius / np.cos(np.pi / 128.0) * np.exp(1j * angle)
    return np.append(arc, arc[0])


def rectangle(left: float, right: float, top: float) -> Complex:
    """Corners of {left < Re s < right, |Im s| < top}, counter-clockwise, closed."""
    return np.array([left - 1j * top, right - 1j * top, right + 1j * top, left + 1j * top, left - 1j * top])


def count_zeros(function: Function, corners: Complex) -> int:
    """Zeros of an analytic function inside a closed polyline: its winding number.

    Sides are halved until |D'/D| times the step is below 1/2 at both ends of every piece and D turns by less than 60 degrees over
    it.
    Raises NumericsError if a zero lies on the contour.
    """
    points = np.concatenate([np.linspace(a, b, 9)[:-1] for a, b in pairwise(corners)] + [corners[-1:]])
    while True:
        jet = function(points)
        with np.errstate(divide="ignore", invalid="ignore"):
            turn = np.angle(jet.value[1:] / jet.value[:-1])
            rate = np.abs(jet.slope / jet.value)
        if not np.all(np.isfinite(rate)):
            raise NumericsError(
                f"stability: the characteristic function is 0 or not finite on the contour at s = {_first_bad(points, rate)}"
            )
        long = (np.maximum(rate[1:], rate[:-1]) * np.abs(np.diff(points)) > _STEP) | (np.abs(turn) > np.pi / 3.0)
        if not long.any():
            return round(float(turn.sum()) / (2.0 * np.pi))
        if len(points) > _MOST_POINTS:
            raise NumericsError(f"stability: a root lies on the contour near s = {points[int(np.argmax(rate))]:.6g}")
        middles = 0.5 * (points[:-1] + points[1:])[long]
        points = np.insert(points, np.flatnonzero(long) + 1, middles)


def _first_bad(points: Complex, rate: NDArray[np.float64]) -> complex:
    return complex(points[int(np.argmin(np.isfinite(rate)))])


def polish(function: Function, starts: Complex, rounds: int = _NEWTON_ROUNDS) -> Complex:
    """Newton's method from every start at once; nan where it does not converge to rounding."""
    s = np.array(starts, dtype=np.complex128)
    step = np.full(s.shape, np.inf, dtype=np.complex128)
    with np.errstate(all="ignore"):
        for _ in range(rounds):
            jet = function(s)
            step = jet.value / jet.slope
            s = s - step
    converged = np.abs(step) <= 1e-11 * np.abs(s) + 1e-300
    return np.where(converged & np.isfinite(s), s, np.nan)


def zeros_in(function: Function, left: float, right: float, top: float) -> Complex:
    """All zeros in the rectangle {left < Re s < right, |Im s| < top}, sorted by falling real part.

    As many as the argument principle counts there, or NumericsError. D must be real for real s (zeros come in pairs).
    """
    expected = count_zeros(function, rectangle(left, right, top))
    for density in (1, 2, 4, 8):
        re, im = np.linspace(left, right, 8 * density), np.linspace(0.0, top, 16 * density)
        found = _distinct(polish(function, (re[:, None] + 1j * im[None, :]).ravel()))
        inside = found[(left < found.real) & (found.real < right) & (np.abs(found.imag) < top)]
        if inside.size == expected:
            return inside[np.lexsort((-inside.imag, -inside.real))]
    raise NumericsError(f"stability: {expected} roots counted, {inside.size} found in Re s > {left:.6g}, |Im s| < {top:.6g}")


def _distinct(found: Complex) -> Complex:
    """Zeros with their conjugates, each once."""
    found = found[np.isfinite(found)]
    found = np.where(np.abs(found.imag) < 1e-10 * np.abs(found), found.real + 0j, found.real + 1j * np.abs(found.imag))
    kept: list[complex] = []
    for zero in found:
        if all(abs(zero - other) > 1e-8 * abs(zero) for other in kept):
            kept.append(complex(zero))
    return np.array(kept + [zero.conjugate() for zero in kept if zero.imag != 0.0], dtype=np.complex128)
