"""Leaps over sticks with large trapped waves: from one block of transits, in which all waves nearly repeat, to a later one.

In a stick slip hardly damps the waves. Those of a stiff sample change ln v by 2, too much for a linear theory, and where a soft
spring holds the outer face their modes drift apart. But in the frame of waves that move without slip,

    X_k = B^-k x_k,    B: the map of a block with v = 0,

the memory x is changed by slip alone, and this change varies slowly from block to block, so that the multirevolution method sums
it (`reduced.delay.multirevolution`).
"""

import math

import numpy as np

from reduced.delay.frozen_step import Disturbance, Friction, FrozenStep, advanced, powers_of
from reduced.delay.march import EXTREMES, DelayMemory
from reduced.delay.multirevolution import LONGEST, sum_rules
from reduced.delay.network import DelayNetwork
from reduced.delay.network_kernel import VELOCITY, NetworkLines, lines_with
from reduced.delay.stroboscopic_kernel import (
    ITERATIONS,
    NEXT,
    REACH,
    SHOWN,
    SKIPPED,
    LineMarch,
    StickBlock,
    Walk,
    WalkTask,
    memory_of,
    size_of_change,
    walk_on,
)
from reduced.delay.transmission_lines import COINCIDENT
from slipwave.friction import respond
from slipwave.observe.pieces import Array, Pieces, empty_pieces
from slipwave.step.nodal import PSI, Interface

_HELD = Friction(v_z=0.0, mu_z=1.0, mu_psi=0.0, g_z=0.0, g_psi=0.0)
_MOST_STEPS, _MOST_ENTRIES = 256, 300  # of a block; of a state
_MARCHED = 1 << 15  # steps of leaps in one call
_SLOTS = 64  # leaps of different lengths
_ORDER = 8  # of a leap
_PRICE = 600  # steps of the march that take as long as a leap
_DAMPED = 0.04  # part of the waves that slip takes in the marched blocks: if it is more, these change too fast
_FIRST = 32  # blocks between the first marched ones: of closer ones rounding would be extrapolated


class StroboscopicNetwork(DelayNetwork):
    """`DelayNetwork` that can leap from block to block of a stick. `skipped` counts the transits not marched."""

    _frozen: FrozenStep | None = None
    _block: StickBlock | None = None
    skipped = 0.0

    def _over_blocks(self, stop: float, allowed: float) -> Pieces | None:
        """Marched blocks of a stick before `stop`, with gaps between them; each leap errs by less than is `allowed`. None if no
        leap saves time: the motion has then not gone on."""
        steps = self._repeating_steps()
        if not steps:
            return None
        reach, last = max(_FIRST, _PRICE // steps + 1), int((stop - self.time) / (steps * self._length) - COINCIDENT)
        z, psi = float(self._memory.guess.z.max()), float(self._memory.now[PSI])
        _, v_z, _, friction_z, *_ = respond(self.scene.law, z, psi)
        damped = self.scene.impedance * v_z / friction_z * _ORDER * reach * steps * self._length
        if damped > _DAMPED or last < 2 * _ORDER * reach or not self._sticks(reach * steps):
            return None
        block = self._block = self._block or self._block_of(steps)
        before, shift = self._moment(), self._translation()
        limit, velocity = self._stick_limit(self.time), self.scene.drive.at(self.time)
        task = WalkTask(last, _PRICE // steps + 1, allowed, limit, velocity, self._origin, self._done, shift)
        rows, size = _ORDER + 1, shift.size
        walk = Walk(
            self._now().vector - shift,
            Interface(*(values.copy() for values in self._memory.guess)),
            np.arange(-rows, 0.0),
            np.zeros((rows, size)),
            np.zeros((rows, EXTREMES)),
            np.array([0, reach, 0, 0, 0, 0]),
        )
        march = LineMarch(self._physics, self._lines, self._memory, self._nodal, self._limits)
        pieces = empty_pieces(_ORDER * (reach + 1) * steps + _MARCHED, self._stages)
        while True:
            reach = int(walk.counts[REACH])
            if block.slot[reach] < 0:  # the map over a leap of `reach` blocks and the next one is missing
                slot = int((block.slot >= 0).sum())
                block.after[slot], block.slot[reach] = advanced(list(block.powers), block.powers[0], reach), slot
            walk_on(self._shape, march, block, task, walk, pieces)
            if block.slot[walk.counts[REACH]] >= 0:
                break
        if not walk.counts[SKIPPED]:
            self._return_to(before)
            return None
        self._done += int(walk.counts[NEXT]) * steps
        self.iterations += int(walk.counts[ITERATIONS])
        self.skipped += int(walk.counts[SKIPPED]) * steps * self._length
        return Pieces(*(values[np.argsort(pieces.time[: walk.counts[SHOWN]])] for values in pieces))

    def _marched(self, steps: int) -> Pieces | None:
        """The pieces of the next `steps`; None if one fails."""
        pieces = empty_pieces(steps, self._stages)
        return pieces if self._march(self._length, pieces)[0] == steps else None

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

    def _block_of(self, steps: int) -> StickBlock:
        """The tables of a block of so many steps."""
        frozen = self._frozen_step()
        held, _ = frozen.matrix(_HELD)
        by_slip = [frozen.by_slip]
        while len(by_slip) < steps:
            by_slip.insert(0, held @ by_slip[0])
        powers = np.array([power.T for power in powers_of(np.linalg.matrix_power(held, steps), LONGEST)])
        slot, after, rows = np.full(LONGEST + 1, -1), np.empty((_SLOTS, *held.shape)), np.hstack(by_slip).T.copy()
        slot[0], after[0] = 0, powers[0]
        stress = self._stress() * held[:, :-2].any(axis=0)
        return StickBlock(steps, self._length, powers, after, slot, rows, stress, *sum_rules(_ORDER))

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
        return self._frozen_step().empty.like(memory_of(self._lines, self._memory))

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
        return size_of_change(self._stress(), change, friction_z)

    def _stress(self) -> Array:
        """Stress (n - 2,) that each entry of the memory causes, but for psi and y."""
        waves, tops = self._frozen_step().empty.waves, np.ones((len(self._layers.last), 2))
        tops[:, VELOCITY] = self._layers.impedance[list(self._layers.last)]
        return np.append(np.ones(waves.size), tops)
