"""Least squares of a model's periodic orbit against all samples of a record (`validation.fit.orbits`)."""

from collections.abc import Iterable

import numpy as np

from reduced.orbit.multipliers import count_unstable
from reduced.orbit.periodic import periodic_orbit
from slipwave.errors import NumericsError
from slipwave.observe.pieces import Array
from slipwave.observe.statistics import autocorrelations
from validation.fit.least_squares import BestValues, Solution, minimise
from validation.fit.orbits import Anchor, CycleOfOrbit
from validation.fit.problem import FrictionProblem
from validation.models.progress import log

_AWAY = 2.0  # transits to which the period may differ from the record's, and the date of an event
_ALIKE, _LAGS = 0.15, 50  # correlation of what is left, and up to how many samples
_AGAIN = 1e-3  # relative difference of two sums of squares that are the same minimum's
_LITTLE = 0.5  # times the noise: a record without any
_FAR, _MUCH = 1.2, 2.0  # times the noise: a residual that no noise explains; nor cycles that differ, which count as noise


class _OrbitCoordinates:
    """A `FrictionProblem` of one record in the coordinates (period, date of the first event, parameters other than the leading
    one, nuisances)."""

    fineness = 1e-9

    def __init__(self, problem: FrictionProblem, model: CycleOfOrbit) -> None:
        self.problem, self.model, self.keys = problem, model, len(problem.free)
        self.low, self.high = (
            np.append([end, end], np.delete(ends, model.leading)) for end, ends in ((-_AWAY, problem.low), (_AWAY, problem.high))
        )
        self.names = ["period", "date", *np.delete(problem.names, model.leading).tolist()]
        self.large = np.ones(len(self.names))

    def inner(self, coordinates: Array) -> Array:
        """The values that the problem varies, of the orbit at the coordinates, to which the model goes. Raises NumericsError
        where the leading parameter would pass its bounds."""
        anchor = self.model.walk(np.insert(coordinates[2 : self.keys + 1], 0, coordinates[0]), float(coordinates[1]))
        if not self.problem.low[self.model.leading] < anchor.closed.parameter < self.problem.high[self.model.leading]:
            raise NumericsError("the leading parameter passes its bounds")
        return np.append(self.model.inner(anchor), coordinates[self.keys + 1 :])

    def residual(self, coordinates: Array) -> Array:
        """As `Problem`; without the period, which is a coordinate."""
        return self.problem.residual(self.inner(coordinates))[1:]

    def slopes(self, coordinates: Array) -> Array:
        """As `Problem`."""
        self.inner(coordinates)
        by, _ = self.model.differences(self.model.known)
        columns = [by[:, 0], self.model.by_date(), by[:, 1:], self.problem.shapes[0][1:]]
        return np.column_stack(columns) / self.model.record.noise


def fitted_orbit(problem: FrictionProblem, model: CycleOfOrbit, starts: Iterable[Array], best: BestValues) -> Solution:
    """Fit the orbit of the `model` of the problem's record from the first of `starts` that leads to a residual as small as the
    noise, else from the best.

    Raises NumericsError if no start leads to an orbit."""
    keys, reasons = len(problem.free), []
    best_yet: tuple[Solution, Anchor] | None = None

    def see(coordinates: Array, residual: Array) -> None:
        """Keep the `best` values as parameters, those of the orbit of the model."""
        best.see(np.append(model.inner(model.known), coordinates[keys + 1 :]), residual)

    for start in starts:
        try:
            begun = model.begin(start[:keys])
            log.info(
                "an orbit of %.6g transits, the record's has %.6g",
                *(x / model.transit for x in (model.period(begun), model.record.period)),
            )
            coordinates = _OrbitCoordinates(problem, model)
            first = np.concatenate([[0.0, 0.0], begun.coordinates[1:], start[keys:]])
            solution = minimise(coordinates, [first], BestValues(first, also=see))
            coordinates.inner(solution.inner)
        except NumericsError as reason:
            reasons.append(str(reason))
            if model.left <= 0.0:
                break
            continue
        log.info("a residual of %.3g times the noise", _far(solution))
        again = best_yet is not None and abs(solution.cost / best_yet[0].cost - 1.0) < _AGAIN
        if best_yet is None or solution.cost < best_yet[0].cost:
            best_yet = solution, model.known
        if _far(solution) < _FAR or again:
            break
    if best_yet is None:
        raise NumericsError(f"fit: no start value leads to an orbit: {reasons[-1 if model.left <= 0.0 else 0]}")
    solution, there = best_yet
    model.stay(there, float(solution.inner[1]))
    inner = np.append(model.inner(there), solution.inner[keys + 1 :])
    slopes, date = problem.slopes(inner), np.append(0.0, model.by_date())  # at the best date of events
    slopes -= np.outer(date, date @ slopes) / (date @ date)
    return Solution(inner, problem.residual(inner), slopes, best.evaluations, _fault(model, solution) or solution.failed)


def _fault(model: CycleOfOrbit, solution: Solution) -> str:
    """Why no interval holds for the best orbit, if none does."""
    far, closed = _far(solution), model.known.closed
    alike = float(np.abs(autocorrelations(solution.residual[np.argsort(model.record.times, kind="stable")])[1 : _LAGS + 1]).max())
    if far > _FAR and (far > _MUCH or alike < _ALIKE):
        return f"no orbit of the model is the record's: the best leaves {far:.3g} times the noise, and no interval holds for it"
    if far > _LITTLE and alike > max(_ALIKE, 5.0 / solution.residual.size**0.5):
        text = f"what is left correlates by {alike:.2g} within {_LAGS} samples"
        return f"cycles of the record differ by more than noise ({text}), no interval holds: take a part that repeats (--window)"
    if (
        count_unstable(closed)
        and periodic_orbit(closed.flow, closed.cycle.start, closed.cycle.period).multipliers.stable is False
    ):
        return "the orbit nearest to the record is unstable: no sample would stay on it"
    return ""


def _far(solution: Solution) -> float:
    """Ratio of the residual to the noise."""
    return float(np.sqrt(np.mean(solution.residual**2)))
