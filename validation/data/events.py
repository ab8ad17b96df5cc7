"""Slip events in a record, by the detector of runs (`slipwave.observe.EventObserver`), with the record's friction as elastic
stress and its slip rate as that of the interface. A fall counts only if it is larger than the range of pure noise in as many
samples. The rate and the extrema are those of a local parabola over some samples (Savitzky and Golay), because noise in friction
makes drops too large and rates meaningless. The effect of this smoothing on dates, drops and rates is measured by halving it.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from slipwave.errors import SceneError
from slipwave.friction import unknowns
from slipwave.observe import EventObserver, Events, Pieces
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from validation.data.series import Series

_NODES = np.array([0.5, 1.0])  # a straight line between two samples
_SHARE = 0.25  # of the duration of a fall: the smoothing that is chosen
_QUIET = 1e-6  # share of the range of friction below which a record has no noise
_LEAST_RATE = 1e-6  # of V, for the detector: noise makes a slow rate negative


@dataclass(frozen=True)
class Smoothing:
    """Samples of the local parabola (1: none), and the change of the figures with half as many: dates (transits), the others
    relative; NaN without events to compare. `apart`: the change in the number of events."""

    samples: int
    dates: float = math.nan
    period: float = math.nan
    stress_drop: float = math.nan
    v_max: float = math.nan
    apart: int = 0


@dataclass(frozen=True)
class MeasuredMotion:
    """A record of `source` in the units of a scene: time (transits), friction and slip rate (V*; `rate_from`: its source), both
    smoothed, the dates of its slip events, its complete cycles, its `noise` (of friction, standard deviation)."""

    source: str
    time: Array
    friction: Array
    slip_rate: Array
    rate_from: str
    dates: Array
    events: Events
    noise: float
    smoothing: Smoothing


def measured_motion(series: Series, scene: Scene, smooth: int | None = None) -> MeasuredMotion:
    """The motion in a record, with its slip events; `smooth` is the number of samples of the local parabola (default: a quarter
    of the duration of a slip event).

    Raises SceneError for a record without friction, without slip events or with a single one.
    """
    own = series.of(scene)
    time, friction = own["time"], own.friction(1.0)
    noise = noise_of(time, friction)
    floor = noise * 2.0 * math.sqrt(2.0 * math.log(time.size))
    if smooth is not None and not 1 <= smooth <= time.size // 2:
        raise SceneError(f"smooth = {smooth}: must be from 1 to {time.size // 2}, half of the samples in {series.source!r}")
    chosen = _chosen(own, scene, friction, floor) if smooth is None else smooth
    found = _seen(own, scene, friction, floor, chosen)
    if found.dates.size < 2 or not found.events.time.size:
        count = {0: "no slip event", 1: "one slip event only"}.get(found.dates.size, "no complete cycle between slip events")
        text = f": no fall of friction exceeds the range of noise, {floor:.2g} (smooth = N samples lessens it)"
        more = text if floor and not found.dates.size else "; a comparison of cycles needs two or more"
        raise SceneError(f"{series.source!r}: {count}{more}")
    half = _seen(own, scene, friction, floor, max(1, chosen // 2))
    return replace(found, noise=noise, smoothing=_effect(found, half, chosen))


def noise_of(time: Array, values: Array, quiet: float = _QUIET) -> float:
    """Standard deviation of the noise, from the median distance of samples from the straight line between their neighbours, on
    which slip events have no influence; 0 if it is below the share `quiet` of the range."""
    if time.size < 3:
        return 0.0
    share = (time[1:-1] - time[:-2]) / (time[2:] - time[:-2])
    bends = values[1:-1] - (1.0 - share) * values[:-2] - share * values[2:]
    found = float(np.median(np.abs(bends) / np.sqrt(1.0 + (1.0 - share) ** 2 + share**2))) / 0.6745
    return found if found > quiet * float(np.ptp(values)) else 0.0


def smoothed(values: Array, samples: int, slope: bool = False) -> Array:
    """Values (n,) of a local parabola over `samples` samples, or its slope per sample; `values` themselves for fewer than 3."""
    if samples < 3:
        return np.gradient(values) if slope else values
    from scipy.signal import savgol_filter

    return np.asarray(savgol_filter(values, samples + 1 - samples % 2, 2, deriv=int(slope)))


def _seen(own: Series, scene: Scene, friction: Array, floor: float, samples: int) -> MeasuredMotion:
    """The motion, smoothed over `samples` samples."""
    rate, rate_from = _slip_rate(own, scene, friction, samples)
    level = smoothed(friction, samples)
    observer = EventObserver(scene, _NODES, floor * min(1.0, 1.5 / math.sqrt(samples)))  # what a parabola leaves of white noise
    observer.scan(_pieces(own["time"], unknowns(scene.law, np.maximum(rate, _LEAST_RATE * scene.velocity)), level))
    return MeasuredMotion(
        own.source, own["time"], level, rate, rate_from, observer.dates(), observer.events(), 0.0, Smoothing(samples)
    )


def _pieces(time: Array, z: Array, friction: Array) -> Pieces:
    """Pieces that are straight lines between samples."""
    lines = [np.column_stack((0.5 * (values[1:] + values[:-1]), values[1:])) for values in (z, friction)]
    return Pieces(time[:-1], np.diff(time), lines[0], np.zeros_like(lines[0]), lines[1], lines[1])


def _slip_rate(own: Series, scene: Scene, friction: Array, samples: int) -> tuple[Array, str]:
    """The slip rate (V*) of a record, and its source: its own column, the slope of slip, or the slope of the load point's
    displacement minus the elastic one, by the scene's stiffness."""
    if "slip_rate" in own:
        return smoothed(own["slip_rate"], samples), "slip_rate"
    pace = scene.transit * smoothed(own["time"], samples, slope=True)  # L/V* per sample
    if "slip" in own:
        return smoothed(own["slip"], samples, slope=True) / pace, "slip"
    released = scene.transit * smoothed(friction, samples, slope=True) / scene.stiffness
    if "load_point_displacement" in own:
        load = smoothed(own["load_point_displacement"], samples, slope=True)
        return (load - released) / pace, "load_point_displacement and the scene's stiffness"
    return scene.velocity - released / pace, "the scene's velocity and stiffness"


def _chosen(own: Series, scene: Scene, friction: Array, floor: float) -> int:
    """Samples of the parabola: a quarter of those in the median fall of friction; 1 without noise or events."""
    first = _seen(own, scene, friction, floor, 1)
    if floor == 0.0 or not first.events.time.size:
        return 1
    starts = np.searchsorted(own["time"], first.events.time - 0.5 * first.events.period[0])
    ends = np.searchsorted(own["time"], first.events.time + 0.5 * first.events.period)
    lasting = [_fall(friction[begin:end]) for begin, end in zip(starts, ends, strict=True) if end - begin > 2]
    return max(1, int(_SHARE * float(np.median(lasting)))) if lasting else 1


def _fall(values: Array) -> int:
    """Samples from 90 % to 10 % of the way down from the maximum to the minimum after it."""
    top = int(np.argmax(values))
    bottom = top + int(np.argmin(values[top:]))
    part = values[top : bottom + 1]
    share = (part - part[-1]) / (part[0] - part[-1]) if part[0] > part[-1] else np.zeros(1)
    return int(np.count_nonzero((share < 0.9) & (share > 0.1)))


def _effect(found: MeasuredMotion, half: MeasuredMotion, samples: int) -> Smoothing:
    """How the figures change with half the smoothing."""
    apart = half.dates.size - found.dates.size
    if apart or half.events.time.size != found.events.time.size:
        return Smoothing(samples, apart=apart)
    changes = [
        abs(float(np.mean(other) / np.mean(one)) - 1.0) for one, other in zip(found.events[1:], half.events[1:], strict=True)
    ]
    return Smoothing(samples, float(np.abs(half.dates - found.dates).max()), changes[0], changes[1], changes[3])
