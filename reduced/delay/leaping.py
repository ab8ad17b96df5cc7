"""The delay system of alike plain slabs with leaps over the transits of long sticks.

A stick may last 1e5 transits. The waves of the last event stay trapped in the slabs and modulate the slip rate in every one of
them, so a march needs as many steps in each. But each transit is almost the same as the one before: `multirevolution`.
"""

import math

import numpy as np

from reduced.delay.alike import Delay
from reduced.delay.alike_kernel import ELASTIC, PSI, TIME, AlikeMemory
from reduced.delay.multirevolution import ORDER, Past, no_past
from slipwave.friction import rates, respond, unknown_of
from slipwave.observe.pieces import SAME, Array, Pieces, empty_pieces
from slipwave.observe.restoring import tables, whole_numbers
from slipwave.observe.solver import State
from slipwave.scene import Scene
from slipwave.scene.start import NUDGE_CENTRE, NUDGE_REACH
from slipwave.step.guess import DONE

_SLOW = 0.98  # of V, at most, in a stick: v never reaches V in the transits left out, and y rises through all of them
_SHARE = 0.03  # of the tolerance: error of a leap; a stick has some hundred leaps
_PRICE = 1000  # steps of the march that take as long as a leap
_COVERED = 0.1  # change of ln v and psi over a leap, as a rule: 0.03 at a tolerance of 1e-9, 0.15 at 1e-6
_SHORTEST, _LONGEST = 4, 4096
_SHRINK, _SAFETY, _GROW = 0.2, 0.8, 2.0
_PAUSE, _LONGEST_PAUSE = 64, 2048  # transits marched before the next try to leap; doubled by a try that fails


class LeapingDelay(Delay):
    """`Delay`, to its `tolerance`, which also does what `Leaping` asks for.

    A leap is made only in a stick: v is below V in all of its transits, and V is constant. So v_min is the only figure of a cycle
    that may lie in the transits left out; the slowest one of these is then marched too. `skipped` counts those left out. None is
    tried where the motion changes so fast that it would save no time.
    """

    def __init__(self, scene: Scene, tolerance: float = 1e-9) -> None:
        super().__init__(scene, tolerance=tolerance)
        self._allowed = _SHARE * tolerance
        self._past, self._length = self._nothing(), _SHORTEST
        self._next_try, self._pause = math.ceil(NUDGE_CENTRE + NUDGE_REACH), _PAUSE
        self.skipped = 0

    def leap(self, until: float, end: float) -> Pieces:
        """As `Leaping`."""
        while not self._waiting.time.size:
            now = self._memory.now[TIME]
            if not (self._past.number.size and self._past.number[-1] == now - 1.0):
                self._past = self._nothing()
            if now < self._next_try:
                return self.advance(min(until, self._next_try))
            if not (self._past.number.size == ORDER and self._leap(end)):
                self._walk()
        return self.advance(until)

    def state(self) -> State:
        """As `Delay`, and `leaps`: transits skipped, length of the next leap, when to try again, pause after that; `past`:
        number, change of psi and of y, and lowest z of the latest transits; `past.incoming`: changes of the incoming wave."""
        number, change, lowest = self._past
        return super().state() | {
            "leaps": np.array([self.skipped, self._length, self._next_try, self._pause], dtype=float),
            "past": np.column_stack([number, change[:, -2:], lowest]),
            "past.incoming": change[:, :-2].reshape(-1, self._stages),
        }

    def restore(self, state: State) -> None:
        """As `Solver`."""
        leaps = whole_numbers(state, "leaps", (0, 1, 0, 1))
        saved = tables(state, {"past": (-1, 4), "past.incoming": (-1, self._stages)}, self.model)
        super().restore(state)
        number, of_psi, of_y, lowest = saved["past"].T
        waves = saved["past.incoming"].reshape(number.size, self._memory.incoming.size)
        self._past = Past(number, np.column_stack([waves, of_psi, of_y]), lowest)
        self.skipped, self._length, self._next_try, self._pause = leaps

    def _walk(self) -> None:
        """March the next transit of what may be a stick; if it is none, leave it to the ordinary march."""
        start = float(self._memory.now[TIME])
        pieces, change, verdict = self._transit()
        if verdict != DONE:
            self._refine(verdict)
            self._give_up()
            return
        self._waiting = pieces
        if self._sticks(start, pieces) and _PRICE * self._size(pieces, change) < _COVERED * self.steps:
            self._past = self._past.then(start, change, float(pieces.z.min()))
        else:
            self._give_up()

    def _leap(self, end: float) -> bool:
        """Go from the latest transit to a later one, at most to that in which the run ends, and march it. False if it cannot be
        done: nothing has changed then but the length of the next leap."""
        before, past, failures = self._memory, self._past, self.failures
        start = float(past.number[-1])
        target = min(start + self._length, float(np.floor(self._next_kink(start))) - 2.0, math.ceil(end - SAME) - 1.0)
        if target < start + 2.0:
            return False
        predicted = past.total(start + 1.0, target)
        self._place(before, predicted, target)
        pieces, change, verdict = self._transit()
        longer, error = past.then(target, change, float(pieces.z.min())), math.inf
        if verdict == DONE and self.failures == failures and self._sticks(target, pieces):
            error = self._size(pieces, longer.total(start + 1.0, target) - predicted)
        self._length = min(_LONGEST, int((target - start) * self._scale(error)))
        if not error <= self._allowed:
            self._memory, self.failures = before, failures
            if self._length < _SHORTEST:
                self._give_up()
            return False
        self._past, self._length, self._pause = longer, max(self._length, _SHORTEST), _PAUSE
        between = longer.slowest(start, target)
        parts = [pieces] if between is None else [self._visit(before, past, between), pieces]
        self._waiting = Pieces(*(np.concatenate(rows) for rows in zip(*parts, strict=True)))
        self.skipped += int(target - start) - len(parts)
        return True

    def _visit(self, before: AlikeMemory, past: Past, number: float) -> Pieces:
        """The pieces of a transit that was left out."""
        present = self._memory
        self._place(before, past.total(past.number[-1] + 1.0, number), number)
        pieces, _, _ = self._transit()
        self._memory = present
        return pieces

    def _place(self, before: AlikeMemory, change: Array, number: float) -> None:
        """Go to the beginning of the transit `number`, by the `change` of the state since the memory `before`."""
        state = _state_of(before) + change
        self._memory = self._remember(state[:-2].reshape(before.incoming.shape), np.array([number, *state[-2:]]))

    def _transit(self) -> tuple[Pieces, Array, int]:
        """March one transit of a stick; returns its pieces, the change of the state, and the verdict of the march.

        The change of the wave is eps (V - v): the difference of two waves would have a thousand times larger rounding errors."""
        pieces, before = empty_pieces(self.steps, self._stages), self._memory.now.copy()
        _, verdict = self._march(1, pieces)
        velocity = self.scene.drive.at(before[TIME])
        wave = self.scene.upper.epsilon * (velocity - rates(self.scene.law, pieces.z))
        return pieces, np.concatenate((wave.ravel(), (self._memory.now - before)[[PSI, ELASTIC]])), verdict

    def _sticks(self, start: float, pieces: Pieces) -> bool:
        """Whether v is below V in all of the transit that begins at `start`, and V is constant until its waves have returned."""
        velocity = self.scene.drive.at(start)
        rests = velocity > 0.0 and self.scene.drive.at(start + 2.0) == velocity and self._next_kink(start) >= start + 2.0
        return rests and bool(pieces.z.max() < unknown_of(self.scene.law, _SLOW * velocity))

    def _next_kink(self, time: float) -> float:
        """The next time (transits) at which V has a kink; infinite if there is none."""
        return min((knot for knot in self.scene.drive.knots if knot > time), default=math.inf)

    def _size(self, pieces: Pieces, change: Array) -> float:
        """The largest change of psi, of y and of ln v (that of the wave over F_z) that a `change` of the state amounts to."""
        friction_z = respond(self.scene.law, float(pieces.z[-1, -1]), float(pieces.psi[-1, -1]))[3]
        return float(max(np.abs(change[:-2]).max() / friction_z, np.abs(change[-2:]).max()))

    def _scale(self, error: float) -> float:
        """How much longer the next leap can be than one with this `error`."""
        return float(min(_GROW, max(_SHRINK, _SAFETY * (self._allowed / max(error, 1e-300)) ** (1.0 / (ORDER + 1)))))

    def _give_up(self) -> None:
        """March for a while before the next try to leap."""
        self._past, self._length = self._nothing(), _SHORTEST
        self._next_try = int(self._memory.now[TIME]) + self._pause
        self._pause = min(2 * self._pause, _LONGEST_PAUSE)

    def _nothing(self) -> Past:
        return no_past(self._memory.incoming.size + 2)


def _state_of(memory: AlikeMemory) -> Array:
    """Incoming wave at the nodes, psi and y (m,)."""
    return np.concatenate((memory.incoming.ravel(), memory.now[[PSI, ELASTIC]]))
