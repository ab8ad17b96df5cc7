"""Stick-slip records: the period and the shape of the mean cycle by its phase, measured and of a model.

Late waveforms are not compared: cycles drift apart, and waves ring differently in each. An event is dated where friction falls
through the middle between its maximum and its minimum. Phases close to events are left out: a sample there says more of the
recording than of friction.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np

from reduced.impedance.reduce import reduction_of
from reduced.ode.march import STAGES
from reduced.ode.slabs import ReducedSlabs
from slipwave.errors import NumericsError, SceneError
from slipwave.observe.pieces import Array, Basis, Pieces, interpolation_matrix, lagrange_basis
from slipwave.scene import Scene
from slipwave.scene.drive import Start, StartKind
from slipwave.step.collocation import radau
from slipwave.step.sensitivity import port_sensitivity
from validation.data.events import noise_of
from validation.fit.forward import marched, sampled
from validation.fit.parameters import Variants, sizes

BINS = 48
MARGIN = 0.02
"""Share of a cycle on either side of an event that is left out."""

_POINTS = 3  # of a bin at which a model is asked
_FALL = 0.4  # of the range of friction: a smaller fall is no event
_ABOVE = 8.0  # times the noise: the smallest fall that can be told from it
_BLOCKS = (4000, 1000, 250)  # means, among which falls are sought if noise, or waves, hide them in the samples
_SETTLED = 7  # events; the last cycle of so many is taken
_LONGER = (1.0, 2.5, 6.0, 15.0)  # times the expected length of a march
_BISECTIONS = 60
_SAME_PERIOD = 1e-5  # relative difference of two in a row with which the motion has settled
DISTURBED = 1.0
"""Of psi, at the start of a march that is to stick and slip."""


class MeanCycle(NamedTuple):
    """The `period` (s or transits) and mean friction in `BINS` (phases), with their standard errors; `events` and `drop`."""

    period: float
    period_error: float
    friction: Array
    friction_error: Array
    events: int
    drop: float


def phases() -> Array:
    """Middle of the bins."""
    edges = np.linspace(MARGIN, 1.0 - MARGIN, BINS + 1)
    return np.asarray(0.5 * (edges[1:] + edges[:-1]))


def falls(values: Array, least: float) -> list[tuple[int, int]]:
    """(maximum, minimum) of every fall by at least `least` that a rise by as much follows; the last one may lack it."""
    found, top, bottom, is_falling = [], 0, 0, False
    for k, value in enumerate(values.tolist()):
        if not is_falling:
            top = k if value > values[top] else top
            if values[top] - value > least:
                is_falling, bottom = True, k
        else:
            bottom = k if value < values[bottom] else bottom
            if value - values[bottom] > least:
                found.append((top, bottom))
                is_falling, top = False, k
    return [*found, (top, bottom)] if is_falling else found


def dated_events(name: str, times: Array, friction: Array) -> tuple[list[tuple[int, int]], Array]:
    """(maximum, minimum) of every slip event of a record, and their dates. Raises SceneError for fewer than three."""
    noise, size, events = noise_of(times, friction), float(np.ptp(friction)), []
    for together in sorted({max(1, times.size // blocks) for blocks in (times.size, *_BLOCKS)}):
        means = friction[: times.size // together * together].reshape(-1, together).mean(axis=1)
        least = _FALL * float(np.ptp(means))
        if least > _ABOVE * noise_of(np.arange(means.size), means):
            events = [(together * a, min(together * b + together - 1, times.size - 1)) for a, b in falls(means, least)]
            break
    dates = np.array([_date(times, friction, *one) for one in events])
    if dates.size < 3:
        found = f"{dates.size} slip events" if dates.size else "no slip event"
        raise SceneError(
            f"{name!r}: {found} (friction changes by {size:.3g}, noise {noise:.2g}); a fit of stick-slip needs 3; for "
            "steps and holds give drive.velocity, or a column of the load point's displacement"
        )
    return events, dates


def mean_cycle(name: str, times: Array, friction: Array) -> MeanCycle:
    """Of a record. Raises SceneError if there are no three slip events in it."""
    noise, (events, dates) = noise_of(times, friction), dated_events(name, times, friction)
    periods = np.diff(dates)
    which = np.searchsorted(dates, times, side="right") - 1
    inside = (which >= 0) & (which < periods.size)
    where = (times[inside] - dates[which[inside]]) / periods[which[inside]]
    bins = np.floor((where - MARGIN) / (1.0 - 2.0 * MARGIN) * BINS).astype(int)
    rows = np.full((periods.size, BINS), np.nan)
    counts = np.zeros(BINS)
    for b in range(BINS):
        for k in range(periods.size):
            mine = friction[inside][(bins == b) & (which[inside] == k)]
            counts[b] += mine.size
            rows[k, b] = mine.mean() if mine.size else np.nan
    if not counts.all():
        raise SceneError(f"{name!r}: too few samples: a fit of stick-slip needs one in each {BINS}th of the mean cycle")
    return _mean(periods, rows, counts, noise, np.median(np.diff(times)), [friction[a] - friction[b] for a, b in events])


def _mean(periods: Array, rows: Array, counts: Array, noise: float, step: float, drops: list[float]) -> MeanCycle:
    """Standard errors are of the scatter of cycles, but not below those of noise and sampling."""
    cycles = np.maximum(np.isfinite(rows).sum(axis=0), 1)
    scatter = np.nanstd(rows, axis=0) / np.sqrt(np.maximum(cycles - 1, 1))
    timing = step / (6.0 * periods.size) ** 0.5  # two dates, each within a sample
    spread = float(np.std(periods, ddof=1)) / periods.size**0.5 if periods.size > 2 else 0.0
    least = max(noise, 1e-9) / np.sqrt(counts)
    return MeanCycle(
        float(periods.mean()),
        max(spread, timing, 1e-9 * float(periods.mean())),
        np.nanmean(rows, axis=0),
        np.maximum(scatter, least),
        periods.size + 1,
        float(np.median(drops)),
    )


def _date(times: Array, friction: Array, top: int, bottom: int) -> float:
    """Where friction falls last through the middle between its maximum and its minimum."""
    middle = 0.5 * (friction[top] + friction[bottom])
    above = top + int(np.flatnonzero(friction[top:bottom] > middle)[-1])
    share = (friction[above] - middle) / (friction[above] - friction[above + 1])
    return float(times[above] + share * (times[above + 1] - times[above]))


class CycleOfReduction:
    """The last of some cycles of an ODE reduction that a disturbance has set going: period, then friction in the bins. The
    derivative is exact for the steps that the march took."""

    is_cheap: bool = True

    def __init__(self, variants: Variants, period: float, model: str, tolerance: float) -> None:
        self._variants, self._period, self._model, self._tolerance = variants, period, model, tolerance
        self._last: tuple[Array, Scene, Pieces] | None = None
        edges = np.linspace(MARGIN, 1.0 - MARGIN, BINS + 1)
        share = (np.arange(_POINTS) + 0.5) / _POINTS
        self._phases = (edges[:-1, None] + share * np.diff(edges)[:, None]).ravel()

    def scene(self, inner: Array) -> Scene:
        """As `Forward`."""
        return self._variants.scene(inner)

    def friction(self, inner: Array) -> Array:
        """As `Forward`, after the period. Raises NumericsError where the model does not stick and slip."""
        _, scene, pieces = self._marched(inner)
        return self._cycle(scene, pieces, [])[0]

    def slopes(self, inner: Array) -> Array:
        """As `Forward`."""
        _, scene, pieces = self._marched(inner)
        found = port_sensitivity(self._slabs(scene), self._variants.beside(inner), pieces)
        return np.column_stack(self._cycle(scene, pieces, [*np.moveaxis(found, 1, 0)])[1:])

    def motion(self, inner: Array, every: float) -> tuple[Array, Array]:
        """Times (s, or transits in a scene without units), `every` so long, and friction of the later half of the march."""
        _, scene, pieces = self._marched(inner)
        clock = sizes(scene)[0]
        times = np.arange(0.4 * pieces.time[-1] * clock, pieces.time[-1] * clock, every)
        return times, sampled(pieces, times / clock, [pieces.mu])[0]

    def _marched(self, inner: Array) -> tuple[Array, Scene, Pieces]:
        if self._last is None or not np.array_equal(self._last[0], inner):
            scene = self.scene(inner)
            for longer in _LONGER:
                until = float(np.ceil(longer * (_SETTLED + 1.5) * self._period / sizes(scene)[0]))
                pieces = marched(self._slabs(scene), until, self._tolerance)
                events = self._falls(pieces)
                if len(events) >= _SETTLED and self._is_settled(pieces, events[-3:]):
                    break
            if len(events) < _SETTLED:
                raise NumericsError(f"{self._model}: no {_SETTLED} slip events in {pieces.time[-1]:.4g} transits")
            self._last = inner.copy(), scene, pieces
        return self._last

    def _is_settled(self, pieces: Pieces, three: Sequence[tuple[int, int]]) -> bool:
        """Whether the last two periods are the same."""
        slope = slope_of(pieces)
        dates = [model_date(pieces, one, [slope])[0] for one in three]
        return abs(dates[2] - 2.0 * dates[1] + dates[0]) < _SAME_PERIOD * (dates[2] - dates[1])

    def _slabs(self, scene: Scene) -> ReducedSlabs:
        return ReducedSlabs(scene, lambda one: reduction_of(one, self._model), STAGES)

    def _falls(self, pieces: Pieces) -> list[tuple[int, int]]:
        """Events of the later half of a march, and those before that are as large."""
        late = pieces.mu[pieces.mu.shape[0] // 2 :]
        return falls(pieces.mu.ravel(), max(_FALL * float(np.ptp(late)), 1e-6))[:-1]

    def _cycle(self, scene: Scene, pieces: Pieces, by: list[Array]) -> list[Array]:
        """Period and friction of the last whole cycle, and their derivatives, where `by` (k, s) are those of mu."""
        slope = slope_of(pieces)
        events = self._falls(pieces)[-2:]
        (begin, at_begin), (end, at_end) = (model_date(pieces, one, [slope, *by]) for one in events)
        period = end - begin
        rows = sampled(pieces, begin + self._phases * period, [pieces.mu, slope, *by])
        clock = sizes(scene)[0]
        found = [np.append(period * clock, _binned(rows[0]))]
        for one, first, last in zip(rows[2:], at_begin, at_end, strict=True):
            found.append(np.append((last - first) * clock, _binned(one + rows[1] * (first + self._phases * (last - first)))))
        return found


def slope_of(pieces: Pieces) -> Array:
    """d mu/dt at the nodes (k, s)."""
    return np.asarray(pieces.mu @ _basis(pieces.z.shape[1]).derivative.T / pieces.length[:, None])


def _binned(values: Array) -> Array:
    return np.asarray(values.reshape(BINS, _POINTS).mean(axis=1))


def model_date(pieces: Pieces, event: tuple[int, int], rows: list[Array]) -> tuple[float, list[float]]:
    """Date (transits) of an event between two nodes, and its derivatives by what `rows` after the slope are derivatives by."""
    stages, mu, slope = pieces.z.shape[1], pieces.mu.ravel(), rows[0]
    ends = [_extreme(slope, node // stages) for node in event]
    levels = [0.5 * sum(_value(one[piece], share) for piece, share in ends) for one in (pieces.mu, *rows[1:])]
    above = event[0] + int(np.flatnonzero(mu[event[0] : event[1]] > levels[0])[-1])
    piece, share = _root(pieces.mu - levels[0], (above + 1) // stages)
    date = float(pieces.time[piece] + share * pieces.length[piece])
    steep = _value(slope[piece], share)
    return date, [(level - _value(one[piece], share)) / steep for level, one in zip(levels[1:], rows[1:], strict=True)]


def _extreme(slope: Array, piece: int) -> tuple[int, float]:
    """The piece, `piece` or one beside it, and the place in it where the slope passes zero."""
    beside = [k for k in (piece, piece + 1, piece - 1) if 0 <= k < len(slope)]
    there = next((k for k in beside if _value(slope[k], 0.0) * slope[k, -1] <= 0.0), None)
    return (piece, 1.0) if there is None else _root(slope, there)  # a wave's front makes a corner between two pieces


def _root(rows: Array, piece: int) -> tuple[int, float]:
    """The piece and the place in it where its polynomial, of values `rows` at its nodes, passes zero."""
    low, high, sign = 0.0, 1.0, np.sign(_value(rows[piece], 0.0))
    for _ in range(_BISECTIONS):
        half = 0.5 * (low + high)
        low, high = (half, high) if _value(rows[piece], half) * sign > 0.0 else (low, half)
    return piece, 0.5 * (low + high)


@cache
def _basis(stages: int) -> Basis:
    return lagrange_basis(radau(stages).nodes)


def _value(row: Array, share: float) -> float:
    """Of the polynomial of a piece."""
    return float((interpolation_matrix(_basis(row.size), np.array([share])) @ row)[0])


def disturbed(variants: Variants) -> Variants:
    """The same scenes with a jump of psi at the start, which sets them going."""
    return replace(variants, start=Start(StartKind.JUMP, DISTURBED))
