"""Stick-slip records: the period and the shape of the mean cycle by its phase, measured and of a model.

Late waveforms are not compared: cycles drift apart, and waves ring differently in each. A model's events are dated as those of a
record are (`validation.data.record_events`). Phases close to events are left out: samples there depend on the recording more than
on friction.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from slipwave.errors import NumericsError, SceneError
from slipwave.observe.extrema import evaluate, find_root
from slipwave.observe.pieces import Array, Basis, Pieces
from slipwave.scene import Scene
from slipwave.scene.drive import Start, StartKind
from validation.data.record_events import (
    FALL,
    STANDS_OUT,
    SlipEvents,
    date_errors,
    falls,
    noise_of,
    slip_events,
    without_unsettled,
    without_waves,
)
from validation.fit.forward import OfReduction, basis_of, sampled
from validation.fit.parameters import Variants, sizes

BINS = 48
MARGIN = 0.02
"""Share of a cycle that is left out on either side of an event."""

_FEWEST_NODES, _MOST_NODES = 3, 24  # of a bin, at which a model is asked
_PER_TRANSIT = 4.0  # of them: waves that are damped, but go on, swing within a bin
_FEWEST = 12  # bins that have samples
_SETTLED = 7  # events; the last cycle of so many is taken
_LONGER = (1.0, 2.5, 6.0, 15.0)  # times the expected length of a march
_SAME_PERIOD = 1e-5  # relative difference of two in a row with which the motion has settled
DISTURBED = 1.0
"""Jump of psi at the start of a march that is to stick and slip."""

_ASTRAY = 0.1  # transits by which dates may differ from those of equal cycles, beyond the interval of two samples
MOST = 20_000
"""Most samples used; longer records are thinned."""

_TRIALS = 161  # periods, of which the one whose samples lie closest is taken


class MeanCycle(NamedTuple):
    """The `period` (s or transits) and mean friction in bins, whose samples have the mean `phases`; their independent standard
    errors; number of `events`, mean `drop`; what was removed: a `drift`, and the number of `early` cycles, in which the motion
    settles. `together` (bins + 1, k): effect of one standard deviation of each common error, first on the period."""

    period: float
    period_error: float
    friction: Array
    friction_error: Array
    phases: Array
    together: Array
    events: int
    drop: float
    drift: float
    early: int


def _dated_events(name: str, times: Array, friction: Array, slip: Array | None) -> SlipEvents:
    """The slip events of a record. Raises SceneError for fewer than three."""
    events = slip_events(times, friction, slip)
    if (count := events.date.size) < 3:
        number = f"{count} slip events" if count else "no slip event"
        raise SceneError(
            f"{name!r}: {number} (friction changes by {np.ptp(friction):.3g}, noise {noise_of(times, friction):.2g}); a fit of "
            "stick-slip needs 3; for steps and holds give drive.velocity, or a column of the load point's displacement"
        )
    return events


def mean_cycle(name: str, times: Array, friction: Array, slip: Array | None = None) -> MeanCycle:
    """The mean cycle of a record, without unsettled first cycles and without a significant drift from cycle to cycle. `slip`: in
    any unit, if it is known. Raises SceneError for fewer than three slip events."""
    noise, events = noise_of(times, friction), _dated_events(name, times, friction, slip)
    events, early = without_unsettled(times, friction, events, noise)
    dates, periods = events.date, np.diff(events.date)
    which = np.searchsorted(dates, times, side="right") - 1
    inside = (which >= 0) & (which < periods.size)
    where = (times[inside] - dates[which[inside]]) / periods[which[inside]]
    bins = np.floor((where - MARGIN) / (1.0 - 2.0 * MARGIN) * BINS).astype(int)
    shown = (bins >= 0) & (bins < BINS)
    index = which[inside][shown] * BINS + bins[shown]

    def total(values: Array) -> Array:
        """Sums over the samples in each bin of each cycle (cycles, BINS)."""
        return np.asarray(np.bincount(index, values, periods.size * BINS).reshape(-1, BINS)[:, there], dtype=float)

    there = np.isin(np.arange(BINS), bins)
    if there.sum() < _FEWEST:
        raise SceneError(f"{name!r}: too few samples: a fit of stick-slip needs one in each of {_FEWEST} parts of the mean cycle")
    counts = total(np.ones(index.size))
    with np.errstate(invalid="ignore"):
        rows, at = total(friction[inside][shown]) / counts, total(where[shown]) / counts
    phases = np.nanmean(at, axis=0)
    slope = np.gradient(np.nanmean(rows, axis=0), phases)
    errors = date_errors(times, friction, events, noise)
    moved = float(np.abs(slope).mean() * np.sqrt(np.mean(errors**2)) / periods.mean())  # what a date's error adds to a cycle
    rows, drift = _level(rows - slope * (at - phases), phases, moved)  # each as at the mean phase
    values, seen = np.nanmean(rows, axis=0), np.isfinite(rows).mean(axis=0)
    own, together = _dating(dates, errors, _leaning(times, friction, events), times, slope / periods.mean(), phases)
    error, common = _scatter(rows - values, counts, noise)
    together = np.column_stack([together, np.append(0.0, np.full(values.size, common))])
    return MeanCycle(
        float(periods.mean()),
        max(own, 1e-9 * float(periods.mean()), 0.01 * together[0, 1]),
        values,
        np.hypot(error, moved * np.sqrt((1.0 - seen) / (seen * len(rows)))),  # cycles that are left out are dated otherwise
        phases,
        together,
        dates.size,
        float(np.median(events.drop)),
        drift,
        early,
    )


def _level(rows: Array, phases: Array, moved: float) -> tuple[Array, float]:
    """Rows of cycles without the linear trend of their means, and its change from the first to the last cycle; 0 if that is not
    significant against their scatter and the effect `moved` of the error of a date."""
    count = np.arange(len(rows)) - 0.5 * (len(rows) - 1)
    means = np.nanmean(rows - np.nanmean(rows, axis=0), axis=1)
    slope = float(count @ means / (count @ count))
    left = means - slope * count
    error = float(np.sqrt(left @ left / max(len(rows) - 2, 1) / (count @ count)))
    if len(rows) < 4 or abs(slope) < STANDS_OUT * error or abs(slope) * len(rows) < STANDS_OUT * moved:
        return rows, 0.0
    return np.asarray(rows - slope * (count[:, None] + phases - 0.5)), slope * (len(rows) - 1)


def _scatter(away: Array, counts: Array, noise: float) -> tuple[Array, float]:
    """Standard errors of the mean in each bin, and of its level, from the deviations `away` of cycles: those of noise, or larger
    where the scatter is significantly larger."""
    white = max(noise, 1e-9) ** 2 / np.maximum(counts, 1.0)
    cycles, seen = len(away), np.isfinite(away)
    level = np.nanmean(away, axis=1)
    known = np.nanmean(np.where(seen, white, np.nan), axis=1) / seen.sum(axis=1)
    freedom = max(int(seen.sum()) - cycles - counts.shape[1] + 1, 1)
    excess = float(np.nansum((away - level[:, None]) ** 2 / white)) / freedom
    excess = excess if excess > 1.0 + STANDS_OUT * (2.0 / freedom) ** 0.5 else 1.0
    more = float(level @ level) / max(cycles - 1, 1) - excess * float(known.mean())
    stands_out = more > STANDS_OUT * excess * float(known.mean()) * (2.0 / cycles) ** 0.5
    return np.sqrt(excess * np.sum(white * seen, axis=0)) / seen.sum(axis=0), (more / cycles) ** 0.5 if stands_out else 0.0


def _leaning(times: Array, friction: Array, events: SlipEvents) -> float:
    """Common bias of all dates: a fall between two samples is on average in their middle, but friction that falls slowly before
    gives an earlier date."""
    above = events.above
    share = np.minimum((friction[above] - friction[above + 1]) / events.drop, 1.0)
    return float(np.mean(share * (events.date - 0.5 * (times[above] + times[above + 1]))))


def _dating(dates: Array, errors: Array, leaning: float, times: Array, slope: Array, phases: Array) -> tuple[float, Array]:
    """The standard error of the period from cycles that differ by more than the errors of dates; and the effects (bins + 1, 2) of
    these errors on period and friction, with `slope` in time: by a shift of all events, and by apparent cycles that are too
    long."""
    periods, count = np.diff(dates), dates.size - 1
    turns = np.arange(dates.size) * float(periods.mean() / np.median(np.diff(times)))
    alike = abs(np.exp(2j * np.pi * turns).mean()) ** 2 * dates.size  # events that meet the clock's ticks alike are wrong alike
    shift = float(np.hypot(np.sqrt(np.mean(errors**2) * max(alike, 1.0) / dates.size), leaning))
    ends = float(np.hypot(errors[0], errors[-1])) / count
    varied = float(np.var(periods, ddof=1)) if count > 1 else 0.0
    own = (max(varied - 2.0 * float(np.mean(errors**2)), 0.0) / count) ** 0.5
    by_shift, by_length = np.append(0.0, slope * shift), np.append(1.0, slope * (phases - 0.5)) * ends
    return own, np.column_stack([by_shift, by_length])


class CycleOfReduction(OfReduction):
    """The last of some cycles of an ODE reduction that a disturbance has set going: period, then friction in the bins. Raises
    NumericsError where the model does not stick and slip."""

    def __init__(self, variants: Variants, period: float, model: str, tolerance: float, phases: Array | None = None) -> None:
        """`period`: expected; `phases`: mean phases of the samples in the bins, by default their middles."""
        width = (1.0 - 2.0 * MARGIN) / BINS
        middles = MARGIN + width * (np.arange(BINS) + 0.5) if phases is None else phases
        transits = width * period / sizes(variants.scenes.base)[0]
        count = int(np.clip(np.ceil(_PER_TRANSIT * transits), _FEWEST_NODES, _MOST_NODES))
        nodes, self._weights = (part / 2.0 for part in np.polynomial.legendre.leggauss(count))
        super().__init__(variants, (middles[:, None] + width * nodes).ravel(), model, tolerance)  # phases instead of times
        self._period = period

    def _march(self, scene: Scene) -> Pieces:
        for longer in _LONGER:
            until = float(np.ceil(longer * (_SETTLED + 1.5) * self._period / sizes(scene)[0]))
            pieces = self._until(scene, until)
            events = self._falls(pieces)
            if len(events) >= _SETTLED:
                slope = slope_of(pieces)
                first, second, third = (model_date(pieces, event, [slope])[0] for event in events[-3:])
                if abs(third - 2.0 * second + first) < _SAME_PERIOD * (third - second):
                    break
        if len(events) < _SETTLED:
            raise NumericsError(f"{self._model}: no {_SETTLED} slip events in {pieces.time[-1]:.4g} transits")
        return pieces

    def _falls(self, pieces: Pieces) -> list[tuple[int, int]]:
        """Events of the later half of a march, and earlier ones that are as large."""
        late = pieces.mu[pieces.mu.shape[0] // 2 :]
        return without_waves(falls(pieces.mu.ravel(), max(FALL * float(np.ptp(late)), 1e-6)), pieces.y.ravel())[:-1]

    def _seen(self, scene: Scene, pieces: Pieces, by: Sequence[Array]) -> list[Array]:
        """Period and friction of the last whole cycle, and their derivatives."""
        slope = slope_of(pieces)
        events = self._falls(pieces)[-2:]
        (begin, at_begin), (end, at_end) = (model_date(pieces, event, [slope, *by]) for event in events)
        period = end - begin
        rows = sampled(pieces, begin + self._times * period, [pieces.mu, slope, *by])
        clock = sizes(scene)[0]
        columns = [(period, rows[0])]
        for values, first, last in zip(rows[2:], at_begin, at_end, strict=True):
            columns.append((last - first, values + rows[1] * (first + self._times * (last - first))))
        return [np.append(time * clock, row.reshape(-1, self._weights.size) @ self._weights) for time, row in columns]


def slope_of(pieces: Pieces) -> Array:
    """d mu/dt at the nodes (k, s)."""
    return np.asarray(pieces.mu @ basis_of(pieces).derivative.T / pieces.length[:, None])


def model_date(pieces: Pieces, event: tuple[int, int], rows: list[Array]) -> tuple[float, list[float]]:
    """Date (transits) of an event between two nodes, and its derivatives by the parameters of `rows`, which begin with the
    slope."""
    basis, stages, mu, slope = basis_of(pieces), pieces.z.shape[1], pieces.mu.ravel(), rows[0]
    ends = [_extreme(basis, slope, node // stages) for node in event]
    levels = [0.5 * sum(evaluate(basis, row[piece], share) for piece, share in ends) for row in (pieces.mu, *rows[1:])]
    before = np.flatnonzero(mu[event[0] : event[1]] > levels[0])
    if before.size == 0:
        raise NumericsError(f"an event at t = {pieces.time[event[0] // stages]:.6g} transits has no date: ripples hide its fall")
    above = event[0] + int(before[-1])
    piece = (above + 1) // stages
    share = find_root(basis, pieces.mu[piece], levels[0], 0.0, 1.0)
    date = float(pieces.time[piece] + share * pieces.length[piece])
    steep = evaluate(basis, slope[piece], share)
    return date, [(level - evaluate(basis, row[piece], share)) / steep for level, row in zip(levels[1:], rows[1:], strict=True)]


def _extreme(basis: Basis, slope: Array, piece: int) -> tuple[int, float]:
    """The piece, `piece` or a neighbour, and the point of it in [0, 1] where the slope passes zero."""
    near = [k for k in (piece, piece + 1, piece - 1) if 0 <= k < len(slope)]
    there = next((k for k in near if evaluate(basis, slope[k], 0.0) * slope[k, -1] <= 0.0), None)
    if there is None:
        return piece, 1.0  # a wave's front makes a corner between two pieces
    return there, find_root(basis, slope[there], 0.0, 0.0, 1.0)


def disturbed(variants: Variants) -> Variants:
    """The same scenes with a jump of psi at the start, which makes them stick and slip."""
    return replace(variants, start=Start(StartKind.JUMP, DISTURBED))


class FoldedRecord(NamedTuple):
    """Samples of a record of equal cycles: `times` since the first event and the number of the `cycle`, both (n,), `friction`;
    `period`; their `noise`."""

    times: Array
    cycle: Array
    friction: Array
    period: float
    noise: float


def folded(name: str, times: Array, friction: Array, slip: Array | None, transit: float) -> FoldedRecord:
    """The samples of whole cycles away from events, sorted by phase. Raises SceneError for a record whose cycles are not
    equal."""
    dates = _dated_events(name, times, friction, slip).date
    count = np.arange(dates.size)
    period, first = np.polyfit(count, dates, 1)
    astray, step = float(np.std(dates - first - period * count)), float(np.median(np.diff(times)))
    if astray > step + _ASTRAY * transit:
        raise SceneError(
            f"{name!r}: slip events lie {astray / transit:.3g} transits off equal cycles; every wave can be fitted only to a "
            "motion that repeats: choose a part that does (--window), or a model without waves (quasidynamic)"
        )
    cycle = np.floor((times - first) / period)
    phase = (times - first) / period - cycle
    chosen = np.flatnonzero((cycle >= 0) & (cycle < dates.size - 1) & (phase > MARGIN) & (phase < 1.0 - MARGIN))
    chosen = chosen[:: -(-chosen.size // MOST)]
    since, cycle, values = times[chosen] - first, cycle[chosen], friction[chosen]

    def noise(longer: float) -> float:
        """Noise of the samples sorted by phase, for a period `longer` by this."""
        late = since - cycle * (period + longer)
        order = np.argsort(late, kind="stable")
        return noise_of(late[order], values[order])

    longer = min(np.linspace(-1.0, 1.0, _TRIALS) * 4.0 * max(astray, 0.1 * step) / dates.size, key=noise)
    order = np.argsort(since - cycle * (period + longer), kind="stable")
    return FoldedRecord(since[order], cycle[order], values[order], float(period + longer), noise(longer))
