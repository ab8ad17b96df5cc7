"""Measures the stages of a laboratory protocol during a run: memory does not grow with the run. Stages are the stretches between
the knots of the drive:

    start   the sliding before anything changes
    step    V jumps from one velocity to another and stays
    hold    V is 0
    slide   V is positive again after a hold
    ramp    V changes throughout
    level   V stays at the end of a ramp

A stage has settled if it ends within the run and, in its last tenth, the slip rate is within 1 % of V. It stick-slips if it has
not settled and the slip rate changes by more than a factor e in its third quarter and in its last, there as much as before: a
ringing that decays changes less, and before its friction has fallen from a peak a step or a slide does not. The last stage ends
with the run, wherever that is. Figures that need a settled stage are None where it has not settled, those of a peak where
friction may still rise; all are None where it stick-slips.
"""

import math
from bisect import bisect_right
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np

from slipwave.friction import rates, respond, steady_state, unknown_of
from slipwave.observe.pieces import Array, Pieces, interpolation_matrix, lagrange_basis, slack
from slipwave.scene import Scene
from slipwave.scene.drive import Drive

StageKind: TypeAlias = Literal["start", "step", "hold", "slide", "ramp", "level"]

LATE = 0.1
"""The share of a stage, at its end, in which it must be steady to have settled."""

STEADY = 0.01
"""Largest |ln(v/V)| there."""

_STICKS = 1.0  # range of ln v in both later quarters of a stage that stick-slips
_LASTS = 0.9  # that of the last quarter, over that of the third

_POINTS, _MORE_POINTS = 33, 257  # of a piece, its ends included; of one longer than _LONG
_LONG = 2.0  # transits
_BETWEEN = 0.1  # of the range of its nodal values: so far above these a piece may rise between its nodes
_AT_ONCE, _LONG_AT_ONCE = 256, 8  # pieces that are searched for a peak
_PARTS = 1024  # of the time since the last stage began: its quarters end within half of one
_SHORTEST = 2.0**-20  # transits
_FALLEN = 0.01  # of its rise to the peak: a stress that has fallen less may still rise
_NEAR = 1.2  # nodes this close to the stress that is looked for: it may lie between them


class Stage(NamedTuple):
    """A stretch of the drive from `start` to `end` (transits); V (in V*) `before` it, and at its end."""

    kind: StageKind
    start: float
    end: float
    before: float
    velocity: float

    @property
    def sign(self) -> float:
        """1 if friction first rises in the stage, -1 if it falls: the sign of the change of V, by the direct effect."""
        return 1.0 if self.velocity >= self.before else -1.0


class _Measured(NamedTuple):
    """Measured in a stage so far: friction stress just `before` it, at its `peak` (the lowest where friction falls first) and
    `last`; slip in L since the stage began, `peak_slip` at the peak and `recovered` where the stress had recovered (NaN: not
    yet); the lowest and highest ln v in its third and fourth quarter and in the last tenth; the time reached (transits)."""

    before: float = math.nan
    peak: float = math.nan
    last: float = math.nan
    peak_slip: float = math.nan
    recovered: float = math.nan
    third: tuple[float, float] = (math.inf, -math.inf)
    fourth: tuple[float, float] = (math.inf, -math.inf)
    late: tuple[float, float] = (math.inf, -math.inf)
    reached: float = -math.inf


@dataclass(frozen=True)
class StageFigures:
    """A stage and its figures, stresses in units of the normal stress, slip in L; None where there is no value.

    `steady_stress`: friction at the end of a settled stage. `direct_effect`: peak minus the stress before the step; `evolution`:
    peak minus the new steady stress (a ln(V2/V1) and b ln(V2/V1) of a stiff loading; both negative where V falls).
    `slip_to_recovery`: slip from the peak until 1/e of that is left. `relaxation`: the stress before a hold minus that at its
    end. `healing`: the peak after a hold minus the stress before it.
    """

    kind: StageKind
    start: float
    end: float
    velocity: float
    steady_stress: float | None = None
    direct_effect: float | None = None
    evolution: float | None = None
    slip_to_recovery: float | None = None
    relaxation: float | None = None
    healing: float | None = None
    stick_slips: bool = False


def stages_of(drive: Drive, until: float) -> list[Stage]:
    """The stages of a run to `until` (transits); none if V never changes."""
    if drive.is_constant:
        return []
    knots = [(0.0, drive.initial), *zip(drive.times, drive.velocities, strict=True), (until, drive.velocities[-1])]
    stages: list[Stage] = []
    for (start, first), (end, last) in pairwise(knots):
        if start < min(end, until):
            reached = last if end <= until else first + (last - first) * (until - start) / (end - start)
            _append(stages, start, min(end, until), first, reached)
    return stages


def _append(stages: list[Stage], start: float, end: float, first: float, last: float) -> None:
    """Add a straight stretch of V; a stretch that continues the last stage prolongs it."""
    before = stages[-1].velocity if stages else first
    if first != last:
        stages.append(Stage("ramp", start, end, before, last))
    elif stages and stages[-1].kind != "ramp" and before == last:
        stages[-1] = stages[-1]._replace(end=end)
    else:
        stages.append(Stage(_kind_of(stages, before, last), start, end, before, last))


def _kind_of(stages: list[Stage], before: float, velocity: float) -> StageKind:
    if velocity == 0.0:
        return "hold"
    if not stages:
        return "start"
    if before == 0.0:
        return "slide"
    return "level" if stages[-1].kind == "ramp" and before == velocity else "step"


def _figures(stage: Stage, seen: _Measured, earlier: StageFigures | None, before_hold: float) -> StageFigures:
    is_over = seen.reached >= stage.end - slack(stage.end)
    slides = stage.velocity > 0.0 and stage.kind != "ramp"  # at one velocity
    settled = slides and is_over and max(abs(ln_v - math.log(stage.velocity)) for ln_v in seen.late) < STEADY
    facts = StageFigures(stage.kind, stage.start, stage.end, stage.velocity)
    if seen.reached == -math.inf:
        return facts
    fallen = stage.sign * (seen.peak - seen.last) > _FALLEN * stage.sign * (seen.peak - seen.before)
    peaked = settled or fallen  # else friction may still rise
    third, fourth = (high - low for low, high in (seen.third, seen.fourth))  # -inf without values
    sticks = slides and not settled and min(third, fourth) > _STICKS and fourth >= _LASTS * third
    if sticks and (fallen or math.isnan(seen.peak)):
        return replace(facts, stick_slips=True)
    numbers: dict[str, Any] = {"steady_stress": seen.last} if settled else {}
    was_steady = earlier is not None and earlier.steady_stress is not None
    if stage.kind == "hold" and was_steady:
        numbers["relaxation"] = seen.before - seen.last
    if stage.kind == "slide" and earlier is not None and earlier.relaxation is not None and peaked:
        numbers["healing"] = seen.peak - before_hold
    if stage.kind == "step" and was_steady and peaked:
        numbers["direct_effect"] = seen.peak - seen.before
        if settled:
            numbers["evolution"] = seen.peak - seen.last
    if stage.kind in ("step", "slide") and not math.isnan(seen.recovered - seen.peak_slip):
        numbers["slip_to_recovery"] = seen.recovered - seen.peak_slip
    return replace(facts, **numbers)


_LEFT = math.exp(-1.0)
"""Share of the peak's height over the steady stress at which the stress counts as recovered."""


class _Course:
    """The lowest and highest rate unknown in each of some equal parts of the time since a stage began, whose end may move or be
    unknown: where all parts are used, 2, 4, 8 ... are joined."""

    def __init__(self) -> None:
        self._length, self._lowest, self._highest = _SHORTEST, np.full(_PARTS, math.inf), np.full(_PARTS, -math.inf)

    def take(self, since: Array, z: Array) -> None:
        """Take the rate unknowns `z` at rising times `since` the stage began (transits)."""
        if since[-1] >= _PARTS * self._length:
            longer = 2 ** math.frexp(since[-1] / (_PARTS * self._length))[1]
            joined = min(longer, _PARTS)
            unused = np.full(_PARTS - _PARTS // joined, math.inf)
            self._lowest = np.append(self._lowest.reshape(-1, joined).min(axis=1), unused)
            self._highest = np.append(self._highest.reshape(-1, joined).max(axis=1), -unused)
            self._length *= longer
        ends = np.maximum(since[[0, -1]], 0.0) // self._length
        parts = np.arange(int(ends[0]), int(ends[1]) + 1)
        begins = np.append(0, np.searchsorted(since, parts[1:] * self._length))
        filled = np.diff(begins, append=since.size) > 0
        here, first = parts[filled], begins[filled]
        self._lowest[here] = np.minimum(self._lowest[here], np.minimum.reduceat(z, first))
        self._highest[here] = np.maximum(self._highest[here], np.maximum.reduceat(z, first))

    def between(self, begin: float, end: float) -> Array:
        """The lowest and highest unknowns of all parts from `begin` to `end`, times since the stage began."""
        here = slice(*(round(min(time / self._length, _PARTS)) for time in (begin, end)))
        known = self._lowest[here] <= self._highest[here]
        return np.concatenate([self._lowest[here][known], self._highest[here][known]])

    def state(self) -> dict[str, Array]:
        """For a checkpoint."""
        return {"part_length": np.array([self._length]), "parts": np.stack([self._lowest, self._highest])}

    def restore(self, state: dict[str, Array]) -> None:
        """Continue from what `state` returned."""
        self._length = float(state["part_length"][0])
        self._lowest, self._highest = state["parts"].copy()


Sampling: TypeAlias = tuple[Array, Array, Array]
"""Points of a piece; rows that evaluate its polynomial there; rows that integrate it from 0 to each point."""


class ProtocolObserver:
    """Reads the pieces of a run of `scene` to `until` (transits)."""

    def __init__(self, scene: Scene, nodes: Array, until: float) -> None:
        self._scene = scene
        self.stages = stages_of(scene.drive, until)
        self._seen = [_Measured() for _ in self.stages]
        self._course = _Course()  # of the last stage, which ends with the run
        self._slip, self._last, self._now = 0.0, math.nan, 0  # `_now`: the first stage that is not over
        # pieces of a grid hold equal steps and are not cut at jumps of V: between their nodes they would overshoot
        self._nodes, self._cut = nodes, nodes[0] > 0.0
        own = tuple(nodes.tolist())
        self._own, self._whole = _sampling(own, own), _sampling(own, (1.0,))[2][0]
        self._fine, self._finer = (_sampling(own, tuple(np.linspace(0.0, 1.0, n).tolist())) for n in (_POINTS, _MORE_POINTS))

    @property
    def whole_from(self) -> float:
        """As `Spanning`; infinite but at the beginning of a stage and from the steady stress over a peak to the recovery from it,
        over which slip is summed."""
        if self._now == len(self.stages):
            return 0.0
        stage, seen = self.stages[self._now], self._seen[self._now]
        above = stage.sign * (seen.last - self._steady(stage)) > 0.0  # at its peak friction may rest: a gap would hold it
        recovers = above and math.isnan(seen.recovered) and not math.isnan(seen.peak_slip)
        return math.inf if -math.inf < seen.reached < stage.end and not recovers else 0.0

    @property
    def figures(self) -> list[StageFigures]:
        """The figures of the stages that the run has begun. A stage shorter than a step of the run, which lies in none, has no
        figures."""
        figures: list[StageFigures] = []
        begun = max((k + 1 for k, here in enumerate(self._seen) if here.reached > -math.inf), default=0)
        for k, (stage, seen) in enumerate(zip(self.stages[:begun], self._seen, strict=False)):
            earlier, before_hold = (figures[k - 1], self._seen[k - 1].before) if k else (None, math.nan)
            if stage is self.stages[-1]:
                stage, seen = self._until_now(stage, seen)
            figures.append(_figures(stage, seen, earlier, before_hold))
        return figures

    def _until_now(self, stage: Stage, seen: _Measured) -> tuple[Stage, _Measured]:
        """The last stage, which ends here if the length of the run was not given, and what was measured in it, with the ranges of
        ln v in its later parts."""
        stage = stage._replace(end=seen.reached) if stage.end == math.inf else stage
        lasts = stage.end - stage.start
        third, fourth, late = (
            self._extended(_Measured().late, self._course.between(begin * lasts, end * lasts))
            for begin, end in ((0.5, 0.75), (0.75, math.inf), (1.0 - LATE, math.inf))
        )
        return stage, seen._replace(third=third, fourth=fourth, late=late)

    def scan(self, pieces: Pieces) -> None:
        """Take the next pieces of the run, in order. Figures are the same to the bit, however many come at once."""
        if not self.stages or not pieces.time.size:
            return
        count = self._nodes.size
        time, mu = (pieces.time[:, None] + pieces.length[:, None] * self._nodes).ravel(), pieces.mu.ravel()
        middle = pieces.time + 0.5 * pieces.length
        now = float(pieces.time[-1] + pieces.length[-1])
        begun_by_now = bisect_right(self.stages, now, key=lambda stage: stage.start)
        for k, stage in enumerate(self.stages[self._now : begun_by_now], self._now):
            first, end = count * np.searchsorted(middle, stage[1:3]) if self._cut else np.searchsorted(time, stage[1:3])
            inside = slice(first, min(end, np.searchsorted(time, stage.end + slack(stage.end), "right")))
            if first < inside.stop:
                reached = self._seen[k].reached
                self._take(k, stage, time[inside], mu[inside], pieces.z.ravel()[inside], min(now, stage.end))
                if stage.kind in ("step", "slide"):
                    self._follow(k, stage, pieces, inside, reached)
            elif self._seen[k].reached > -math.inf:
                self._seen[k] = self._seen[k]._replace(reached=min(now, stage.end))
        while self._now < len(self.stages) and self.stages[self._now].end <= now:
            self._now += 1

    def _follow(self, k: int, stage: Stage, pieces: Pieces, inside: slice, reached: float) -> None:
        """Add the slip in a stage, `reached` so far, whose nodes are those `inside` the `pieces`, and look for its peak and the
        recovery. The slip between them is not known where a gap lies there."""
        count = self._nodes.size
        pieces = pieces.part(slice(inside.start // count, -(-inside.stop // count)))
        gained = self._scene.transit * pieces.length * np.add.reduce(self._whole * rates(self._scene.law, pieces.z), axis=1)
        begun = np.cumsum(np.append(self._slip, gained))
        if self._cut:
            self._look_for_peaks(k, stage, pieces, begun)
        else:
            stress, slip = (values.ravel()[inside.start % count :] for values in self._sampled(self._own, pieces, begun[:-1]))
            taken = slice(inside.stop - inside.start)
            self._seen[k] = _peak(self._seen[k], stage.sign, self._steady(stage), stress[taken], slip[taken])
        before = np.append(max(reached, stage.start), (pieces.time + pieces.length)[:-1])
        at_gaps, seen = begun[:-1][pieces.time > before + slack(stage.end)], self._seen[k]
        if ((at_gaps >= seen.peak_slip) & ~(at_gaps >= seen.recovered)).any():
            self._seen[k] = seen._replace(peak_slip=math.nan)
        self._slip = float(begun[-1])

    def _sampled(self, sampling: Sampling, pieces: Pieces, begun: Array) -> tuple[Array, Array]:
        """Friction stress and slip at the points of each piece, (k, p); `begun` (k,): the slip at its beginning."""
        gained = self._scene.transit * pieces.length[:, None] * _at(sampling[2], rates(self._scene.law, pieces.z))
        return _at(sampling[1], pieces.mu), gained + begun[:, None]

    def _look_for_peaks(self, k: int, stage: Stage, pieces: Pieces, begun: Array) -> None:
        """Find the peak of a stage and the recovery after it, in those of its `pieces` in which they may lie."""
        count, steady, long = pieces.time.size, self._steady(stage), pieces.length > _LONG
        first, highest, lowest = 0, (stage.sign * pieces.mu).max(axis=1), (stage.sign * pieces.mu).min(axis=1)
        known = highest.max()
        highest, lowest = (1.0 + _BETWEEN) * highest - _BETWEEN * lowest, (1.0 + _BETWEEN) * lowest - _BETWEEN * highest
        if not known <= stage.sign * self._seen[k].peak:  # what lies before a higher peak is forgotten with it
            first = int(np.argmax(~(highest < known)))
        while first < count:
            seen, many = self._seen[k], 1
            may = ~(highest[first:] < stage.sign * seen.peak)
            if math.isnan(seen.recovered):
                near = _NEAR * _LEFT * stage.sign * (seen.peak - steady)
                many = _LONG_AT_ONCE if long[first] else _AT_ONCE
                may |= lowest[first:] - stage.sign * steady <= near
            first = first + int(np.argmax(may)) if may.any() else count
            if first < count:
                alike = np.append(long[first:] != long[first], True)
                these, sampling = (
                    slice(first, first + min(many, int(np.argmax(alike)))),
                    self._finer if long[first] else self._fine,
                )
                mu, slip = (values.ravel() for values in self._sampled(sampling, pieces.part(these), begun[these]))
                points = sampling[0].size
                used = _until_recovered(seen, stage.sign, steady, mu) // points + 1
                self._seen[k] = _peak(seen, stage.sign, steady, mu[: used * points], slip[: used * points], points)
                first += used

    def _take(self, k: int, stage: Stage, time: Array, mu: Array, z: Array, reached: float) -> None:
        """Take the samples of a stage: its last stress, and the ranges of ln v in its later parts."""
        seen = self._seen[k]
        if math.isnan(seen.before):  # the stage begins
            seen, self._slip = seen._replace(before=mu[0] if math.isnan(self._last) else self._last), 0.0
        self._last = float(mu[-1])
        seen = self._seen[k] = seen._replace(last=self._last, reached=reached)
        if stage is self.stages[-1]:
            self._course.take(time - stage.start, z)
            return
        half, last, late = np.searchsorted(time, [stage.end - share * (stage.end - stage.start) for share in (0.5, 0.25, LATE)])
        self._seen[k] = seen._replace(
            third=self._extended(seen.third, z[half:last]),
            fourth=self._extended(seen.fourth, z[last:]),
            late=self._extended(seen.late, z[late:]),
        )

    def _extended(self, ends: tuple[float, float], z: Array) -> tuple[float, float]:
        """A range of ln v, extended to the rate unknowns `z`, with which v rises; -inf where slip rests or reverses."""
        if not z.size:
            return ends
        with np.errstate(divide="ignore"):
            ln_v = np.log(np.maximum(rates(self._scene.law, np.array([z.min(), z.max()])), 0.0))
        return float(ln_v.min(initial=ends[0])), float(ln_v.max(initial=ends[1]))

    def _steady(self, stage: Stage) -> float:
        """Steady stress at the velocity of a stage; NaN in a hold."""
        law, velocity = self._scene.law, stage.velocity
        if velocity == 0.0 or stage.kind not in ("step", "slide"):
            return math.nan
        return float(respond(law, unknown_of(law, velocity), steady_state(law, velocity))[2])

    def state(self) -> dict[str, Array]:
        """What was measured, one row per stage, for a checkpoint."""
        seen = np.array([np.hstack(seen) for seen in self._seen], dtype=float)
        return {"seen": seen, "slip": np.array([self._slip, self._last]), **self._course.state()}

    def restore(self, state: dict[str, Array]) -> None:
        """Continue from what `state` returned. Raises ValueError for the state of a run with another number of stages."""
        rows = state["seen"].tolist()
        if len(rows) != len(self.stages):
            raise ValueError(
                f"it is of a run with {len(rows)} stages of the drive, this one has {len(self.stages)}: a protocol is not "
                "prolonged past a knot; give the whole length from the start"
            )
        self._seen = [_Measured._make([*row[:5], *(tuple(row[k : k + 2]) for k in (5, 7, 9)), row[11]]) for row in rows]
        self._now = sum(seen.reached >= stage.end for stage, seen in zip(self.stages, self._seen, strict=True))
        self._slip, self._last = state["slip"].tolist()
        self._course.restore(state)


def _at(rows: Array, values: Array) -> Array:
    """values @ rows.T, piece by piece: the same to the bit, however many `values` (k, s) come at once."""
    return np.asarray((rows @ values[..., None])[..., 0])


def _until_recovered(seen: _Measured, sign: float, steady: float, mu: Array) -> int:
    """Index in `mu` at which the stress has first recovered from a peak in it or before it; the last index if it has not."""
    known = -math.inf if math.isnan(seen.peak) else sign * seen.peak
    highest = np.maximum.accumulate(np.append(known, sign * mu))[1:]
    height = highest - sign * steady
    back = (height > 0.0) & (sign * (mu - steady) <= _LEFT * height)
    if not math.isnan(seen.recovered):
        back &= highest > known
    return int(np.argmax(back)) if back.any() else mu.size - 1


def _peak(seen: _Measured, sign: float, steady: float, mu: Array, slip: Array, points: int = 1) -> _Measured:
    """`seen` updated by further samples, `points` of each piece: the peak and, after it, the slip at which the stress has
    recovered (`_LEFT`)."""
    highest, first = int(np.argmax(sign * mu)), 0
    if not sign * mu[highest] <= sign * seen.peak:
        peak, peak_slip = _top(sign, mu, slip, highest, points)
        seen, first = seen._replace(peak=peak, peak_slip=peak_slip, recovered=math.nan), highest
    height = sign * (seen.peak - steady)
    if not (math.isnan(seen.recovered) and height > 0.0):
        return seen
    over = sign * (mu - steady) - _LEFT * height
    back = np.flatnonzero(over[first:] <= 0.0)
    if not back.size:
        return seen
    k = max(first + int(back[0]), 1)
    return seen._replace(recovered=_crossing(over, slip, k, points))


def _top(sign: float, mu: Array, slip: Array, k: int, points: int) -> tuple[float, float]:
    """Stress and slip at the top of the parabola through the highest sample, k, and its neighbours in its piece; at the sample
    itself at an end of the piece."""
    if 0 < k % points < points - 1:
        before, here, after = slip[k - 1 : k + 2]
        if before < here < after:
            rise = (mu[k] - mu[k - 1]) / (here - before)
            bend = ((mu[k + 1] - mu[k]) / (after - here) - rise) / (after - before)
            if sign * bend < 0.0:
                top = 0.5 * (before + here - rise / bend)
                return float(mu[k - 1] + (top - before) * (rise + bend * (top - here))), float(top)
    return float(mu[k]), float(slip[k])


def _crossing(over: Array, slip: Array, k: int, points: int) -> float:
    """Slip where `over` falls to 0 between the samples k - 1 and k: by the parabola of slip over `over` through a third sample of
    their piece, if `over` falls there too, else by the chord."""
    before, after = float(over[k - 1]), float(over[k])
    if not before > after:
        return float(slip[k])
    chord = (slip[k] - slip[k - 1]) / (after - before)
    third = k + 1 if (k + 1) // points == k // points else k - 2
    bend = 0.0
    if (k - 1) // points == k // points == third // points and third < over.size and (third - k) * (over[third] - after) < 0.0:
        bend = ((slip[third] - slip[k]) / (over[third] - after) - chord) / (over[third] - before)
    return float(slip[k - 1] - before * chord + before * after * bend)


@lru_cache(maxsize=16)
def _sampling(nodes: tuple[float, ...], points: tuple[float, ...]) -> Sampling:
    basis, abscissae = lagrange_basis(np.array(nodes)), np.array(points)
    gauss, weights = np.polynomial.legendre.leggauss(basis.nodes.size)
    inner = 0.5 * (1.0 + gauss)
    sums = np.stack([0.5 * point * (weights @ interpolation_matrix(basis, point * inner)) for point in points])
    return abscissae, interpolation_matrix(basis, abscissae), sums
