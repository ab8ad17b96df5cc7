"""Leaps over sticks with large trapped waves: from one block of transits, in which all waves nearly repeat, to a later one.

In a stick slip hardly damps the waves. Those of a stiff sample change ln v by 2, too much for a linear theory, and where a soft
spring holds the outer face their modes drift apart. But in the frame of waves that move without slip,

    X_k = B^-k x_k,    B: the map of a block with v = 0,

the memory x is changed by slip alone, and this change varies slowly from block to block, so that the multirevolution method sums
it (`reduced.delay.multirevolution`).
"""

import math
from typing import NamedTuple

import numpy as np

from reduced.delay.frozen_step import Disturbance, Friction, FrozenStep, advanced, powers_of
from reduced.delay.kernel import DelayMemory, present
from reduced.delay.march import EXTREMES, extremes
from reduced.delay.multirevolution import Past
from reduced.delay.network import DelayNetwork
from reduced.delay.network_kernel import LOAD, VELOCITY, NetworkLines, lines_with
from reduced.delay.transmission_lines import COINCIDENT
from slipwave.friction import rates, respond
from slipwave.observe.pieces import Array, Pieces, empty_pieces
from slipwave.step.nodal import ELASTIC, PSI, Interface

_HELD = Friction(v_z=0.0, mu_z=1.0, mu_psi=0.0, g_z=0.0, g_psi=0.0)
_MOST_STEPS, _MOST_ENTRIES = 256, 300  # of a block; of a state
_FARTHEST, _MARCHED = 1 << 12, 400  # blocks that a leap skips, and blocks marched in one call, at most
_ORDER = 8  # of a leap
_PRICE = 600  # steps of the march that take as long as a leap
_FIRST = 32  # blocks between the first marched ones: of closer ones rounding would be extrapolated
_SHRINK, _SAFETY, _GROW = 0.2, 0.9, 2.0
_ROUNDING = 0.02  # of the allowed error: less may be rounding, which does not grow as a leap's error


class _Block(NamedTuple):
    """So many `steps` that all waves in a stick nearly repeat, the `powers` 1, 2, 4, .. of their map (n, n) without slip, and the
    change of the memory `by_slip` (n, steps s) at the nodes; psi is left out."""

    steps: int
    powers: list[Array]
    by_slip: Array


class _Walk(NamedTuple):
    """Of a walk over blocks: steps done at its `start`, `number` of the next block, the memory `now` (n,) and the `guess` for its
    first step, the `past`, whose changes are in the frame of `now`; `now` is the difference from the memory `shift` (n,) of slabs
    that move apart with V."""

    start: int
    number: int
    now: Array
    guess: Interface
    past: Past
    shift: Array


class StroboscopicNetwork(DelayNetwork):
    """`DelayNetwork` that can leap from block to block of a stick. `skipped` counts the transits not marched."""

    _frozen: FrozenStep | None = None
    _block: _Block | None = None
    skipped = 0.0

    def _over_blocks(self, stop: float, allowed: float) -> Pieces | None:
        """Marched blocks of a stick before `stop`, with gaps between them; each leap errs by less than is `allowed`. None if no
        leap saves time: the motion has then not gone on."""
        steps = self._repeating_steps()
        if not steps:
            return None
        reach, most = max(_FIRST, _PRICE // steps + 1), int((stop - self.time) / (steps * self._length) - COINCIDENT)
        if most < 2 * _ORDER * reach or not self._sticks(reach * steps):
            return None
        block = self._block = self._block or self._block_of(steps)
        before, shift, shown, skipped = self._moment(), self._translation(), list[Pieces](), 0
        walk = _Walk(
            self._done,
            0,
            self._now().vector - shift,
            before[1].guess,
            Past(_ORDER, np.empty(0), np.empty((0, shift.size)), np.empty((0, EXTREMES))),
            shift,
        )
        while walk.number + reach < most and len(shown) < _MARCHED and reach * block.steps >= _PRICE:
            pieces, later, error = self._leapt(block, walk, reach)
            if not error <= allowed:
                reach = _of_few_powers(max(_SHRINK, _scale(allowed, error)) * reach) if skipped else 0
                continue
            if walk.past.number.size == _ORDER:
                for number in map(int, later.past.peaks(walk.number - 1, later.number - 1)):
                    shown.append(self._visited(block, walk, number))
                    skipped -= 1
                skipped += reach
                reach = _of_few_powers(min(_GROW, _scale(allowed, error)) * reach)
            shown.append(pieces)
            walk = later
        if not skipped:
            self._return_to(before)
            return None
        self._put(block, walk, walk.now, walk.number)
        self.skipped += skipped * block.steps * self._length
        return Pieces.joined(shown)

    def _leapt(self, block: _Block, walk: _Walk, reach: int) -> tuple[Pieces, _Walk, float]:
        """Skip `reach` blocks, or march them while the past is not complete, and march the next one: the pieces, the walk after
        it, and the leap's error, infinite if the block is not one of a stick."""
        last, held, complete = walk.number + reach, block.powers[0], walk.past.number.size == _ORDER
        self._put(block, walk, self._begin(block, walk, reach) if complete else walk.now, last if complete else walk.number)
        limit, passed = self._stick_limit(self.time), self._marched(0 if complete else reach * block.steps)
        begin = self._memory.now[PSI]
        pieces = self._marched(block.steps)
        if passed is None or pieces is None or max(part.z.max(initial=-math.inf) for part in (passed, pieces)) > limit:
            return empty_pieces(0, self._stages), walk, math.inf
        now, error = self._now().vector - walk.shift, 0.0
        change = block.by_slip @ (rates(self.scene.law, pieces.z) - self.scene.drive.at(self.time)).ravel()
        change[-2] = self._memory.now[PSI] - begin
        past = walk.past._replace(change=(held @ advanced(block.powers, walk.past.change.T, reach)).T)
        if complete:
            friction_z = respond(self.scene.law, float(pieces.z[-1, -1]), float(pieces.psi[-1, -1]))[3]
            error = self._size(held @ past.error(walk.number, last, change), friction_z)
        past = past.then(last, change, extremes(pieces))
        return Pieces.joined([passed, pieces]), _Walk(walk.start, last + 1, now, self._memory.guess, past, walk.shift), error

    def _begin(self, block: _Block, walk: _Walk, reach: int) -> Array:
        """The memory (n,) after `reach` more blocks, by the polynomial through past changes."""
        return advanced(block.powers, walk.now + walk.past.total(walk.number, walk.number + reach), reach)

    def _visited(self, block: _Block, walk: _Walk, number: int) -> Pieces:
        """The pieces of a block that is left out."""
        self._put(block, walk, self._begin(block, walk, number - walk.number), number)
        pieces = self._marched(block.steps)
        assert pieces is not None  # its neighbours were marched
        return pieces

    def _marched(self, steps: int) -> Pieces | None:
        """The pieces of the next `steps`; None if one fails."""
        pieces = empty_pieces(steps, self._stages)
        return pieces if not steps or self._march(self._length, pieces)[0] == steps else None

    def _put(self, block: _Block, walk: _Walk, memory: Array, number: int) -> None:
        """Set the state at the beginning of the block `number`."""
        waves, tops, (psi, y) = self._frozen_step().empty.like(memory + walk.shift)
        self._done = walk.start + number * block.steps
        self._lines = lines_with(self._lines.network, waves.copy(), tops.copy())
        now = present(self._origin + self._done * self._length, psi, y)
        self._memory = DelayMemory(Interface(*(values.copy() for values in walk.guess)), now)

    def _sticks(self, steps: int) -> bool:
        """Whether v stays that of a stick in the next `steps`; they are marched and taken back, which costs less than tables."""
        before, limit = self._moment(), self._stick_limit(self.time)
        pieces = self._marched(steps)
        self._return_to(before)
        return pieces is not None and bool(pieces.z.max() < limit)

    def _repeating_steps(self) -> int:
        """Steps of two round trips of all slabs, after which waves nearly repeat at outer faces that are nearly free or rigid; 0
        if these have no common multiple, or too long a one, or the memory is too large."""
        if not self._layers.divisor or self._lines.waves.size > _MOST_ENTRIES:
            return 0
        travel, pairs = self._layers.travel / self._length, zip(self._layers.first, self._layers.last, strict=True)
        steps = 2 * math.lcm(*(round(2.0 * float(travel[first : last + 1].sum())) for first, last in pairs))
        return steps if steps <= _MOST_STEPS else 0

    def _block_of(self, steps: int) -> _Block:
        """The tables of a block of so many steps."""
        held, _ = self._frozen_step().matrix(_HELD)
        by_slip = [self._frozen_step().by_slip]
        while len(by_slip) < steps:
            by_slip.insert(0, held @ by_slip[0])
        return _Block(steps, powers_of(np.linalg.matrix_power(held, steps), _FARTHEST), np.hstack(by_slip))

    def _translation(self) -> Array:
        """The memory (n,) of slabs that move apart with the present V, instead of that of steady sliding."""
        empty, network = self._frozen_step().empty, self._lines.network
        change = self.scene.drive.at(self.time) - self.scene.velocity
        waves = np.broadcast_to(change * self._layers.apart[..., None, None], empty.waves.shape)
        tops = np.where(np.arange(2) == VELOCITY, 0.5 * change * network.remembers[:, None], 0.0)
        return Disturbance(waves, tops, empty.rest).vector

    def _frozen_step(self) -> FrozenStep:
        """The linear step of present length."""
        self._frozen = self._frozen or FrozenStep(self._lines.network, self._length, self._stages, self.scene.forcing)
        return self._frozen

    def _forget_steps(self) -> None:
        """After a change of the steps."""
        self._frozen = self._block = None

    def _now(self) -> Disturbance:
        """The present memory."""
        _, _, waves, tops, cursor, _ = self._lines
        first = int(cursor[0])
        oldest_first = np.concatenate((waves[:, :, first:], waves[:, :, :first]), axis=2)
        return Disturbance(oldest_first, tops, self._memory.now[[PSI, ELASTIC]])

    def _moment(self) -> tuple[NetworkLines, DelayMemory, float, int, int]:
        """All that a march changes, to return to the present."""
        lines, (guess, now) = self._lines, self._memory
        waves = lines_with(lines.network, lines.waves.copy(), lines.tops.copy(), int(lines.cursor[0]))
        memory = DelayMemory(Interface(guess.psi.copy(), guess.z.copy()), now.copy())
        return waves, memory, self._origin, self._done, self.iterations

    def _return_to(self, moment: tuple[NetworkLines, DelayMemory, float, int, int]) -> None:
        self._lines, self._memory, self._origin, self._done, self.iterations = moment

    def _size(self, change: Array, friction_z: float) -> float:
        """Size of a `change` (n,) of the memory: the largest of the changes of psi, y and ln v (that of a wave over F_z)."""
        waves, tops, rest = self._frozen_step().empty.like(np.abs(change))
        impedance = self._layers.impedance[list(self._layers.last)]
        stress = max(float(waves.max()), float(tops[:, LOAD].max()), float((tops[:, VELOCITY] * impedance).max()))
        return max(float(rest[0]), float(rest[1]), stress / friction_z)


def _scale(allowed: float, error: float) -> float:
    """Ratio of the next leap's length to that of a leap with this `error`."""
    return math.inf if error < _ROUNDING * allowed else _SAFETY * (allowed / error) ** (1.0 / (_ORDER + 1))


def _of_few_powers(number: float) -> int:
    """`number` rounded down so that a power with this exponent is a product of at most three of `_Block`."""
    most = min(int(number), _FARTHEST)
    bits = max(0, most.bit_length() - 3)
    return most >> bits << bits
