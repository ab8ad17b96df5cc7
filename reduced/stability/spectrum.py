"""The spectrum of steady sliding: the certified number of unstable roots, and the leading roots. They are zeros of an analytic
function in a region, counted by the argument principle and found by Newton's method from many starts."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from reduced.impedance import Complex, Jet
from reduced.stability.characteristic import Characteristic, characteristic
from reduced.stability.essential import fast_pattern
from slipwave.errors import NumericsError
from slipwave.scene import Scene

Function = Callable[[Complex], Jet]

_STEP = 0.5
"""Largest |D'/D| ds along the contour, so that no turn of the argument is missed between two samples."""
_MOST_POINTS = 1_000_000
_SHORTEST, _FINEST = 1e-12, 1e-15
_NEWTON_ROUNDS = 40
_FEW = 6
_DEEPEST = 40
_CUTS = (0.5123, 0.4711, 0.5371, 0.4313, 0.5779)

NEUTRAL = 1e-9
"""A root with |Re s| below this share of the slower rate, of friction or waves, is neutral: its sign is not decided."""

_MARGINS = (1.001, 1.0037, 1.00011)
"""Factors that enlarge the disc of all growing roots; the first whose edge meets no root is used."""

_RIPPLES, _PATTERNS = 4.6, 2.0
"""Leading roots are searched up to the first many times pi per longer round trip, two pairs of reverberations, and up to the
second many of the patterns in which fast roots repeat: beyond, they differ from these less and less."""

_DEEPEST_STRIP, _FASTEST = 6.0, 20.0
"""Per transit: fastest decay of the roots searched, and fastest growth of those of active slabs."""

_OFF_AXIS, _SMALL = 1e3, 1e-6
_LEADING = 8


def _rectangle(low: complex, high: complex) -> Complex:
    """Corners of the rectangle between `low` (left, below) and `high` (right, above), counter-clockwise, closed."""
    return np.array([low, complex(high.real, low.imag), high, complex(low.real, high.imag), low])


class _OnContour(NumericsError):
    """A zero lies on the contour, or too near to decide its side."""


def _resolved(function: Function, corners: Complex, anchors: tuple[complex, ...] = ()) -> tuple[Complex, Jet]:
    """Points along a polyline, dense enough that no turn of the function's argument is missed, and the function there.

    Sides are halved until every piece meets three conditions: |D'/D| times its length is below 1/2 at both ends, D turns by less
    than 60 degrees over it, and it is shorter than its distance from each of the `anchors`, the points near which D varies on a
    short scale. Raises `_OnContour` if a zero lies on it, NumericsError if more than a million points are needed.
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
            raise _OnContour(f"stability: the characteristic function is 0 or not finite on the contour at s = {bad:.6g}")
        pieces = np.abs(np.diff(points))
        long = (np.maximum(rate[1:], rate[:-1]) * pieces > _STEP) | (np.abs(turn) > np.pi / 3.0)
        if np.any(long & (pieces < _FINEST * np.abs(points[1:]))):
            raise _OnContour(f"stability: a root lies on the contour near s = {points[int(np.argmax(rate))]:.6g}")
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


def _count_zeros(function: Function, corners: Complex, anchors: tuple[complex, ...] = ()) -> int:
    """Zeros of an analytic function inside a closed polyline: its winding number. A path from the real axis to the real axis is
    closed by its mirror image, for a function that is real there. Raises as `_resolved`."""
    _, jet = _resolved(function, corners, anchors)
    half = 1.0 if corners[0] == corners[-1] else 0.5
    return round(float(np.angle(jet.value[1:] / jet.value[:-1]).sum()) / (2.0 * np.pi * half))


def _polish(function: Function, starts: Complex, rounding: float = 0.0) -> Complex:
    """Newton's method from all starts; nan where it does not converge to `rounding`, or to that of s."""
    s = np.array(starts, dtype=np.complex128)
    step = np.full(s.shape, np.inf, dtype=np.complex128)
    with np.errstate(all="ignore"):
        for _ in range(_NEWTON_ROUNDS):
            jet = function(s)
            step = jet.value / jet.slope
            s = s - step
    converged = np.abs(step) <= 1e-10 * np.abs(s) + max(rounding, 1e-300)
    return np.where(converged & np.isfinite(s), s, np.nan)


def _zeros_in(
    function: Function,
    low: complex,
    high: complex,
    expected: int,
    anchors: tuple[complex, ...] = (),
    rounding: float = 0.0,
    depth: int = 0,
) -> Complex:
    """All `expected` zeros in the rectangle with corners `low` (left, below) and `high`, each once; for at most a few dozen
    zeros.

    `expected`: their number by `_count_zeros`; `anchors` as in `_resolved`, `rounding` as in `_polish`. The rectangle is
    halved until Newton's method finds them all. Raises NumericsError if zeros lie too close to be distinguished.
    """
    if expected == 0:
        return np.empty(0, dtype=np.complex128)
    if expected <= _FEW:
        re, im = np.linspace(low.real, high.real, 7), np.linspace(low.imag, high.imag, 9)
        zeros = _distinct(_polish(function, (re[:, None] + 1j * im[None, :]).ravel(), rounding), rounding)
        inside = zeros[(low.real < zeros.real) & (zeros.real < high.real) & (low.imag < zeros.imag) & (zeros.imag < high.imag)]
        if inside.size == expected:
            return inside
    if depth > _DEEPEST:
        raise NumericsError(f"stability: {expected} roots near s = {0.5 * (low + high):.6g} are too close to be distinguished")
    halves = _halves(function, low, high, expected, anchors)
    return np.concatenate([_zeros_in(function, *half, count, anchors, rounding, depth + 1) for half, count in halves])


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
            count = _count_zeros(function, _rectangle(*first), anchors)
        except NumericsError:
            continue
        return [(first, count), (second, expected - count)]
    raise NumericsError(f"stability: too many roots near s = {0.5 * (low + high):.6g}")


def _distinct(zeros: Complex, rounding: float = 0.0) -> Complex:
    """The finite ones of `zeros`, each once; those no further apart than `rounding` are the same."""
    finite = zeros[np.isfinite(zeros)]
    unit = 1e-9 * 10.0 ** np.floor(np.log10(np.maximum(np.abs(finite), 1e-290)))
    _, first = np.unique(np.round(finite / unit) * unit, return_index=True)
    kept = np.empty(0, dtype=np.complex128)
    for zero in finite[first]:
        if not np.any(np.abs(zero - kept) <= 1e-8 * abs(zero) + rounding):
            kept = np.append(kept, zero)
    return kept


_ANGLES = np.radians([0.0, 15.0, 35.0, 60.0, 80.0, 90.0, 100.0, 120.0, 145.0, 165.0, 180.0])


@dataclass(frozen=True)
class Spectrum:
    """`growing` is certified. `stable` is None if no root grows and one that friction affects is neutral. `leading`, 1/(L/V*):
    those of `leading_roots`; empty if all roots decay faster than waves pass."""

    stable: bool | None
    growing: int
    leading: tuple[complex, ...]

    @property
    def rate(self) -> float:
        """Re s of the leading root; -inf without one."""
        return self.leading[0].real if self.leading else -np.inf


@lru_cache(maxsize=64)
def spectrum(scene: Scene, model: str = "delay") -> Spectrum:
    """Spectrum of steady sliding at the initial velocity of the drive. The certified count decides the stability, never the
    roots.

    Raises SceneError if the model cannot compute the scene, NumericsError if a root cannot be located.
    """
    problem = characteristic(scene, model)
    stable, growing = certified(scene, model)
    leading = leading_roots(problem)
    if (leading.real > _neutral_rate(problem)).sum() < min(growing, leading.size - 1):
        raise NumericsError(f"stability: {growing} roots grow, by a certified count, but not all of the leading ones were found")
    return Spectrum(stable, growing, tuple(complex(root) for root in leading))


@lru_cache(maxsize=64)
def certified(scene: Scene, model: str = "delay") -> tuple[bool | None, int]:
    """`stable` and `growing` of the `spectrum`, without its roots: a third of the time."""
    problem = characteristic(scene, model)
    growing = unstable_count(problem)
    if growing:
        return False, growing
    near = unstable_count(problem, -_neutral_rate(problem))
    if not near:
        return True, 0
    zeros = _all_leading(problem, most=max(near, _LEADING))
    idle = zeros[problem.idle(zeros)]
    return (True if _number(idle[np.abs(idle.real) <= _neutral_rate(problem)]) >= near else None), 0


def _neutral_rate(problem: Characteristic) -> float:
    """|Re s| below which a root is neutral."""
    return NEUTRAL * min(problem.slopes.reach, 1.0 / problem.longest)


def _rounding(problem: Characteristic) -> float:
    """|ds| by which rounding moves a root, however small: near s = 0 it exceeds any share of |s|."""
    return _FINEST * problem.slopes.reach


def unstable_count(problem: Characteristic, beyond: float | None = None) -> int:
    """Number of roots with Re s > `beyond`, by the argument principle; the default, just right of the imaginary axis, excludes
    neutral roots.

    For passive slabs all of them lie in the disc `FrictionSlopes.growing`, so the count is complete. For active slabs (with
    unstable poles) growth rates up to 20 per transit are counted. Raises NumericsError if a root lies on the contour.
    """
    centre, radius = problem.slopes.growing
    if problem.is_active:
        centre, radius = 0.0, max(problem.slopes.reach, _FASTEST / problem.transit)
    elif not problem.slopes.weakening:
        return 0
    least = _neutral_rate(problem) if beyond is None else beyond
    for margin in _MARGINS:
        # around {Re s > left, |s - centre| < radius} in the upper half plane, counter-clockwise; 32 chords lie outside the arc
        left, outer = least * margin, margin * radius / np.cos(np.pi / 64.0)
        arc = centre + outer * np.exp(1j * np.linspace(0.0, np.arccos((left - centre) / outer), 33))
        path = np.append(arc[:-1], [complex(left, arc[-1].imag), complex(left)])
        try:
            return _count_zeros(problem.jet, path, problem.anchors)
        except _OnContour as error:
            failure = error
    raise failure


def leading_roots(problem: Characteristic, most: int = _LEADING) -> Complex:
    """The `most` roots with the largest real parts, including conjugates, among those with |Im s| below that of any root that can
    grow, below two ripple frequencies and below two patterns of the fast roots: beyond, these accumulate at the essential
    abscissa. The number of roots right of the last one is certified. For a reduction all roots are considered.

    Sorted by falling real part; 1/(L/V*). Raises NumericsError if roots lie too close to be distinguished.
    """
    roots = _all_leading(problem, most)
    roots = roots[~problem.idle(roots)]
    pairs = np.column_stack([roots, roots.conj()]).ravel()
    kept = np.column_stack([np.full(roots.shape, True), roots.imag > 0.0]).ravel()
    return np.asarray(pairs[kept][:most], dtype=np.complex128)


def _all_leading(problem: Characteristic, most: int) -> Complex:
    """At least `most` roots if there are so many (counting conjugates, not idle ones), by falling real part; only those with Im s
    >= 0 are returned. Their number is certified."""
    if problem.reduction is not None:
        starts = np.concatenate([problem.eigenvalues(), _fan(problem)])  # rounding of fast ones swamps slow ones
        roots, exact = _polish(problem.jet, starts, _rounding(problem)), np.abs(problem.imbalance(starts)) < _SMALL
        return _upper(np.where(np.isfinite(roots), roots, np.where(exact, starts, np.nan)), _rounding(problem))
    unit, wall = 1.0 / problem.longest, 0.9 * problem.leftmost
    centre, radius = problem.slopes.growing
    bound = np.sqrt(max(radius**2 - centre**2, 0.0)) if problem.slopes.weakening else problem.slopes.reach
    top = max(1.05 * bound, _RIPPLES * np.pi * unit, _PATTERNS * fast_pattern(problem.scene))
    right = max(problem.slopes.reach, _FASTEST * unit)
    deepest = max(-_DEEPEST_STRIP * unit, wall)
    for share in (1.0, 0.983, 0.966, 0.943):
        try:
            return _certified(problem, complex(deepest, share * top), right, most)
        except _OnContour as error:
            failure = error
    raise failure


def _certified(problem: Characteristic, corner: complex, right: float, most: int) -> Complex:
    """The leading roots with Re s between Re `corner` and `right` and |Im s| < Im `corner`: by Newton's method from a few starts,
    confirmed by a count, else by halving the counted rectangle."""
    top = corner.imag
    offset = _OFF_AXIS * _neutral_rate(problem)
    rounding = _rounding(problem)
    edge, jet = _resolved(problem.jet, np.array([complex(offset), complex(offset, top)]), problem.anchors)
    for starts in (_few_starts, _many_starts):
        roots = _upper(_polish(problem.jet, starts(problem, edge, np.abs(jet.slope / jet.value)), rounding), rounding)
        roots = roots[(roots.imag < top) & (roots.real > corner.real) & (roots.real < right)]
        cut = _cut(problem, roots, corner.real, most)
        roots = roots[roots.real > cut]
        upper = np.array([right, complex(right, top), complex(cut, top), cut])  # half of a rectangle, mirrored at the real axis
        count = _count_zeros(problem.jet, upper, problem.anchors)
        if count == _number(roots):
            return roots
    zeros = _zeros_in(problem.jet, complex(cut, -top), complex(right, top), count, problem.anchors, rounding)
    return _upper(zeros, rounding)


def _few_starts(problem: Characteristic, edge: Complex, rate: Complex) -> Complex:
    """Starts where |D'/D| is largest along the imaginary `edge`, and around 0."""
    peaks = edge[1:-1][(rate[1:-1] >= rate[:-2]) & (rate[1:-1] > rate[2:])]
    return np.concatenate([peaks, _fan(problem), np.asarray(problem.anchors) * 1.0001])


def _fan(problem: Characteristic) -> Complex:
    """Starts for slow roots: in many directions from 0, from much slower than friction and waves to as fast as the faster."""
    slow, fast = sorted([1.05 * problem.slopes.reach, _RIPPLES * np.pi / problem.longest])
    return np.asarray((np.geomspace(1e-6 * slow, fast, 40)[:, None] * np.exp(1j * _ANGLES)).ravel())


def _many_starts(problem: Characteristic, edge: Complex, rate: Complex) -> Complex:
    """Starts of `_few_starts`, and points all along the `edge` and left of it."""
    some = edge[:: max(1, edge.size // 2000)]
    depths = np.array([0.0, -0.1, -0.5, -2.0, -4.0]) / problem.longest
    return np.concatenate([_few_starts(problem, edge, rate), (some + depths[:, None]).ravel()])


def _upper(zeros: Complex, rounding: float) -> Complex:
    """Each of `zeros` once, mirrored into the upper half plane, by falling real part; real ones exactly real."""
    finite = zeros[np.isfinite(zeros)]
    real = np.abs(finite.imag) <= 1e-10 * np.abs(finite) + rounding
    folded = _distinct(np.where(real, finite.real + 0j, finite.real + 1j * np.abs(finite.imag)), rounding)
    return folded[np.lexsort((folded.imag, -folded.real))]


def _number(upper: Complex) -> int:
    """Number of roots in `upper`, with the conjugates of those that are not real."""
    return int(upper.size + (upper.imag > 0.0).sum())


def _cut(problem: Characteristic, roots: Complex, deepest: float, most: int) -> float:
    """Re s of a line left of at least `most` of the `roots`, which are sorted, in the widest gap between the next ones; `deepest`
    if no gap there exceeds rounding, as where roots accumulate."""
    counts = np.cumsum(np.where(problem.idle(roots), 0, 1 + (roots.imag > 0.0)))
    enough = int(np.searchsorted(counts, most))
    if enough + 1 >= roots.size:
        return deepest
    real = roots.real[enough : enough + 2 * most]
    widest = int(np.argmax(real[:-1] - real[1:]))
    if real[widest] - real[widest + 1] < 10.0 * _FINEST * abs(roots[enough + widest]):
        return deepest
    return float(0.5 * (real[widest] + real[widest + 1]))


def follow_root(problem: Characteristic, start: complex) -> complex:
    """The root to which Newton's method converges from `start`; nan if it does not converge."""
    return complex(_polish(problem.jet, np.array([start]))[0])
