"""Marches friction against any slab model (`slipwave.step.port.Slabs`), from break point to break point of its motion."""

import math
from typing import TypeAlias

import numpy as np

from slipwave.errors import NumericsError
from slipwave.friction import rate_of, said_of_rest, unknown_of
from slipwave.observe.history import evaluated
from slipwave.observe.pieces import Array, Pieces, empty_pieces, lagrange_basis, slack
from slipwave.solve import State, tables, whole_numbers
from slipwave.step.collocation import growth_limit, rule_of
from slipwave.step.flow import Cycle, InterfaceState
from slipwave.step.march import ANY_LENGTH, END, NEXT, NOT_READY, TOO_LONG, Memory, Stretch, begin, march, resolution_of
from slipwave.step.nodal import PSI, TIME, Interface, Limits, Physics, nodal_of
from slipwave.step.port import LEVELS, Levels, Slabs, padded
from slipwave.step.port_flow import PortFlow, flow_near

CHUNK = 2048
_UNCUT = 2.0  # transits; a last piece up to this long may end beyond the end of a run

_Rest: TypeAlias = tuple[float, float, Array, float]
"""Begin and length (transits) and nodal values (4, s) of a piece that was cut, and the time from which on it is still to come."""


class PortMarch:
    """The march of friction against `slabs` in collocation steps of length `longest`/2^k (transits), k < `levels`, or, between
    two break points, their distance over 2^k, down to the same shortest; the first step has the length `first`. `tolerance`:
    relative error of the figures of a cycle. `reason` is added to the message if no step is short enough. One call of compiled
    code takes at most `most_steps`."""

    bookkeeping = frozenset({"counts", "stretch", "last", "rest"})
    longest_after_break = math.inf
    """Length (transits) with which steps begin behind a break point, unless those before it were shorter."""

    def __init__(
        self,
        slabs: Slabs,
        tolerance: float,
        longest: float,
        first: float,
        levels: int = LEVELS,
        reason: str = "",
        most_steps: int = CHUNK,
    ) -> None:
        scene, stages = slabs.scene, slabs.stages
        self.slabs, self._reason, self._most_steps = slabs, reason, most_steps
        self._longest, self._levels, self._longest_in_cycle = longest, levels, longest
        self._whole = np.zeros(padded(slabs.remembered))
        self.values = self._whole[: slabs.remembered]
        rule, compiled, self._shape = rule_of(stages)
        self.nodes, self._basis = rule.nodes, lagrange_basis(rule.nodes)
        self.iterations = 0
        self._physics, self._nodal = Physics(scene.law, scene.forcing, scene.drive.compiled, compiled), nodal_of(stages)
        self._limits = Limits(
            max(1e-2 * tolerance, 1e-14), max(resolution_of(tolerance, stages), 1e-10), growth_limit(stages, tolerance)
        )
        start = unknown_of(scene.law, scene.velocity)
        self._memory = begin(scene.steady_psi + scene.start.jump_size, scene.steady_stress, start, stages)
        self._rest: _Rest | None = None
        self._take_stretch(0.0, first)

    @property
    def time(self) -> float:
        """Transits since the start."""
        return self._now if self._rest is None else self._rest[-1]

    @property
    def _now(self) -> float:
        return float(self._memory.now[TIME])

    @property
    def _next_length(self) -> float:
        return float(self._port.length[self._memory.levels[NEXT]])

    @property
    def longest(self) -> float:
        """Longest step (transits) between the last break and the next."""
        return float(self._port.length[0])

    def advance(self, until: float) -> Pieces:
        """As `Solver`; NumericsError if no step is short enough."""
        if self._rest is not None:
            pieces, self._rest = self._remaining(), None
            return pieces
        pieces = empty_pieces(self._most_steps, self.nodes.size)
        steps, ended = 0, NOT_READY
        while ended != TOO_LONG and steps < self._most_steps and (ended == NOT_READY or self._now < until - slack(until)):
            if self._now >= self._stretch.stop - slack(self._now):
                self._take_stretch(self._stretch.stop, min(self._next_length, self.longest_after_break))
            left = pieces.part(slice(steps, None))
            stretch, memory = self._stretch._replace(until=until), self._memory
            more, iterations, ended = march(
                self._shape, self._physics, self._port, memory, self._nodal, self._limits, stretch, left
            )
            steps += more
            self.iterations += iterations
            if ended == NOT_READY:
                level = int(self._memory.levels[NEXT])
                self.slabs.prepare(self._port, level)
                self._resist(np.array([level]))
        if ended == TOO_LONG and not steps:
            raise self._refusal()
        return pieces.part(slice(steps))

    def cut(self, pieces: Pieces, until: float) -> Pieces:
        """As `Cutting`."""
        begin, length, end = float(pieces.time[-1]), float(pieces.length[-1]), self.time
        if until >= end - slack(end) or length <= _UNCUT:
            return pieces
        whole = np.array([column[-1] for column in pieces[2:]])
        self._rest, pieces.length[-1] = (begin, length, whole, until), until - begin
        for column, values in zip(pieces[2:], self._evaluated(whole, self.nodes * ((until - begin) / length)), strict=True):
            column[-1] = values
        return pieces

    def _evaluated(self, whole: Array, points: Array) -> list[Array]:
        """The columns of a piece with the nodal values `whole` at `points` of [0, 1]."""
        return evaluated(whole[:, None], self._basis, points, self.slabs.scene.law)

    def _remaining(self) -> Pieces:
        """The rest of the piece that was cut."""
        assert self._rest is not None
        start, length, whole, begin = self._rest
        if begin > start:
            points = np.minimum(1.0, (begin + (self._now - begin) * self.nodes - start) / length)
            whole = np.array(self._evaluated(whole, points))
        return Pieces(np.array([begin]), np.array([self._now - begin]), *whole[:, None])

    def _refusal(self) -> NumericsError:
        scene, now, reason = self.slabs.scene, self._memory.now, f" ({self._reason})" if self._reason else ""
        reason += said_of_rest(scene.law, self._nodal.incoming, float(now[END]), float(now[PSI]))
        return NumericsError(
            f"{self.slabs.model}: no step is short enough at t = {now[TIME]:.6g} transits, "
            f"v = {rate_of(scene.law, now[END]):.3g} V*, psi = {now[PSI]:.4g}{reason} "
            f"(scene {scene.name!r}, digest {scene.digest})"
        )

    def state(self) -> State:
        """As `Solver`. `remembered`: memory of the slabs; `last` and `now` of `Memory`; `stretch`: time from which the present
        step lengths hold; `counts`: level of the next step and of the last (-1: none), iterations; `rest`, where the last `cut`
        left one: of its piece, time, length and values."""
        memory = self._memory
        rest = {} if self._rest is None else {"rest": np.concatenate(self._remaining(), axis=None)}
        return rest | {
            "counts": np.array([*memory.levels, self.iterations], dtype=float),
            "stretch": np.array([self._stretch.origin]),
            "last": np.stack(memory.last),
            "now": memory.now.copy(),
            "remembered": self.values.copy(),
        }

    def restore(self, state: State) -> None:
        """As `Solver`."""
        following, last, iterations = whole_numbers(state, "counts", (0, -1, 0))
        shapes = {"stretch": (1,), "last": (2, self.nodes.size), "now": self._memory.now.shape, "remembered": self.values.shape}
        if "rest" in state:
            shapes["rest"] = (2 + 4 * self.nodes.size,)
        saved = tables(state, shapes, self.slabs.model)
        self.iterations = iterations
        self._take_tables(float(saved["stretch"][0]))
        levels = np.minimum([following, last], self._port.length.size - 1)
        self._memory = Memory(Interface(*saved["last"]), saved["now"], levels)
        self.values[:] = saved["remembered"]
        self._rest = None
        if "rest" in saved:
            time, length, *values = np.split(saved["rest"], [1, 2, *(2 + np.arange(1, 4) * self.nodes.size)])
            self._rest = float(time[0]), float(length[0]), np.array(values), float(time[0])

    def flow(self, period: float, tolerance: float) -> tuple[PortFlow, Array]:
        """Flow on a mesh that resolves the next `period` (transits) to `tolerance`, and the present state as its state."""
        state = np.append(self.values, self._memory.now[PSI])
        # of slabs of its own, because it makes tables of many lengths
        return flow_near(self.slabs.of(self.slabs.scene), state, period, tolerance, self._longest_in_cycle), state

    def state_at_start(self, cycle: Cycle, interface: InterfaceState) -> State:
        """The state, for `restore`, at the start of `cycle`, a motion of a flow of these slabs; no step lies before it."""
        saved = self.state()
        memory = begin(interface.psi, interface.elastic, interface.z, self.nodes.size)
        memory.now[TIME] = interface.time
        counts = np.array([saved["counts"][0], -1.0, self.iterations])
        stretch, values = np.array([interface.time]), cycle.start[:-1].copy()
        return saved | {
            "counts": counts,
            "stretch": stretch,
            "last": np.stack(memory.last),
            "now": memory.now,
            "remembered": values,
        }

    def _take_stretch(self, begin: float, before: float) -> None:
        """Begin a stretch between break points at `begin` (transits), with steps of at most `before`."""
        self._take_tables(begin)
        memory = self._memory
        shorter = math.ceil(math.log2(float(self._port.length[0]) / before) - 1e-9)
        memory.levels[:] = min(max(0, shorter), self._port.length.size - 1), -1
        memory.now[TIME] = begin

    def _take_tables(self, begin: float) -> None:
        """Select the tables for the steps from `begin` (transits) to the next break point."""
        stop, longest = self.slabs.next_break(begin), self._longest
        if not math.isinf(stop):
            longest = (stop - begin) / 2 ** max(0, math.ceil(math.log2((stop - begin) / longest)))
        levels = self._levels - math.floor(math.log2(self._longest / longest))
        self._port = self.slabs.port(longest, levels)._replace(values=self._whole)
        self._stretch = Stretch(begin, begin, stop, np.full(self._port.length.size, math.nan), ANY_LENGTH)
        self._resist(np.flatnonzero(self._port.ready))

    def _resist(self, levels: Levels) -> None:
        self._stretch.resistance[levels] = self.slabs.resistance(self._port, levels, self._limits.growth)
