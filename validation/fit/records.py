"""Measured records for a fit: friction over time, and the motion of the load point."""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple, TypeAlias

import numpy as np

from slipwave.errors import SceneError
from slipwave.input.assemble import ends_of_window, moment
from slipwave.input.quantity import looks_measured, quantity
from slipwave.input.wording import shorten
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from slipwave.scene.drive import Drive
from validation.data.record_events import noise_of, slip_in
from validation.data.series import UNREAD, Series
from validation.fit.cycles import MeanCycle, mean_cycle
from validation.fit.parameters import schedule_of, sizes

_ALONE = 3.0  # standard deviations by which a straight line may miss
_REST = 0.003  # of the largest velocity; a slower load point is at rest
_WORTH = 40.0  # times the square of the noise: what a bend must take off the sum of squares
_MOST_KNOTS = 400
_LEAST = 8  # samples
_GAUGE = 1e-7  # of the range of a displacement, the least noise that it is taken to have
_STILL = 0.02  # of the range of friction: what fluctuates by more in every stage is motion, not noise
_WRITTEN = 0.3  # of the values of a column that are multiples of its last digit
FINEST = 1e-4
"""Least assumed noise of a record, as a share of the range of friction."""


Samples: TypeAlias = tuple[Array, Array, Array | None]
"""Times, friction, and the slip if it is known."""


class Experiment(NamedTuple):
    """`friction` at `times` since the start of the scene (s, or transits in a scene without units), the `schedule` of the load
    point, its displacement `travel` at these times (m, or L), and `notes` on how they were determined. Residuals are multiplied
    by `weight`. With `cycle` it is the mean cycle of stick-slip: the first sample is its period, then friction in its bins;
    `samples`: what was averaged. `together` (samples, k): effect of one standard deviation of each error common to
    the samples."""

    name: str
    times: Array
    friction: Array
    travel: Array
    schedule: Drive
    notes: tuple[str, ...] = ()
    weight: Array | float = 1.0
    cycle: MeanCycle | None = None
    samples: Samples | None = None
    together: Array | None = None

    @property
    def shown(self) -> slice:
        """The samples that are friction."""
        return slice(1 if self.cycle else 0, None)

    def weighed(self, values: Array) -> Array:
        """`values` (samples, ...) over the noise, with common errors reduced to the size of noise."""
        own = np.reshape(self.weight, (-1, *[1] * (values.ndim - 1))) * values
        if self.together is None:
            return np.asarray(own)
        ways, sizes, _ = np.linalg.svd(np.reshape(self.weight, (-1, 1)) * self.together, full_matrices=False)
        return np.asarray(own - (ways * (1.0 - 1.0 / np.hypot(1.0, sizes))) @ (ways.T @ own))


def experiment_of(series: Series, scene: Scene, window: str | None = None) -> Experiment:
    """The record of a file, driven as in the scene or, if that has one velocity, by the file's load point; only samples in the
    `window` "BEGIN:END" of the file's clock.

    Raises SceneError for a file without friction, and without time or displacement of the load point."""
    if series.is_own is False and scene.units is None:
        series.of(scene)  # refuses
    friction = series.friction(scene.units.normal_stress if scene.units else 1.0)
    inside = _inside(series, scene, window)
    known = schedule_of(scene)
    times = series["time"] if not series.is_own or scene.units is None else series["time"] * sizes(scene)[0]
    notes = list(series.notes)
    moved = _moved(series, scene, times) if known.is_constant else None
    if moved is not None:
        if np.ptp(moved) == 0.0:
            raise SceneError(f"{series.source!r}: the load point does not move: a fit needs steps, or stick-slip at one velocity")
        if moved[-1] < moved[0]:
            moved = -moved
            notes.append("the load point moves backwards: its sign was changed")
        load = followed(times, moved)
        if load.velocities[0] <= 0.0 or min(load.velocities) < 0.0:
            fault = "begins at rest" if load.velocities[0] == 0.0 else "turns back"
            raise SceneError(f"{series.source!r}: the load point {fault}; a fit begins in steady sliding: cut the file")
        times, known = times - times[0], Drive(tuple(t - times[0] for t in load.times), load.velocities)
        paces = [known.velocities[0], *known.velocities[2::2]]
        shown = ", ".join(f"{pace:.4g}" for pace in paces[:6]) + (", ..." if len(paces) > 6 else "")
        notes.append(f"the load point moves as in the file: {len(known.times) // 2} velocities, {shown}")
    if times[0] < 0.0 or times[0] > known.times[-1] > 0.0:
        notes.append(f"the file's clock begins at {times[0]:g}: its first sample is taken for the start of drive.velocity")
        times = times - times[0]
    slip = slip_in(series)
    times, friction = times[inside], friction[inside]
    if known.is_constant:
        try:
            return _stick_slip(series.source, (times, friction, slip if slip is None else slip[inside]), known, notes)
        except SceneError as error:
            unread = "".join(f"; {note}" for note in series.notes if note.startswith(UNREAD))
            raise SceneError(f"{error}{unread}") from None
    if np.ptp(friction) == 0.0:
        raise SceneError(f"{series.source!r}: friction does not change: it says nothing of any parameter")
    noise = max(
        noise_of(times, friction), _slow_noise(times, friction, known), _rounding(friction), FINEST * float(np.ptp(friction))
    )
    return Experiment(series.source, times, friction, known.travel(times), known, tuple(notes), 1.0 / noise)


def _slow_noise(times: Array, friction: Array, load: Drive) -> float:
    """Standard deviation of friction from a parabola in the later half of a stage of the load point, where it settles, of the
    calmest stage: neighbours hide noise that is correlated. 0 where all halves have too few samples, or friction moves."""
    deviations = list[float]()
    for begin, end in pairwise(np.unique(np.clip([times[0], *load.times, times[-1]], times[0], times[-1]))):
        late = (times > 0.5 * (begin + end)) & (times < end)
        if np.count_nonzero(late) >= _LEAST:
            away = friction[late] - np.polynomial.Polynomial.fit(times[late], friction[late], 2)(times[late])
            deviations.append(math.sqrt(float(away @ away) / (away.size - 3)))
    slow = min(deviations, default=0.0)
    return slow if slow < _STILL * float(np.ptp(friction)) else 0.0


def _moved(series: Series, scene: Scene, times: Array) -> Array | None:
    """Displacement of the load point (m, or V* transits), by its own column or by that of its velocity; None without both."""
    length, pace = (scene.units.memory_length, scene.units.reference_velocity) if series.is_own and scene.units else (1.0, 1.0)
    if "load_point_displacement" in series:
        return series["load_point_displacement"] * length / (1.0 if scene.units else scene.transit)
    if "load_point_velocity" in series:
        from scipy.integrate import cumulative_trapezoid

        return np.asarray(cumulative_trapezoid(series["load_point_velocity"] * pace, times, initial=0))
    return None


def _inside(series: Series, scene: Scene, window: str | None) -> slice:
    """The samples of a `window` of the file's clock (s, or transits of the `scene`). Raises SceneError for too few samples."""
    times, is_own = series["time"], series.is_own or scene.units is None
    if times.size < _LEAST:
        raise SceneError(f"{series.source!r}: has {times.size} samples: a fit needs {_LEAST}")
    if window is None:
        return slice(None)

    def time_at(text: float | str) -> float:
        """An end of the window."""
        if is_own or not looks_measured(str(text)):
            return moment("window", text, scene)
        try:
            return quantity(str(text), "s").value
        except ValueError:
            return math.nan

    begin, end = ends_of_window(window, time_at, -math.inf, "of the file's time, as in 40:180 or 40s:3min")
    first, last = np.searchsorted(times, (begin, np.nextafter(end, math.inf)))
    if last - first < _LEAST:
        raise SceneError(
            f"--window = {shorten(window)}: holds {max(last - first, 0)} samples of {series.source!r} (time from {times[0]:.6g} "
            f"to {times[-1]:.6g}): a fit needs {_LEAST}"
        )
    return slice(first, last)


def _stick_slip(name: str, samples: Samples, schedule: Drive, notes: list[str]) -> Experiment:
    """The mean cycle of a record at one velocity. Raises SceneError if it has no slip events."""
    cycle = mean_cycle(name, *samples)
    values, errors = (np.append(a, b) for a, b in ((cycle.period, cycle.friction), (cycle.period_error, cycle.friction_error)))
    where = np.append(0.0, cycle.phases) * cycle.period
    text = f"{cycle.events} slip events: period {cycle.period:.6g}, fall of friction {cycle.drop:.4g}"
    if cycle.drift:
        text += f"; its drift by {cycle.drift:.3g} was taken out, and its level is known to as much only (--free level)"
    if cycle.early:
        text += f"; {cycle.early} cycles before them are left out: in these the motion settles"
    travel = where * schedule.velocities[0]
    notes = [*notes, text]
    return Experiment(name, where, values, travel, schedule, tuple(notes), 1.0 / errors, cycle, samples, cycle.together)


def followed(times: Array, moved: Array) -> Drive:
    """The piecewise constant velocity of a load point that `moved`: as few connected straight lines as the noise allows."""
    noise = max(noise_of(times, moved, _GAUGE), _rounding(moved), _GAUGE * float(np.ptp(moved)))
    cuts = _merged(times, moved, _cuts(times, moved, noise), noise)
    parts = [(a, b, np.polyfit(times[a : b + 1], moved[a : b + 1], 1)) for a, b in pairwise(cuts)]
    corners = {k for k in range(1, len(parts) - 1) if _is_corner(times, parts[k - 1 : k + 2])}
    lines = [line for k, (_, _, line) in enumerate(parts) if k not in corners]
    fastest = max(abs(slope) for slope, _ in lines)
    knots, paces = [float(times[0])], [_pace(lines[0][0], fastest)]
    for before, after in pairwise(lines):
        if abs(after[0] - before[0]) < _REST * fastest:
            continue
        meet = float((after[1] - before[1]) / (before[0] - after[0]))
        knots += [min(max(meet, knots[-1]), float(times[-1]))] * 2
        paces += [paces[-1], _pace(after[0], fastest)]
    return Drive((*knots, float(times[-1])), (*paces, paces[-1]))


def _rounding(moved: Array) -> float:
    """Standard deviation of the rounding error of a record with discrete values or few decimals; 0 without visible rounding."""
    values = np.unique(moved)
    if values.size < 2:
        return 0.0
    steps, size = np.diff(values), float(np.abs(values).max())
    least = float(steps[steps > 1e-9 * np.ptp(moved)].min(initial=np.inf))
    largest = math.floor(math.log10(float(steps.max())))
    for step in (least, *(10.0**k for k in range(largest, largest - 8, -1))):
        away = (values if step != least else moved - moved[0]) / step
        share = float(np.mean(np.abs(away - np.rint(away)) < 1e-3 + 1e-15 * size / step))
        if share > (_WRITTEN if step != least else 0.999):
            return float(step / 12.0**0.5)
    return 0.0


def _is_corner(times: Array, three: Sequence[tuple[int, int, Array]]) -> bool:
    """Whether the middle of three parts lies between two samples and its adjacent lines meet there: a step between samples."""
    (_, _, before), (begin, end, _), (_, _, after) = three
    if end - begin > 1 or before[0] == after[0]:
        return False
    return bool(times[begin] <= (after[1] - before[1]) / (before[0] - after[0]) <= times[end])


def _pace(slope: float, fastest: float) -> float:
    return 0.0 if abs(slope) < _REST * fastest else float(slope)


def _cuts(times: Array, moved: Array, noise: float) -> list[int]:
    """Samples at which the motion bends."""
    cuts, waiting = {0, times.size - 1}, [(0, times.size - 1)]
    while waiting and len(cuts) < _MOST_KNOTS:
        begin, end = waiting.pop(0)
        if end - begin < 3:
            continue
        line = moved[begin] + (moved[end] - moved[begin]) * (times[begin : end + 1] - times[begin]) / (times[end] - times[begin])
        away = np.abs(moved[begin : end + 1] - line)
        worst = int(np.argmax(away))
        if away[worst] > (_ALONE + 2.0) * noise and 0 < worst < end - begin:
            cuts.add(begin + worst)
            waiting += [(begin, begin + worst), (begin + worst, end)]
    return sorted(cuts)


def _merged(times: Array, moved: Array, cuts: list[int], noise: float) -> list[int]:
    """The cuts without those that make the sum of squares hardly smaller."""

    def left(begin: int, end: int) -> float:
        t, x = times[begin : end + 1], moved[begin : end + 1]
        return float(np.sum((x - np.polyval(np.polyfit(t - t[0], x, 1), t - t[0])) ** 2)) if end - begin > 1 else 0.0

    parts = [left(a, b) for a, b in pairwise(cuts)]
    gains = [
        left(a, c) - part - other
        for (a, c), (part, other) in zip(zip(cuts, cuts[2:], strict=False), pairwise(parts), strict=False)
    ]
    while gains and min(gains) < _WORTH * noise**2:
        k = int(np.argmin(gains))
        parts[k : k + 2] = [left(cuts[k], cuts[k + 2])]
        del cuts[k + 1], gains[k]
        for m in (k - 1, k):
            if 0 <= m < len(gains):
                gains[m] = left(cuts[m], cuts[m + 2]) - parts[m] - parts[m + 1]
    return cuts
