"""Measured records as a fit takes them: friction at times, and how the load point moved."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from slipwave.errors import SceneError
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from slipwave.scene.drive import Drive
from validation.data.series import Series
from validation.fit.cycles import MeanCycle, mean_cycle, phases
from validation.fit.parameters import Schedule, schedule_of, sizes

_ALONE = 3.0  # standard deviations by which a straight line may miss
_REST = 0.003  # of the largest velocity; a slower load point is at rest
_WORTH = 40.0  # times the square of the noise: what a bend must take off the sum of squares
_MOST_KNOTS = 400


class Experiment(NamedTuple):
    """`friction` at `times` since the start of the scene (s, or transits in a scene without units), the `schedule` of the load
    point, its displacement `travel` at these times (m, or L), and `notes` on how they were found. Residuals count with `weight`.

    With `cycle` it is the mean cycle of stick-slip: in place of the first sample its period, then friction in its bins."""

    name: str
    times: Array
    friction: Array
    travel: Array
    schedule: Schedule
    notes: tuple[str, ...] = ()
    weight: Array | float = 1.0
    cycle: MeanCycle | None = None

    @property
    def shown(self) -> slice:
        """The samples that are friction."""
        return slice(1 if self.cycle else 0, None)


def experiment_of(series: Series, scene: Scene) -> Experiment:
    """The record of a file, driven as in the scene or, where that has one velocity, as the file's load point moved.

    Raises SceneError for a file without friction, and without time or displacement of the load point."""
    if series.is_own is False and scene.units is None:
        series.of(scene)  # refuses
    friction = series.friction(scene.units.normal_stress if scene.units else 1.0)
    known = schedule_of(scene)
    times = series["time"] if not series.is_own or scene.units is None else series["time"] * sizes(scene)[0]
    notes = list(series.notes)
    if known.is_constant and "load_point_displacement" in series:
        moved = series["load_point_displacement"] * (scene.units.memory_length if series.is_own and scene.units else 1.0)
        found = followed(times, moved)
        times, known = times - times[0], found._replace(times=tuple(t - times[0] for t in found.times))
        notes.append(f"the load point moves as in the file: {_told(known)}")
    if times[0] < 0.0:
        raise SceneError(f"{series.source!r}: time begins at {times[0]:g}: the scene starts at 0")
    if known.is_constant:
        return stick_slip(series.source, times, friction, known, notes)
    bends = float(np.median(np.abs(np.diff(friction, 2)))) / (0.6745 * 6.0**0.5)
    weight = 1.0 / bends if bends > 0.0 else 1.0
    return Experiment(series.source, times, friction, travelled(known, times), known, tuple(notes), weight)


def stick_slip(name: str, times: Array, friction: Array, schedule: Schedule, notes: list[str]) -> Experiment:
    """The mean cycle of a record at one velocity. Raises SceneError if it has no slip events."""
    cycle = mean_cycle(name, times, friction)
    values, errors = (np.append(a, b) for a, b in ((cycle.period, cycle.friction), (cycle.period_error, cycle.friction_error)))
    where = np.append(0.0, phases()) * cycle.period
    told = f"{cycle.events} slip events: period {cycle.period:.6g}, fall of friction {cycle.drop:.4g}"
    travel = where * schedule.velocities[0]
    return Experiment(name, where, values, travel, schedule, (*notes, told), 1.0 / errors, cycle)


def travelled(schedule: Schedule, times: Array) -> Array:
    """Displacement of the load point since the first knot."""
    return Drive(*schedule).travel(times)


def followed(times: Array, moved: Array) -> Schedule:
    """The velocity of a load point that `moved`, in steps: straight lines as few as the noise allows, which meet."""
    jumps = moved[2:] - moved[1:-1] - (moved[1:-1] - moved[:-2]) * np.diff(times)[1:] / np.diff(times)[:-1]
    noise = max(float(np.median(np.abs(jumps))) / (0.6745 * 6.0**0.5), 1e-9 * float(np.ptp(moved)))
    cuts = _merged(times, moved, _cuts(times, moved, noise), noise)
    lines = [np.polyfit(times[a : b + 1], moved[a : b + 1], 1) for a, b in pairwise(cuts)]
    fastest = max(abs(slope) for slope, _ in lines)
    knots, paces = [float(times[0])], [_pace(lines[0][0], fastest)]
    for before, after in pairwise(lines):
        if abs(after[0] - before[0]) < _REST * fastest:
            continue
        meet = float((after[1] - before[1]) / (before[0] - after[0]))
        knots += [min(max(meet, knots[-1]), float(times[-1]))] * 2
        paces += [paces[-1], _pace(after[0], fastest)]
    return Schedule((*knots, float(times[-1])), (*paces, paces[-1]))


def _pace(slope: float, fastest: float) -> float:
    return 0.0 if abs(slope) < _REST * fastest else float(slope)


def _cuts(times: Array, moved: Array, noise: float) -> list[int]:
    """Samples at which the motion bends."""
    cuts, waiting = {0, times.size - 1}, [(0, times.size - 1)]
    while waiting and len(cuts) < _MOST_KNOTS:
        begin, end = waiting.pop()
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
        left(a, c) - one - other for (a, c), (one, other) in zip(zip(cuts, cuts[2:], strict=False), pairwise(parts), strict=False)
    ]
    while gains and min(gains) < _WORTH * noise**2:
        k = int(np.argmin(gains))
        parts[k : k + 2] = [left(cuts[k], cuts[k + 2])]
        del cuts[k + 1], gains[k]
        for m in (k - 1, k):
            if 0 <= m < len(gains):
                gains[m] = left(cuts[m], cuts[m + 2]) - parts[m] - parts[m + 1]
    return cuts


def _told(schedule: Schedule) -> str:
    paces = [schedule.velocities[0], *schedule.velocities[2::2]]
    shown = ", ".join(f"{pace:.4g}" for pace in paces[:6])
    return f"{len(schedule.times) // 2} velocities, {shown}{', ...' if len(paces) > 6 else ''}"
