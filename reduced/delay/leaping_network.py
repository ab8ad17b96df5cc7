"""The delay system of any lossless slabs with leaps over slow motion: holds, loading, quasi-steady sliding, sticks.

In such motion v hardly changes in a round trip, but the waves of the last change stay trapped in the slabs and the mass of an
outer face oscillates: a march needs as many steps as in an event. A leap splits the motion into

    slow   quasi-static response to the slip rate (`slow_motion`): one step of collocation over the whole leap;
    rest   too small for the curvature of friction, hence linear (`frozen_step`): a power of the matrix of one step;

What the split misses in a step, mainly the square of the rest, is measured: some steps are marched before the leap and compared
with the prediction of both parts. This drift goes on in the leap at the same rate, carried along like the rest. Steps after the
leap give the drift there, and the memory is corrected as if the drift had changed exponentially between. A part of the correction
is the estimated error.
"""

import math
from functools import cache
from typing import NamedTuple, TypeAlias

import numpy as np

from reduced.delay.frozen_step import Disturbance, Friction, FrozenStep, advanced, mean_friction, powers_of, slow_parts
from reduced.delay.march import DelayMemory, present
from reduced.delay.network_kernel import lines_with
from reduced.delay.slow_motion import SlowMotion, SlowStep
from reduced.delay.stroboscopic import StroboscopicNetwork
from reduced.delay.transmission_lines import COINCIDENT, Lines
from slipwave.friction import respond
from slipwave.observe.pieces import SAME, Array, Pieces, empty_pieces
from slipwave.scene import Scene
from slipwave.scene.drive import NUDGE_CENTRE, NUDGE_REACH
from slipwave.solve import State, tables, whole_numbers
from slipwave.step.collocation import radau
from slipwave.step.nodal import ELASTIC, PSI, TIME, constant_guess

_SHARE = 0.03  # of the tolerance: error of a leap; a protocol has some hundred leaps
_PRICE, _PRICE_OF_POWERS = 5000.0, 0.0015  # steps of the march that take as long as a leap; more for n entries, times n^3
_LARGEST = 800  # entries of a state; with more, powers cost more than they save
_FIRST, _LONGEST = 1 << 14, 1 << 26  # steps of a leap
_FAR = 1 << 18  # steps of a leap that takes less time than leaps over blocks, if these are possible
_SHRINK, _SAFETY, _GROW = 0.2, 0.8, 3.0
_SETTLES = 500.0  # steps of an average, times the phase of the slowest resonance in one of them
_PAUSE, _LONGEST_PAUSE = 1024, 1 << 16  # transits marched before the next try to leap; doubled by a try that fails late
_CHECKED = 8.0  # times the root of a leap's steps: steps that are marched before it and after it, to check it
_CUTS, _LOOKS = 16, 65  # pieces of a leap or of its check; moments at which its extrema are looked for
_CORRECTED = 0.2  # of a leap's correction: error that it may leave
_ORDER = 8.0  # with which the highest coefficient of a slow step grows
_NEWTON = 1e-5  # of the tolerance: what Newton's method leaves adds up, to 3e-7 in 1e5 steps if it is 1e-9
_RISING = 10.0  # times the tolerance: waves that pieces of a leap lack where v rises above V
_NEGLIGIBLE = 1e-3  # of the allowed error
_MOST_SPLITS, _NUDGES = 8, 1e-5  # steps by the first slopes that take the motion apart; changes of ln v and psi for their slopes


class _Split(NamedTuple):
    """The split of the motion at one time: the slow step, y at its beginning, and the `rest` of the memory."""

    slow: SlowStep
    y: float
    rest: Array


_Check: TypeAlias = tuple[Pieces, Array, float]
"""Some marched steps: their pieces; the drift, what both parts of the motion miss in a step, as a change of the memory; and the
ripple, the largest difference of z from the slow motion."""


class LeapingNetwork(StroboscopicNetwork):
    """`DelayNetwork`, to its `tolerance`, as a `Leaping` solver.

    V is constant in a leap. Its pieces are those of the slow motion; where waves change z by more than the tolerance, z, mu and y
    have no extremum in them. `skipped` counts the transits not marched. Steps are shortened
    to end at a jump of V.
    """

    def __init__(self, scene: Scene, tolerance: float = 1e-9, lines: Lines | None = None) -> None:
        super().__init__(scene, tolerance, lines=lines)
        self._tolerance, self._allowed = tolerance, _SHARE * tolerance
        self._limits_of_breaks = self._limits
        self._limits = self._limits._replace(newton=max(_NEWTON * tolerance, 1e-14))
        self._reach, self._pause = _FIRST, _PAUSE
        self._next_try = float(NUDGE_CENTRE + NUDGE_REACH) if scene.forcing.nudge else 0.0
        self._motion: SlowMotion | None = None  # they are made when they are needed

    def advance(self, until: float) -> Pieces:
        """March to the first end of a step at or beyond `until`, but at most one chunk; see `Solver`."""
        knot, length = self._next_kink(), self._length
        away = (knot - self._origin) / length
        if math.isinf(knot) or abs(away - round(away)) < COINCIDENT * max(1.0, away):
            return super().advance(min(until, knot))
        if knot - self.time > 2.0 * length:
            return super().advance(min(until, knot - 2.0 * length))
        return self._meet(knot)

    def leap(self, until: float, end: float, gaps: bool) -> Pieces:
        """As `Leaping`."""
        if self.time >= self._next_try - SAME:
            stop = min(end, self._next_kink())
            pieces = self._over_blocks(stop, self._allowed) if gaps and self._reach < _FAR else None
            self._pause = self._pause if pieces is None else _PAUSE
            if pieces is None:
                pieces = self._leap(stop, gaps)
            if pieces is not None:
                return pieces
            kink, self._next_try = self._next_kink(), self.time + self._pause  # the next try lies at most at the next kink of V
            if kink <= self._next_try:
                self._next_try, self._pause, self._reach = kink, _PAUSE, _FIRST
        return self.advance(min(until, self._next_try))

    def state(self) -> State:
        """As `DelayNetwork`, and `leaps`: steps of the next leap, pause (transits) after one that fails; `tries`: transits
        skipped, time of the next try."""
        return super().state() | self._state_of_leaps()

    def _state_of_leaps(self) -> State:
        return {"leaps": np.array([self._reach, self._pause], dtype=float), "tries": np.array([self.skipped, self._next_try])}

    def restore(self, state: State) -> None:
        """As `Solver`."""
        leaps = self._leaps_of(state)
        super().restore(state)
        self._restore_leaps(leaps)

    def _leaps_of(self, state: State) -> tuple[int, int, float, float]:
        """What `_state_of_leaps` has written, checked."""
        reach, pause = whole_numbers(state, "leaps", (1, 1))
        skipped, next_try = (float(value) for value in tables(state, {"tries": (2,)}, self.model)["tries"])
        return reach, pause, skipped, next_try

    def _restore_leaps(self, leaps: tuple[int, int, float, float]) -> None:
        self._reach, self._pause, self.skipped, self._next_try = leaps
        self._forget_steps()

    def _next_kink(self) -> float:
        """The next time (transits) at which V has a kink; infinite if there is none."""
        return self.scene.drive.knot_after(self.time + SAME)

    def _meet(self, knot: float) -> Pieces:
        """March to a `knot` within a step by one or two shorter steps; the grid of steps restarts there."""
        before, start = self._moment(), self.time
        count = max(1, math.ceil((knot - start) / self._length - COINCIDENT))
        short, pieces = (knot - start) / count, empty_pieces(count, self._stages)
        self._resample(self._length, short)
        self._origin, self._done = start, 0
        steps, verdict = self._march(short, pieces)
        if steps < count:
            self._return_to(before)
            self._refine(verdict)
            return self.advance(knot)
        self._resample(short, self._length)
        self._origin, self._done = knot, 0
        self._memory.now[TIME] = knot
        return pieces

    def _refine(self, verdict: int) -> None:
        super()._refine(verdict)
        self._forget_steps()

    def _leap(self, stop: float, gaps: bool) -> Pieces | None:
        """The pieces of a leap that ends before `stop`, with some steps before and after it; None if no leap saves time: then
        only the length of the next one has changed."""
        size, left = self._lines.waves.size + self._lines.tops.size + 2, int((stop - self.time) / self._length - COINCIDENT)
        least = int(_PRICE + _PRICE_OF_POWERS * size**3)
        count = min(max(least, self._reach), left - self._checked(left))
        if size > _LARGEST or count < least or any(top.has_dead_load for top in self._layers.tops):
            return None
        while count >= least:
            pieces, scale = self._cross(count, gaps)
            if scale == 0.0:
                return None
            if pieces is not None:
                self._reach, self._pause = max(least, min(_LONGEST, int(max(count * scale, self._reach)))), _PAUSE
                return pieces
            count = self._reach = int(count * scale)
        self._reach = least
        return None

    def _cross(self, count: int, gaps: bool) -> tuple[Pieces | None, float]:
        """Leap `count` steps: its pieces (None if it fails), and the ratio of the next leap's length to this one's, 0 if none is
        possible now."""
        before = self._moment()
        split = self._split(count * self._length)
        ahead = self._check(split, count) if split else None
        scale = 0.25
        if split:
            self._pause = min(2 * self._pause, _LONGEST_PAUSE)
        if split and ahead:
            if ahead[2] <= self._tolerance or gaps:
                pieces, scale = self._beyond(split, ahead, count)
                if pieces is not None:
                    return pieces, scale
            else:
                scale = 0.0
        self._return_to(before)
        return None, scale

    def _beyond(self, split: _Split, ahead: _Check, count: int) -> tuple[Pieces | None, float]:
        """As `_cross`, after the checked steps `ahead`, the first of `count`."""
        (before, drift, ripple), slow, begin = ahead, split.slow, self.time
        steps = count - before.time.size
        end = self._origin + (self._done + steps) * self._length
        fill = self._fill(split, np.linspace(begin, end, _CUTS + 1))
        rises = fill.z[-1, -1] > max(fill.z[0, 0], self._stick_limit(begin))  # an event may begin, which must not be left out
        visible = self._tolerance * (_RISING if rises else 1.0)
        if ripple > visible and (rises or not self._is_monotonic(split, begin, end)):
            return None, 0.5
        rest = self._now().vector - self._composed(split, begin).vector
        later, spread = self._carried(slow, np.column_stack([rest, drift]), begin, end, steps)
        split = split._replace(rest=later[:, 0] + steps * later[:, 1])
        self._jump_to(split, end, steps)
        behind, friction = self._check(split, count), self._friction(slow, end, end)
        if behind is None:
            return None, _SHRINK
        after, drift, ripple = behind
        # the drift changes exponentially from the first size to the last: `share` is the weight of the last in its mean
        first, last = (max(self._size(change, friction.mu_z), 1e-300) for change in (later[:, 1], drift))
        fall = math.log(first / last)
        share = 0.5 + fall / 12.0 if abs(fall) < 0.01 else 1.0 / -math.expm1(-fall) - 1.0 / fall
        missed = share * steps * (drift - later[:, 1])
        error = max(_CORRECTED * self._size(missed, friction.mu_z), spread)
        if error > self._allowed or (rises and ripple > visible):
            return None, min(0.5, self._scale(slow, error))
        marched = after.time.size
        powers = powers_of(self._parts()[1].matrix(self._friction(slow, end, self.time))[0], marched)
        self._take(self._now().vector + advanced(powers, missed, marched))
        self.skipped += end - begin
        return Pieces.joined((before, fill, after)), self._scale(slow, error)

    def _split(self, length: float) -> _Split | None:
        """The split of the present motion for a leap of `length` (transits); None if the slow part is not smooth enough. Slow
        parts of psi and of the interface's stress are their averages over so many steps of the frozen motion that oscillations
        cancel. The slow step begins with the psi and the load for which these averages of the rest vanish."""
        (motion, frozen), now = self._parts(), self._now()
        start, (psi, y) = self.time, now.rest
        stages, unknown = self._stages, float(self._memory.guess.z[0])
        _, _, stress, friction_z, *_ = respond(self.scene.law, unknown, psi)
        begin = np.array([psi, (stress - self.scene.steady_stress) / motion.to_stress[0]])
        slow = motion.step(start, length, begin, constant_guess(psi, unknown, stages))
        if not slow.solved:
            return None
        matrix, by_rest = frozen.matrix(self._friction(slow, start, start))
        rows = np.zeros((2, frozen.size))
        rows[0, -2], rows[1] = 1.0, radau(stages).integral[-1] @ by_rest / friction_z
        rows = slow_parts(powers_of(matrix, int(_SETTLES / (self._length * motion.radius))), rows)

        def rest(slow: SlowStep) -> Array:
            return now.vector - self._composed(_Split(slow, y, now.vector), start).vector

        steps = np.diag([_NUDGES, _NUDGES * friction_z / abs(motion.to_stress[0])])
        left = rest(slow)
        nearby = [rest(motion.step(start, length, begin + step, slow.guess)) - left for step in steps]
        slopes = rows @ np.column_stack(nearby) / steps.diagonal()
        for _ in range(_MOST_SPLITS):
            if np.abs(rows @ left).max() < _NEGLIGIBLE * self._allowed:
                return _Split(slow, y, left)
            begin = begin - np.linalg.solve(slopes, rows @ left)
            slow = motion.step(start, length, begin, slow.guess)
            if not slow.solved:
                return None
            left = rest(slow)
        return None

    def _checked(self, count: int) -> int:
        """Number of steps that are marched before and after a leap of `count`: so many that what hardly grows with them, rounding
        and small ripples of waves, is no error of the leap."""
        return int(max(self._lines.waves.shape[2], _CHECKED * math.sqrt(count)))

    def _check(self, split: _Split, count: int) -> _Check | None:
        """March some steps of the motion with this `split`, to check a leap of `count` steps; None if that fails."""
        motion, frozen = self._parts()
        steps, start = self._checked(count), self.time
        matrix, _ = frozen.matrix(self._friction(split.slow, start, start + steps * self._length))
        expected = advanced(powers_of(matrix, steps), split.rest, steps)
        pieces = empty_pieces(steps, self._stages)
        done, _ = self._march(self._length, pieces)
        if done < steps:
            return None
        miss = self._now().vector - self._composed(split, self.time).vector - expected
        times, looks = pieces.time[:, None] + pieces.length[:, None] * self.nodes, np.linspace(start, self.time, self._stages)
        smooth = np.polynomial.Polynomial.fit(looks, motion.interface(split.slow, looks).z, self._stages - 1)
        ripple = np.abs(pieces.z - smooth(times)).max()
        drift = miss / steps
        if ripple <= self._tolerance and abs(drift[-2]) < np.spacing(abs(self._memory.now[PSI])):
            drift[-2] = 0.0  # rounding: a march's psi stops where it changes by less in a step
        return pieces, drift, float(ripple)

    def _carried(self, slow: SlowStep, rest: Array, begin: float, end: float, steps: int) -> tuple[Array, float]:
        """The `rest` (n, 2) of the memory and its drift after `steps` steps, and the change of the rest if friction is averaged
        over all of them instead of over each half."""
        frozen, parts = self._parts()[1], (steps // 2, steps - steps // 2)
        middle, later, friction = begin + parts[0] * self._length, rest, self._friction(slow, begin, end)
        if self._size(np.abs(rest) @ [1.0, steps], friction.mu_z) < _NEGLIGIBLE * self._allowed:
            return rest, 0.0
        for count, (first, last) in zip(parts, ((begin, middle), (middle, end)), strict=True):
            later = advanced(powers_of(frozen.matrix(self._friction(slow, first, last))[0], count), later, count)
        other = advanced(powers_of(frozen.matrix(friction)[0], steps), rest[:, 0], steps)
        return later, self._size(later[:, 0] - other, friction.mu_z)

    def _jump_to(self, split: _Split, time: float, steps: int) -> None:
        """Set the state `steps` later, at `time`, from its `split`."""
        self._take(self._composed(split, time).vector + split.rest)
        self._done += steps
        unknown, (_, psi, y) = float(self._parts()[0].interface(split.slow, np.array(time)).z), self._memory.now[: ELASTIC + 1]
        self._memory = DelayMemory(constant_guess(psi, unknown, self._stages), present(time, psi, y))

    def _take(self, vector: Array) -> None:
        """Make `vector` (n,) the present memory."""
        waves, tops, self._memory.now[[PSI, ELASTIC]] = self._frozen_step().empty.like(vector)
        self._lines = lines_with(self._lines.network, waves.copy(), tops.copy())

    def _parts(self) -> tuple[SlowMotion, FrozenStep]:
        """The solvers of both parts of the motion."""
        self._motion = self._motion or SlowMotion(self.scene, self._layers, self._stages, self._limits)
        return self._motion, self._frozen_step()

    def _composed(self, split: _Split, time: float) -> Disturbance:
        """The memory at a `time` of the slow motion alone."""
        motion, frozen = self._parts()
        ring = frozen.empty.waves.shape[2]
        times = time + self._length * (np.arange(-ring, 0)[:, None] + self.nodes)
        psi = float(motion.interface(split.slow, np.array(time)).psi)
        waves, tops, slip = motion.memory(split.slow, times, time)
        return Disturbance(waves, tops, np.array([psi, split.y - self.scene.stiffness * slip]))

    def _friction(self, slow: SlowStep, begin: float, end: float) -> Friction:
        """Mean of `Friction` from `begin` to `end`; its value at `begin` if they are equal."""
        points, weights = _gauss(self._stages if end > begin else 1)
        interface = self._parts()[0].interface(slow, begin + 0.5 * (end - begin) * (1.0 + points))
        return mean_friction(self.scene.law, interface, 0.5 * weights)

    def _fill(self, split: _Split, ends: Array) -> Pieces:
        """The slow motion between `ends` as pieces."""
        motion, slow, lengths = self._parts()[0], split.slow, np.diff(ends)
        times = ends[:-1, None] + lengths[:, None] * self.nodes
        psi, z = motion.interface(slow, times)
        y = split.y - self.scene.stiffness * motion.slip(slow, times)
        return Pieces(ends[:-1].copy(), lengths, z, psi, motion.stress(slow, times), y)

    def _is_monotonic(self, split: _Split, begin: float, end: float) -> bool:
        """Whether neither z nor mu nor y of the slow motion has an extremum between two times."""
        fill = self._fill(split, np.linspace(begin, end, _LOOKS))
        changes = [np.diff(values[:, 0]) for values in (fill.z, fill.mu, fill.y)]
        return all(bool((change >= 0.0).all() or (change <= 0.0).all()) for change in changes)

    def _scale(self, slow: SlowStep, error: float) -> float:
        """Ratio of the next leap's length to that of the step `slow`, which has this `error`."""
        smooth = (self._limits.resolution / max(slow.tail, 1e-300)) ** (1.0 / _ORDER)
        return float(min(_GROW, max(_SHRINK, _SAFETY * min(smooth, math.sqrt(self._allowed / max(error, 1e-300))))))


_gauss = cache(np.polynomial.legendre.leggauss)
