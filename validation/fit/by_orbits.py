"""Least squares of a model's periodic orbit against all samples of a record (`validation.fit.orbits`)."""

from collections.abc import Iterable

import numpy as np

from reduced.orbit.multipliers import count_unstable
from reduced.orbit.periodic import periodic_orbit
from slipwave.errors import NumericsError
from slipwave.observe.pieces import Array
from slipwave.observe.statistics import autocorrelations
from validation.fit.least_squares import Best, Solution, minimise
from validation.fit.orbits import SHIFT, Anchor, CycleOfOrbit
from validation.models.progress import log

_AWAY = 2.0  # transits to which the period may differ from the record's, and the date of an event
_ALIKE, _LAGS = 0.15, 50  # correlation of what is left, and up to how many samples
_AGAIN = 1e-3  # relative difference of two sums of squares that are the same minimum's
_LITTLE = 0.5  # times the noise: a record without any
_FAR, _MUCH = 1.2, 2.0  # times the noise: a residual that no noise explains; nor cycles that differ, which count as noise


class _OrbitCoordinates:
    """`Problem` of a record in the coordinates (period, date of the first event, parameters other than the leading one,
    nuisances)."""

    fineness = 1e-9

    def __init__(self, model: CycleOfOrbit, low: Array, high: Array, shapes: Array) -> None:
        """`low` and `high` (m,): bounds of the parameters; `shapes` (n, k): derivatives of friction by the nuisances."""
        self.model, self._shapes, self._low, self._high = model, shapes, low, high
        rest, count = np.arange(low.size) != model.leading, shapes.shape[1]
        free = np.full(count, np.inf)
        self.low = np.concatenate([[-_AWAY, -_AWAY], low[rest], -free])
        self.high = np.concatenate([[_AWAY, _AWAY], high[rest], free])
        self.names = ["period", "date", *map(str, range(low.size - 1 + count))]
        self.large = np.ones(len(self.names))

    def orbit(self, coordinates: Array) -> Anchor:
        """The orbit at the coordinates. Raises NumericsError where the leading parameter would pass its bounds."""
        count = self.model.anchor.coordinates.size if self.model.anchor else 0
        anchor = self.model.walk(np.insert(coordinates[2 : count + 1], 0, coordinates[0]))
        if not self._low[self.model.leading] < anchor.closed.parameter < self._high[self.model.leading]:
            raise NumericsError("the leading parameter passes its bounds")
        return anchor

    def residual(self, coordinates: Array) -> Array:
        """As `Problem`."""
        anchor, record = self.orbit(coordinates), self.model.record
        own = coordinates[coordinates.size - self._shapes.shape[1] :]
        return (self.model.seen(anchor, float(coordinates[1])) + self._shapes @ own - record.friction) / record.noise

    def slopes(self, coordinates: Array) -> Array:
        """As `Problem`."""
        anchor, late = self.orbit(coordinates), float(coordinates[1])
        by, _ = self.model.differences(anchor, late)
        moved = [self.model.seen(anchor, late + sign * SHIFT[0]) for sign in (1.0, -1.0)]
        return (
            np.column_stack([by[:, 0], (moved[0] - moved[1]) / (2.0 * SHIFT[0]), by[:, 1:], self._shapes])
            / self.model.record.noise
        )


def fitted_orbit(
    model: CycleOfOrbit, bounds: tuple[Array, Array], shapes: Array, starts: Iterable[Array], best: Best
) -> Solution:
    """Fit the orbit to the record from the first of `starts` that leads to a residual as small as the noise, else from the best.
    Unknowns: parameters within `bounds`, then nuisances, with derivatives `shapes` (n, k) of friction.

    Raises NumericsError if no start leads to an orbit."""
    keys, reasons = bounds[0].size, []
    best_yet: tuple[Solution, Anchor, _OrbitCoordinates] | None = None

    def see(coordinates: Array, residual: Array) -> None:
        """Keep the `best` values as parameters, those of the orbit of the model."""
        if model.anchor is not None:
            best.see(np.append(model.inner(model.anchor), coordinates[keys + 1 :]), residual)

    for start in starts:
        try:
            begun = model.begin(start[:keys])
            log.info(
                "an orbit of %.6g transits, the record's has %.6g",
                *(x / model.transit for x in (model.period(begun), model.record.period)),
            )
            coordinates = _OrbitCoordinates(model, *bounds, shapes)
            first = np.concatenate([[0.0, 0.0], begun.coordinates[1:], start[keys:]])
            one = minimise(coordinates, [first], Best(first, also=see))
            there = coordinates.orbit(one.inner)
        except NumericsError as reason:
            reasons.append(str(reason))
            if model.left <= 0.0:
                break
            continue
        log.info("a residual of %.3g times the noise", _far(one))
        again = best_yet is not None and abs(one.cost / best_yet[0].cost - 1.0) < _AGAIN
        if best_yet is None or one.cost < best_yet[0].cost:
            best_yet = one, there, coordinates
        if _far(one) < _FAR or again:
            break
    if best_yet is None:
        raise NumericsError(f"fit: no start value leads to an orbit: {reasons[-1 if model.left <= 0.0 else 0]}")
    one, there, coordinates = best_yet
    model.stay(there, float(one.inner[1]))
    return _over_parameters(model, one, coordinates.slopes(one.inner), keys, best.evaluations)


def _over_parameters(model: CycleOfOrbit, one: Solution, by: Array, keys: int, evaluations: int) -> Solution:
    """A solution in coordinates, with derivative `by`, converted to parameters, with the best date of events."""
    known = model.anchor
    assert known is not None
    closed = known.closed
    _, change = model.differences(known, model.late)
    date = by[:, 1] / np.linalg.norm(by[:, 1])
    slopes = np.column_stack([by[:, [0, *range(2, keys + 1)]] @ np.linalg.inv(change), by[:, keys + 1 :]])
    slopes -= np.outer(date, date @ slopes)
    failed, far = one.failed, _far(one)
    alike = float(np.abs(autocorrelations(one.residual[np.argsort(model.record.times, kind="stable")])[1 : _LAGS + 1]).max())
    if far > _FAR and (far > _MUCH or alike < _ALIKE):
        failed = f"no orbit of the model is the record's: the best leaves {far:.3g} times the noise, and no interval holds for it"
    elif far > _LITTLE and alike > max(_ALIKE, 5.0 / one.residual.size**0.5):
        text = f"what is left correlates by {alike:.2g} within {_LAGS} samples"
        failed = (
            f"cycles of the record differ by more than noise ({text}), no interval holds: take a part that repeats (--window)"
        )
    elif (
        count_unstable(closed)
        and periodic_orbit(closed.flow, closed.cycle.start, closed.cycle.period).multipliers.stable is False
    ):
        failed = "the orbit nearest to the record is unstable: no sample would stay on it"
    residual, rows = np.append(0.0, one.residual), np.vstack([np.zeros(slopes.shape[1]), slopes])
    return Solution(np.append(model.inner(known), one.inner[keys + 1 :]), residual, rows, evaluations, failed)


def _far(one: Solution) -> float:
    """Ratio of the residual to the noise."""
    return float(np.sqrt(np.mean(one.residual**2)))
