"""Selects the fastest solver of a scene's exact delay system.

Plain slabs of equal round trips leap over the transits of long sticks, and of the slow rise of v after them (`LeapingDelay`).

A stick may last 1e5 transits. The waves of the last event stay trapped in the slabs and modulate the slip rate in every one of
them, so a march needs as many steps in each. But each transit is almost the same as the one before: `multirevolution`.
"""

import math
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from reduced.delay.alike import MOST_FIRST_STEPS, Delay, TransitMesh, first_steps
from reduced.delay.march import EXTREMES, DelayMemory, extremes, present
from reduced.delay.multirevolution import MarchedTransits
from reduced.delay.transmission_lines import NODES, Lines, lines_of
from slipwave.friction import rates, respond
from slipwave.observe.pieces import SAME, Array, Pieces, empty_pieces
from slipwave.scene import Scene
from slipwave.scene.drive import NUDGE_CENTRE, NUDGE_REACH, StartKind
from slipwave.solve import State, tables, whole_numbers
from slipwave.step.nodal import DONE, ELASTIC, PSI, TIME

if TYPE_CHECKING:
    from reduced.delay.network import DelayNetwork


_SHARE = 0.03  # of the tolerance: error of a leap; a stick has some hundred leaps
_PRICE = 500  # steps of the march that take as long as a leap
_ORDER = 6  # of a leap
_COVERED = 0.1  # change of ln v and psi over a leap, as a rule: 0.03 at a tolerance of 1e-9, 0.15 at 1e-6
_SHORTEST, _LONGEST = 4, 4096
_SHRINK, _SAFETY, _GROW = 0.2, 0.8, 2.0
_WORTH = 512  # transits to the end of the run; of a shorter one the march alone takes less time than the tries
_PAUSE, _LONGEST_PAUSE = 64, 2048  # transits marched before the next try to leap; doubled by a try that fails

_Moment: TypeAlias = tuple[TransitMesh, Array, DelayMemory]


class LeapingDelay(Delay):
    """`Delay`, to its `tolerance`, as a `Leaping` solver.

    Leaps begin in a stick: v is below V (in a hold, below V before it) in all of a transit. They go on while v rises slowly
    towards the next event, and end where the motion changes so fast that they would save no time. V is constant in them. Where z,
    mu or y comes to its maximum or minimum in a transit that is left out, that transit is marched too. `skipped` counts those
    left out.
    """

    def __init__(self, scene: Scene, tolerance: float = 1e-9) -> None:
        super().__init__(scene, tolerance=tolerance)
        self._allowed = _SHARE * tolerance
        self._past, self._length = self._nothing(), _SHORTEST
        self._next_try, self._pause = math.ceil(NUDGE_CENTRE + NUDGE_REACH), _PAUSE
        self.skipped = 0

    def leap(self, until: float, end: float, gaps: bool) -> Pieces:
        """As `Leaping`; never with long pieces."""
        while gaps and end - self.time > _WORTH and not self._waiting.time.size:
            now = self._memory.now[TIME]
            if not (self._past.number.size and self._past.number[-1] == now - 1.0):
                self._past = self._nothing()
            if now < self._next_try:
                return self.advance(min(until, self._next_try))
            if not (self._past.number.size == _ORDER and self._leap(end)):
                self._walk()
        return self.advance(until)

    def state(self) -> State:
        """As `Delay`, and `leaps`: transits skipped, length of the next leap, time of the next try, pause after it; `past`:
        number, change of phi and of y, and extremes of the latest transits; `past.incoming`: changes of the incoming wave."""
        _, number, change, highest = self._past
        return super().state() | {
            "leaps": np.array([self.skipped, self._length, self._next_try, self._pause], dtype=float),
            "past": np.column_stack([number, change[:, -2:], highest]),
            "past.incoming": change[:, :-2].reshape(-1, self._stages),
        }

    def restore(self, state: State) -> None:
        """As `Solver`."""
        leaps = whole_numbers(state, "leaps", (0, 1, 0, 1))
        saved = tables(state, {"past": (-1, 3 + EXTREMES), "past.incoming": (-1, self._stages)}, self.model)
        super().restore(state)
        number, states, highest = np.split(saved["past"], [1, 3], axis=1)
        waves = saved["past.incoming"].reshape(len(number), self._lines.incoming.size)
        self._past = MarchedTransits(_ORDER, number.ravel(), np.column_stack([waves, states]), highest)
        self.skipped, self._length, self._next_try, self._pause = leaps

    def _change(self, mesh: TransitMesh, incoming: Array, now: Array) -> None:
        super()._change(mesh, incoming, now)
        self._past = self._nothing()

    def _walk(self) -> None:
        """March the next transit if it may belong to a stick; return to the ordinary march if none begins or continues."""
        start = float(self._memory.now[TIME])
        pieces, change, verdict = self._transit()
        if verdict != DONE:
            self._refine(verdict)
            self._give_up()
            return
        self._waiting = pieces
        drive = self.scene.drive
        # whether V is constant until the waves of this transit have returned
        rests = drive.at(start + 2.0) == drive.at(start) and self._next_kink(start) >= start + 2.0
        if rests and self._is_slow(start, pieces) and _PRICE * self._size(pieces, change) < _COVERED * self.steps:
            self._past = self._past.then(start, change, extremes(pieces))
        else:
            self._give_up()

    def _leap(self, end: float) -> bool:
        """Leap from the latest transit to a later one, at most the last of the run, and march it. False if that fails: then only
        the length of the next leap has changed."""
        before, past, failures = (self._mesh, self._lines.incoming, self._memory), self._past, self.failures
        start = float(past.number[-1])
        target = min(start + self._length, float(np.floor(self._next_kink(start))) - 2.0, math.ceil(end - SAME) - 1.0)
        if target < start + 2.0:
            return False
        predicted = past.total(start + 1.0, target)
        self._jump_to(before, predicted, target)
        pieces, change, verdict = self._transit()
        error = math.inf
        if verdict == DONE and self.failures == failures and self._is_slow(target, pieces):
            error = self._size(pieces, past.error(start + 1.0, target, change))
        ratio = min(_GROW, max(_SHRINK, _SAFETY * (self._allowed / max(error, 1e-300)) ** (1.0 / (_ORDER + 1))))
        self._length = min(_LONGEST, int((target - start) * ratio))
        pays = self._length > target - start or self._length * self.steps >= _PRICE
        if not error <= self._allowed:
            self._take(*before)
            self.failures = failures
            if not pays:
                self._give_up()
            return False
        self._past = past.then(target, change, extremes(pieces))
        self._length, self._pause = max(self._length, _SHORTEST), _PAUSE
        visited = [self._visit(before, past, number) for number in self._past.peaks(start, target)]
        self._waiting = Pieces.joined([*visited, pieces])
        self.skipped += int(target - start) - len(visited) - 1
        if not pays:
            self._give_up()
        return True

    def _visit(self, before: _Moment, past: MarchedTransits, number: float) -> Pieces:
        """The pieces of a transit that was left out."""
        present = self._mesh, self._lines.incoming, self._memory
        self._jump_to(before, past.total(past.number[-1] + 1.0, number), number)
        pieces, _, _ = self._transit()
        self._take(*present)
        return pieces

    def _jump_to(self, before: _Moment, change: Array, number: float) -> None:
        """Set the state at the beginning of the transit `number`: the memory `before` plus `change`."""
        mesh, incoming, (_, now) = before
        psi = now[PSI] + math.log1p(change[-2] * math.exp(-now[PSI]))
        self._remember(mesh, incoming + change[:-2].reshape(incoming.shape), present(number, psi, now[ELASTIC] + change[-1]))

    def _transit(self) -> tuple[Pieces, Array, int]:
        """March one transit; returns its pieces, the change of the state (wave, phi, y), and the verdict of the march.

        phi is used instead of psi, because it grows linearly in a stick. The change of the wave is eps (V - v): the difference of
        two waves would have a thousand times larger rounding errors."""
        pieces, before = empty_pieces(self.steps, self._stages), self._memory.now.copy()
        _, verdict = self._march(1, pieces)
        velocity = self.scene.drive.at(before[TIME])
        wave = 2.0 * self._impedance * (velocity - rates(self.scene.law, pieces.z))
        now = self._memory.now
        phi = math.exp(before[PSI]) * math.expm1(now[PSI] - before[PSI])
        return pieces, np.concatenate((wave.ravel(), (phi, now[ELASTIC] - before[ELASTIC]))), verdict

    def _is_slow(self, start: float, pieces: Pieces) -> bool:
        """Whether the transit that begins at `start` belongs to a stick, or to the slow rise of v after it."""
        highest = float(pieces.z.max())
        if self._past.number.size and highest > self._past.highest[-1, 0]:
            return True
        return highest < self._stick_limit(start)

    def _next_kink(self, time: float) -> float:
        """The next time (transits) at which V has a kink; infinite if there is none."""
        return self.scene.drive.knot_after(time)

    def _size(self, pieces: Pieces, change: Array) -> float:
        """Size of a `change` of the state: the largest of the changes of psi, y and ln v (that of the wave over F_z)."""
        psi = float(pieces.psi[-1, -1])
        friction_z = respond(self.scene.law, float(pieces.z[-1, -1]), psi)[3]
        return float(max(np.abs(change[:-2]).max() / friction_z, abs(change[-2]) * math.exp(-psi), abs(change[-1])))

    def _give_up(self) -> None:
        """March for a while before the next try to leap."""
        self._past, self._length = self._nothing(), _SHORTEST
        self._next_try = int(self._memory.now[TIME]) + self._pause
        self._pause = min(2 * self._pause, _LONGEST_PAUSE)

    def _nothing(self) -> MarchedTransits:
        return MarchedTransits(_ORDER, np.empty(0), np.empty((0, self._lines.incoming.size + 2)), np.empty((0, EXTREMES)))


_LONGEST_STEP = 1.0 / 3.0  # transits
_ALIGNED = 1e-7  # of a step: ignoring a kink this close to a step's end causes a relative error of that size


def delay_system(scene: Scene, tolerance: float = 1e-9) -> "Delay | DelayNetwork":
    """The solver of the delay system: one slab and one delay for plain slabs of equal round trips, a network of lines for all
    other lossless ones. If equal steps cannot end on the jumps and kinks, steps end on these (`DelayBreaks`), hundreds in a
    transit, until their echoes have decayed. The solver is `Leaping`. For plain slabs of equal round trips in a scene that
    records nothing, does not start on its orbit and needs few steps, only the state at the end is accurate (`Delay`, emit=False).
    Raises SceneError for viscous slabs.
    """
    if scene.is_plain:
        shown = bool(scene.record) or scene.start.kind is StartKind.ORBIT or first_steps(scene, NODES) >= MOST_FIRST_STEPS
        return LeapingDelay(scene, tolerance) if shown else Delay(scene, tolerance=tolerance, emit=False)
    from reduced.delay.break_points import DelayBreaks  # networks take as long to import as all that plain pairs need
    from reduced.delay.leaping_network import LeapingNetwork

    lines = lines_of(scene)
    if lines.divisor is None:
        breaks_within_steps = scene.start.kind is StartKind.JUMP or not scene.drive.is_constant
    else:
        knots = np.array(scene.drive.knots) / lines.divisor
        breaks_within_steps = bool((np.abs(knots - np.round(knots)) > _ALIGNED).any())
    if breaks_within_steps and not _hides_breaks(scene, lines, tolerance):
        return DelayBreaks(scene, tolerance=tolerance, lines=lines)
    return LeapingNetwork(scene, tolerance=tolerance, lines=lines)


def _hides_breaks(scene: Scene, lines: Lines, tolerance: float) -> bool:
    """Whether outer faces have masses and no dashpots, so that only their acceleration jumps, by K dV/m, at a jump of V, and the
    polynomials of a step represent its wave to the tolerance.

    A polynomial of degree n misses a jump q of the second derivative within a step h by about q (h/n)^2/8."""
    if scene.start.kind is StartKind.JUMP or any(top.dashpot > 0.0 or top.mass == 0.0 for top in lines.tops):
        return False
    velocities = scene.drive.velocities
    jump = max(velocities) - min(velocities)
    friction_z = scene.steady_response[3]
    bend = max(top.spring / top.mass * lines.impedance[last] for top, last in zip(lines.tops, lines.last, strict=True))
    return bool(jump * bend * ((_LONGEST_STEP / (NODES - 1)) ** 2 / 8.0) < tolerance * friction_z)
