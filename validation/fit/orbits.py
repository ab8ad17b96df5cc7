"""The periodic orbit of a model as a function of its period and of all parameters but one.

The period of a motion with waves locks to their round trips. As a function of a parameter it has steps, with folds at each, so
that several orbits coexist (`reduced.continuation`): a sum of squares over parameters has a minimum on every step. As functions
of the period the orbits have no folds. Therefore the period, which a record gives directly, is a coordinate here instead of one
parameter, the `leading` one, which follows from it. Friction is smooth in these coordinates.
"""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from reduced.orbit.approach import guesses
from reduced.orbit.closing import Closed, by_parameter, close, close_family
from slipwave.errors import NumericsError, SceneError
from slipwave.observe.pieces import SAME, Array, Pieces
from slipwave.step.flow import Flow
from validation.data.record_events import falls, without_waves
from validation.fit.cycles import FoldedRecord, model_date, slope_of
from validation.fit.forward import Forward, sampled
from validation.fit.parameters import Variants, sizes
from validation.models.orbits import moving
from validation.models.progress import News

SHIFT = np.array([2e-3, 2e-4])
"""Steps of differences of orbits: transits of period, logarithms of parameters."""

MOST_TRANSITS = 1e4
"""Longest period of an orbit that is fitted with every wave."""

_STRIDE = (0.5, 0.02, 0.1)  # the longest step from orbit to orbit: the same, and the leading parameter
_SHORTEST = 1e-3  # share of the way, a step
_ACCURACY = 1e-6  # relative, of the orbits' figures
_CLOSES_TO = 1e-9
_NEAR, _TRIALS = 0.05, 8  # of a period: as near as marches go, and how many there are
_PATIENCE = 60.0  # periods of a march that comes near no orbit
_WORK, _SMALL = 2e8, 1e5  # of a search: squares of the sizes of orbits, and what each costs besides
_FEWEST = 30  # orbits of a search
_LEAST_SLOPE = 1e-6  # d ln period/d ln parameter, below which it has no effect


class Anchor(NamedTuple):
    """A known orbit: its `coordinates` (its period minus the record's in transits, then the parameters except the leading one),
    and `closed`, with the leading parameter."""

    coordinates: Array
    closed: Closed


class CycleOfOrbit(Forward):
    """The periodic orbit of a model next to the last one: its period, then its friction at the samples of a folded record. As a
    `Forward` it is a function of the parameters; `walk` moves in the coordinates in which it is smooth."""

    is_cheap: bool = False

    def __init__(self, variants: Variants, record: FoldedRecord, model: str) -> None:
        super().__init__(variants, record.times, model, _CLOSES_TO)
        self.record = record
        self.transit = sizes(variants.scenes.base)[0]
        if record.period > MOST_TRANSITS * self.transit:
            raise SceneError(
                f"model = {model!r}: the measured period is {record.period / self.transit:.3g} transits: a fit with every wave "
                f"takes {MOST_TRANSITS:g} at most; quasidynamic fits such a record"
            )
        self.anchor: Anchor | None = None
        self.leading, self.late = 0, 0.0
        self.orbits, self.left, self._news = 0, _WORK, News()

    @property
    def known(self) -> Anchor:
        """The last orbit, once there is one."""
        assert self.anchor is not None
        return self.anchor

    def friction(self, inner: Array) -> Array:
        """As `Forward`. Raises NumericsError where no orbit is found."""
        if self.anchor is None:
            self.begin(inner)
        coordinates, known = np.delete(inner, self.leading), self.known
        if not np.array_equal(inner, self.inner(known)):
            flow = known.closed.flow.of(self.scene(inner))
            closed = close(flow, known.closed.cycle.start, known.closed.cycle.period, self._tolerance)
            known = Anchor(np.append(self._late_by(closed), coordinates), replace(closed, parameter=float(inner[self.leading])))
            self.anchor = known
        return np.append(self.period(known), self.seen(known, self.late))

    def slopes(self, inner: Array) -> Array:
        """As `Forward`, by the chain rule through the coordinates."""
        self.friction(inner)
        by, change = self.differences(self.known)
        first = np.insert(np.zeros(inner.size - 1), 0, self.transit)
        return np.asarray(np.vstack([first, by]) @ np.linalg.inv(change))

    def begin(self, inner: Array) -> Anchor:
        """The orbit that a march from steady sliding leads to, at these parameters or, if its period is then closer to the
        record's, at another leading one. Raises NumericsError if there is none."""
        closed = self._marched(inner)
        slopes = self._period_slopes(closed, inner)
        if self.anchor is None:
            self.leading = int(np.argmax(np.abs(slopes)))
            if abs(slopes[self.leading]) < _LEAST_SLOPE * closed.cycle.period:
                wanted = "needs a parameter that changes the period, as interface.a"
                raise SceneError(f"--free: a fit of stick-slip with every wave {wanted}")
        slope = float(slopes[self.leading]) or 1.0
        for _ in range(_TRIALS):
            late = self._late_by(closed)
            if abs(late) < _NEAR * closed.cycle.period:
                break
            other = inner.copy()
            other[self.leading] -= float(np.clip(late / slope, -_STRIDE[2], _STRIDE[2]))
            try:
                closed = self._marched(other)
            except NumericsError:
                slope *= 2.0
                continue
            change = (self._late_by(closed) - late) / (other - inner)[self.leading]
            slope, inner = change if change * slope > 0.0 else slope, other
        coordinates = np.append(self._late_by(closed), np.delete(inner, self.leading))
        self.anchor = Anchor(coordinates, replace(closed, parameter=float(inner[self.leading])))
        return self.anchor

    def _spend(self, size: int) -> None:
        """Count an orbit of `size` values. Raises NumericsError if the search has no work left for it, and from then on."""
        if self.left <= 0.0 or _FEWEST * size**2 > _WORK:
            self.left = 0.0
            better = "start nearer to the record, free fewer keys, or take a cheaper model, as modal:2 or quasidynamic"
            raise NumericsError(f"the search ends after {self.orbits} orbits of {size} values: {better}")
        self.orbits, self.left = self.orbits + 1, self.left - size**2 - _SMALL
        self._news("fit: %d orbits closed or tried, the last of %d values", self.orbits, size)

    def _marched(self, inner: Array) -> Closed:
        solver = moving(self._model, self.scene(inner))
        failed = NumericsError(f"{self._model}: the run comes near no orbit")
        for guess in guesses(solver, _ACCURACY, _PATIENCE * max(self.record.period / self.transit, 1.0)):
            self._spend(guess.flow.size)
            try:
                return close(guess.flow, guess.state, guess.period, self._tolerance)
            except NumericsError as reason:
                failed = reason
        raise failed

    def walk(self, coordinates: Array, late: float) -> Anchor:
        """The orbit at other coordinates, by continuation from the last one, with events that are `late` by this time (transits).
        Raises NumericsError where that ends."""
        self.late = late
        longest = np.append(_STRIDE[0], np.full(coordinates.size - 1, _STRIDE[1]))
        shorter = 1.0
        while not np.array_equal(self.known.coordinates, coordinates):
            way = coordinates - self.known.coordinates
            share = min(1.0, shorter / float(np.max(np.abs(way) / longest)))
            to = coordinates if share == 1.0 else self.known.coordinates + share * way
            try:
                self.anchor = self.near(self.known, to)
            except NumericsError:
                shorter *= 0.5
                if shorter < _SHORTEST:
                    raise
        return self.known

    def stay(self, known: Anchor, late: float) -> None:
        """End the search at this orbit, whose events are `late` by this time (transits)."""
        self.anchor, self.late, self.left = known, late, math.inf

    def near(self, known: Anchor, coordinates: Array) -> Anchor:
        """The orbit at `coordinates` near a known one. Raises NumericsError if there is none."""
        closed, flow = known.closed, known.closed.flow
        self._spend(flow.size)

        def flow_at(leading: float) -> Flow:
            if abs(leading - closed.parameter) > _STRIDE[2]:
                raise NumericsError(f"{self._model}: no orbit next to a period of {closed.cycle.period:.6g} transits")
            return flow.of(self.scene(np.insert(coordinates[1:], self.leading, leading)))

        weights = np.zeros(flow.size + 2)
        weights[-2] = 1.0
        clock = sizes(flow_at(closed.parameter).scene)[0]
        period = (self.record.period + coordinates[0] * self.transit) / clock
        neighbour = closed if closed.drift.size else None
        orbit = close_family(flow_at, closed.cycle.start, period, closed.parameter, weights, self._tolerance, neighbour)
        return Anchor(coordinates, orbit)

    def inner(self, known: Anchor) -> Array:
        """The parameters of a known orbit."""
        return np.insert(known.coordinates[1:], self.leading, known.closed.parameter)

    def period(self, known: Anchor) -> float:
        """The period of a known orbit, in the record's unit."""
        return self.record.period + float(known.coordinates[0]) * self.transit

    def seen(self, known: Anchor, late: float) -> Array:
        """Friction at the samples, if the model's event is `late` (transits) after the record's first."""
        cycle, (times, count, *_) = known.closed.cycle, self.record
        clock = sizes(known.closed.flow.scene)[0]
        twice = Pieces.joined([cycle.pieces, cycle.pieces._replace(time=cycle.pieces.time + cycle.period)])
        slope = slope_of(twice)
        top, bottom = without_waves(falls(twice.mu.ravel(), 0.5 * float(np.ptp(cycle.pieces.mu))), twice.y.ravel())[0]
        date = model_date(twice, (top, bottom), [slope])[0]
        since = (times - count * self.period(known) - late * self.transit) / clock
        return sampled(twice, (date + since) % cycle.period, [twice.mu])[0]

    def by_date(self) -> Array:
        """Derivative of friction at the samples by the date of the events (n,)."""
        later, sooner = (self.seen(self.known, self.late + sign * SHIFT[0]) for sign in (1.0, -1.0))
        return np.asarray((later - sooner) / (2.0 * SHIFT[0]))

    def differences(self, known: Anchor) -> tuple[Array, Array]:
        """Derivatives by the coordinates of friction at the samples (n, m), and of the parameters (m, m)."""
        shifts = np.diag(np.append(SHIFT[0], np.full(known.coordinates.size - 1, SHIFT[1])))
        pairs = [[self.near(known, known.coordinates + sign * shift) for sign in (1.0, -1.0)] for shift in shifts]
        widths = 2.0 * np.diag(shifts)
        by = [(self.seen(a, self.late) - self.seen(b, self.late)) / width for (a, b), width in zip(pairs, widths, strict=True)]
        leading = [(a.closed.parameter - b.closed.parameter) / width for (a, b), width in zip(pairs, widths, strict=True)]
        return np.column_stack(by), np.insert(np.eye(known.coordinates.size)[1:], self.leading, leading, axis=0)

    def _late_by(self, closed: Closed) -> float:
        clock = sizes(closed.flow.scene)[0]
        return (closed.cycle.period * clock - self.record.period) / self.transit

    def _period_slopes(self, closed: Closed, inner: Array) -> Array:
        """d period/d parameters (transits) of an orbit; 0 for those that change a transit itself."""
        size, slopes = closed.velocity.size, []
        matrix = np.zeros((size + 1, size + 1))
        matrix[:size, :size], matrix[:size, size] = closed.monodromy - np.eye(size), closed.velocity
        matrix[size, :size] = closed.velocity
        for k in range(inner.size):

            def flow_at(x: float, k: int = k) -> Flow:
                return closed.flow.of(self.scene(np.where(np.arange(inner.size) == k, x, inner)))

            drift = by_parameter(flow_at, closed.cycle, float(inner[k]))
            is_clock = abs(sizes(flow_at(inner[k] + SHIFT[1]).scene)[0] / sizes(closed.flow.scene)[0] - 1.0) > SAME
            slopes.append(0.0 if is_clock else float(np.linalg.solve(matrix, np.append(-drift, 0.0))[-1]))
        return np.array(slopes)
