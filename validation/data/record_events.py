"""Slip events in a record: falls of friction by much of its range, dated where it passes the middle of the fall.

Events of runs are dated by their slip rate (`slipwave.observe`). A record has none, or the slope of noisy friction in the steps
of a gauge, and a machine rings after each slip. The passage of the middle of a large fall needs no slope and no smoothing:
`compare` and `fit` date a record by it. Drops and slip rates need smoothing, by a local parabola over some samples (Savitzky and
Golay). Its effect is measured by halving it.

Waves that stay in a stiff sample let friction at the interface fall by more than half of an event's fall, hundreds of times after
each; but nothing slips then. So where a record has the slip too, and in a model, falls with hardly any slip are no events.
"""

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from slipwave.errors import SceneError
from slipwave.observe import Events
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from validation.data.series import Series

FALL = 0.4
"""Of the range of friction: a smaller fall is no event."""

_ABOVE = 8.0  # times the noise: the smallest fall that is distinguished from it
_BLOCKS = (4000, 1000, 250)  # means, among which falls are sought if noise, or waves, hide them in the samples
_WHOLE = 0.8  # of the median fall: a smaller one is cut off if it lasts longer than what is between it and an end of the record
_SLIPS = 0.1  # of the slip in the fall with most: with less a wave rings (steel on PMMA: 1e-5)
_SHARE = 0.25  # of the duration of a fall: the longest smoothing that is chosen
_BENT = 1.5  # times the noise: what smoothing may take from falls; more of it is motion, as waves that make steps of them
STANDS_OUT = 4.0
"""Standard errors, beyond which cycles differ by more than noise."""

_ALIKE = 5  # cycles, that say what is settled
_QUIET = 1e-6  # share of the range of friction below which a record has no noise


class SlipEvents(NamedTuple):
    """The slip events of a record, one a row: the samples of the `top` and the `bottom` of the fall, the last sample `above` its
    middle, its `drop` and its `date`."""

    top: NDArray[np.intp]
    bottom: NDArray[np.intp]
    above: NDArray[np.intp]
    drop: Array
    date: Array


def slip_events(time: Array, friction: Array, slip: Array | None = None) -> SlipEvents:
    """The slip events of a record: falls by at least `FALL` of the range of friction, or of its means over so many samples that
    noise is hidden, in which the interface slips, if `slip` is known; none that an end of the record cuts off, and none made by
    single values far off their neighbours. The date is when friction last falls through the middle between its maximum and its
    minimum."""
    spans: list[tuple[int, int]] = []
    for together in sorted({max(1, time.size // blocks) for blocks in (time.size, *_BLOCKS)}):
        means = _means(friction, together)
        calm = _without_spikes(means)
        least = FALL * float(np.ptp(calm))
        if least > _ABOVE * noise_of(np.arange(means.size, dtype=float), means):
            drops = [span for span in falls(means, least) if _falls_by(calm, span, least)]
            spans = _without_cut(drops if slip is None else without_waves(drops, _means(slip, together)), means)
            break
    first, last = np.array(spans, dtype=np.intp).reshape(-1, 2).T
    top, bottom = together * first, np.minimum(together * last + together, time.size) - 1
    middle = 0.5 * (means[first] + means[last])
    passages = [  # the last sample above the middle that is followed by one below
        np.flatnonzero((friction[a:b] > level) & (friction[a + 1 : b + 1] <= level))[-1]
        for a, b, level in zip(top, bottom, middle, strict=True)
    ]
    above = top + np.array(passages, dtype=np.intp)
    share = (friction[above] - middle) / (friction[above] - friction[above + 1])
    return SlipEvents(top, bottom, above, means[first] - means[last], time[above] + share * (time[above + 1] - time[above]))


def date_errors(times: Array, friction: Array, events: SlipEvents, noise: float) -> Array:
    """Standard deviations of the dates of events: a fall between two samples is uniformly distributed between them."""
    gap, fall = (step[events.above] for step in (np.diff(times), -np.diff(friction)))
    return np.asarray(gap * np.hypot(np.minimum(fall / events.drop, 1.0) / 12.0**0.5, noise / np.maximum(fall, noise)))


def without_unsettled(times: Array, friction: Array, events: SlipEvents, noise: float) -> tuple[SlipEvents, int]:
    """The events without first cycles, at most half, in which the motion settles, and the number of these: they approach the
    later ones monotonically and still differ by more than these among themselves and by more than the errors of dates."""
    periods, errors = np.diff(events.date), date_errors(times, friction, events, noise)
    for k in range(min(periods.size // 2, periods.size - _ALIKE), 0, -1):
        scatter = max(float(np.std(periods[k:], ddof=1)), float(np.sqrt(2.0 * np.mean(errors**2))))
        away = np.abs(periods[:k] - np.median(periods[k:]))
        if away[-1] > STANDS_OUT * scatter and (np.diff(away) < scatter).all():
            return SlipEvents._make(column[k:] for column in events), k
    return events, 0


def _means(values: Array, together: int) -> Array:
    """Means of so many values each."""
    return np.asarray(values[: values.size // together * together].reshape(-1, together).mean(axis=1))


def _without_spikes(values: Array) -> Array:
    """Medians of three neighbours: single values far off the others make no fall, steps stay as they are."""
    ends = np.concatenate([values[:1], values, values[-1:]])
    return np.asarray(np.median([ends[:-2], ends[1:-1], ends[2:]], axis=0))


def _falls_by(values: Array, span: tuple[int, int], least: float) -> bool:
    """Whether values fall by `least` from the highest to the lowest after it within a span."""
    part = values[span[0] : span[1] + 1]
    return bool((np.maximum.accumulate(part) - part).max() >= least)


def without_waves(spans: list[tuple[int, int]], slip: Array) -> list[tuple[int, int]]:
    """The falls of friction in which the `slip` moves; a slow motion may be added to the slip, as in a load-point record."""
    moved = [abs(float(slip[bottom] - slip[top])) for top, bottom in spans]
    return [span for span, far in zip(spans, moved, strict=True) if far >= _SLIPS * max(moved)]


def slip_in(series: Series) -> Array | None:
    """The slip by its own column or by that of the slip rate, in a unit of its own; None without both."""
    if "slip" in series or "slip_rate" not in series:
        return series.columns.get("slip")
    from scipy.integrate import cumulative_trapezoid

    return np.asarray(cumulative_trapezoid(series["slip_rate"], series["time"], initial=0))


def _without_cut(spans: list[tuple[int, int]], values: Array) -> list[tuple[int, int]]:
    """The falls without the first and the last if an end of the record cuts them off."""
    if len(spans) < 2:
        return spans
    usual = _WHOLE * float(np.median([values[top] - values[bottom] for top, bottom in spans]))
    (top, bottom), (late, end) = spans[0], spans[-1]
    begins = values[top] - values[bottom] > usual or top > bottom - top
    ends = values[late] - values[end] > usual or values.size - 1 - end > end - late
    return spans[not begins : len(spans) - (not ends)]


def falls(values: Array, least: float) -> list[tuple[int, int]]:
    """(maximum, minimum) indices of every fall by at least `least` that is followed by a rise of that size; the last fall needs
    none."""
    spans, top, bottom, is_falling = [], 0, 0, False
    for k, value in enumerate(values.tolist()):
        if not is_falling:
            top = k if value > values[top] else top
            if values[top] - value > least:
                is_falling, bottom = True, k
        else:
            bottom = k if value < values[bottom] else bottom
            if value - values[bottom] > least:
                spans.append((top, bottom))
                is_falling, top = False, k
    return [*spans, (top, bottom)] if is_falling else spans


@dataclass(frozen=True)
class MeasuredMotion:
    """A record of `source` in the units of a scene: time (transits), friction and slip rate (V*; `rate_from`: its source), both
    smoothed; the dates of its slip events and its complete cycles, without the `early` first ones (`without_unsettled`; their
    number); its `noise` (of friction, standard deviation). `smoothing`: the `samples` of the local parabola (1: none), the
    relative change of the mean `stress_drop` and `v_max` with half as many, and how events of the smoothed friction differ: in
    `dates` (transits), mean `period` (relative), both NaN for another number of events, and number (`apart`)."""

    source: str
    time: Array
    friction: Array
    slip_rate: Array
    rate_from: str
    dates: Array
    events: Events
    early: int
    noise: float
    smoothing: dict[str, Any]


def measured_motion(series: Series, scene: Scene, smooth: int | None = None) -> MeasuredMotion:
    """The motion in a record, with its slip events; `smooth` is the number of samples of the local parabola (default:
    as `_chosen`).

    Raises SceneError for a record without friction, without slip events or with a single one.
    """
    own = series.of(scene)
    time, friction = own["time"], own.friction(1.0)
    if smooth is not None and not 1 <= smooth <= time.size // 2:
        raise SceneError(f"smooth = {smooth}: must be from 1 to {time.size // 2}, half of the samples in {series.source!r}")
    slip = slip_in(own)
    found, noise = slip_events(time, friction, slip), noise_of(time, friction)
    if found.date.size < 2:
        count = ("no slip event", "one slip event only")[found.date.size]
        text = f": no fall of friction exceeds the range of noise, {_ABOVE * noise:.2g}"
        more = text if noise and not found.date.size else "; a comparison of cycles needs two or more"
        raise SceneError(f"{series.source!r}: {count}{more}")
    slips, early = without_unsettled(time, friction, found, noise)
    samples = smooth or (_chosen(friction, slips, noise) if noise else 1)
    level, rate, rate_from = _smooth_motion(own, scene, friction, samples)
    cycles = _cycles(slips, level, rate)
    half = _cycles(slips, *_smooth_motion(own, scene, friction, max(1, samples // 2))[:2])
    effect = _effect(samples, found.date, slip_events(time, level, slip).date, cycles, half)
    return MeasuredMotion(series.source, time, level, rate, rate_from, slips.date, cycles, early, noise, effect)


def _cycles(slips: SlipEvents, friction: Array, rate: Array) -> Events:
    """The cycles from one maximum of friction to the next."""
    parts = [slice(begin, end + 1) for begin, end in pairwise(slips.top)]
    drop = np.array([np.ptp(friction[part]) for part in parts])
    highest, lowest = (np.array([extreme(rate[part]) for part in parts]) for extreme in (np.max, np.min))
    return Events(slips.date[:-1], np.diff(slips.date), drop, drop, highest, lowest)


def noise_of(time: Array, values: Array, quiet: float = _QUIET) -> float:
    """Standard deviation of the noise, from the median distance of samples from the straight line between their neighbours, on
    which slip events have no influence; 0 if it is below the share `quiet` of the range."""
    if time.size < 3:
        return 0.0
    share = (time[1:-1] - time[:-2]) / (time[2:] - time[:-2])
    bends = values[1:-1] - (1.0 - share) * values[:-2] - share * values[2:]
    noise = float(np.median(np.abs(bends) / np.sqrt(1.0 + (1.0 - share) ** 2 + share**2))) / 0.6745
    return noise if noise > quiet * float(np.ptp(values)) else 0.0


def _smoothed(values: Array, samples: int, slope: bool = False) -> Array:
    """Values (n,) of a local parabola over `samples` samples, or its slope per sample; `values` themselves for fewer than 3."""
    if samples < 3:
        return np.gradient(values) if slope else values
    from scipy.signal import savgol_filter

    return np.asarray(savgol_filter(values, samples + 1 - samples % 2, 2, deriv=int(slope)))


def _smooth_motion(own: Series, scene: Scene, friction: Array, samples: int) -> tuple[Array, Array, str]:
    """Friction, smoothed; the slip rate (V*), and its source: its own column, the slope of slip, or the slope of the load point's
    displacement minus the elastic one, by the scene's stiffness."""
    level = _smoothed(friction, samples)
    if "slip_rate" in own:
        return level, _smoothed(own["slip_rate"], samples), "slip_rate"
    pace = scene.transit * _smoothed(own["time"], samples, slope=True)  # L/V* per sample
    if "slip" in own:
        return level, _smoothed(own["slip"], samples, slope=True) / pace, "slip"
    released = scene.transit * _smoothed(friction, samples, slope=True) / scene.stiffness
    if "load_point_displacement" in own:
        load = _smoothed(own["load_point_displacement"], samples, slope=True)
        return level, (load - released) / pace, "load_point_displacement and the scene's stiffness"
    return level, scene.velocity - released / pace, "the scene's velocity and stiffness"


def _chosen(friction: Array, events: SlipEvents, noise: float) -> int:
    """Samples of the parabola: a quarter of those in the median fall of friction, from 90 % to 10 % of the way down from the
    maximum to the minimum after it; halved until smoothing changes friction in the falls by little more than the `noise`."""
    lasting = []
    for begin, end in zip(events.top, events.bottom, strict=True):
        values = friction[begin : end + 1]
        top = int(np.argmax(values))
        part = values[top : top + int(np.argmin(values[top:])) + 1]
        share = (part - part[-1]) / (part[0] - part[-1]) if part[0] > part[-1] else np.zeros(1)
        lasting.append(int(np.count_nonzero((share < 0.9) & (share > 0.1))))
    samples = max(1, int(_SHARE * float(np.median(lasting))))
    falling = np.concatenate([np.arange(a, b + 1) for a, b in zip(events.top, events.bottom, strict=True)])
    while np.std((friction - _smoothed(friction, samples))[falling]) > _BENT * noise:
        samples = samples // 2 if samples > 7 else 1  # a parabola through 3 samples smooths nothing
    return samples


def _effect(samples: int, dates: Array, others: Array, cycles: Events, half: Events) -> dict[str, Any]:
    """Changes of dates to the `others` of the smoothed friction, of the cycles' figures to those with `half` the smoothing."""
    drop, v_max = (
        abs(float(getattr(half, name).mean() / getattr(cycles, name).mean()) - 1.0) for name in ("stress_drop", "v_max")
    )
    moved, period = math.nan, math.nan
    if others.size == dates.size:
        moved, period = float(np.abs(others - dates).max()), abs(float(np.ptp(others) / np.ptp(dates)) - 1.0)
    figures = {"samples": samples, "dates": moved, "period": period, "stress_drop": drop, "v_max": v_max}
    return figures | {"apart": others.size - dates.size}
