"""The motion over one period (`Flow`) of the models that are ports: reductions and exactly propagated grids.

Steps are fixed fractions of the period, 1/count and its halves, chosen by a march that follows the motion. A march over another
period scales all lengths, so that the end is a smooth function of the period.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipwave.errors import NumericsError, SceneError
from slipwave.friction import smooth, unknown_of
from slipwave.observe.pieces import SAME, Array, Pieces, empty_pieces
from slipwave.scene import Scene
from slipwave.scene.drive import Constant
from slipwave.solve import State
from slipwave.step.collocation import growth_limit, rule_of
from slipwave.step.flow import NO_PUSH, Cycle, Pulses, Push, impulses, velocity_by_difference
from slipwave.step.march import ANY_LENGTH, NEXT, NOT_READY, Memory, Stretch, begin, march, resolution_of
from slipwave.step.newton import first_guess
from slipwave.step.nodal import DONE, TIME, Limits, Physics, nodal_of
from slipwave.step.port import LEVELS, Port, Slabs, prepared
from slipwave.step.tangent import Motion, carry, carry_back
from slipwave.threads import one_thread

_NEWTON = 1e-13  # allowed error of a step's iteration
_FINEST = 1e-12  # highest coefficient that rounding errors leave meaningful
_FIRST = 4  # level of the first step of a march that follows the motion
_MOST = 100_000  # steps in a period; a motion that runs away would take ever more


@dataclass(frozen=True)
class Mesh:
    """Steps of period/`count`/2^level, by the `levels` of all steps of a period; `longest`: length (transits) that a step may
    have; `resolution`: highest Legendre coefficient that a step was allowed; `growth`: largest growth in a step."""

    count: int
    levels: NDArray[np.int64]
    longest: float
    resolution: float
    growth: float


class PortFlow:
    """The motion of `slabs` on `mesh`. A state is the memory of the slabs, then psi."""

    def __init__(self, slabs: Slabs, mesh: Mesh) -> None:
        self.scene, self.model, self.mesh = slabs.scene, slabs.model, mesh
        self.size = slabs.remembered + 1
        self._slabs = slabs
        rule, self._rule, self._shape = rule_of(slabs.stages)
        self.nodes = rule.nodes
        self._made: Port | None = None

    @property
    def steady(self) -> Array:
        """As `Flow`."""
        return np.append(np.zeros(self.size - 1), self.scene.steady_psi)

    def mesh_state(self) -> State:
        """As `Flow`: the fields of `Mesh`."""
        mesh = self.mesh
        numbers = np.array([mesh.count, mesh.longest, mesh.resolution, mesh.growth])
        return {"numbers": numbers, "levels": mesh.levels.astype(float)}

    def on_mesh(self, state: State) -> "PortFlow":
        """As `Flow`."""
        count, *numbers = state["numbers"].tolist()
        return PortFlow(self._slabs, Mesh(round(count), np.rint(state["levels"]).astype(np.int64), *numbers))

    def march(self, start: Array, period: float, push: Push = NO_PUSH) -> Cycle:
        """As `Flow`."""
        port, levels = self._port(period), self.mesh.levels
        memory = _begin(self._slabs, port, start, int(levels[0]))
        pieces, iterations, ended = empty_pieces(levels.size, self.nodes.size), 0, DONE
        for part, stress, drive in push.parts(Constant(self.scene.velocity), levels.size):
            if ended == DONE and levels[part].size:
                stretch = Stretch(0.0, math.inf, math.inf, np.zeros(port.length.size), levels[part])
                here = port._replace(steady=port.steady + stress, drive_is_constant=drive.velocity == port.velocity)
                limits, rest = Limits(_NEWTON, math.inf, math.inf), pieces.part(part)
                _, more, ended = _march(self._slabs, here, memory, limits, stretch, rest, drive)
                iterations += more
        end = np.append(port.values[: self.size - 1], pieces.psi[-1, -1])
        if ended != DONE or not np.isfinite(end).all():
            raise _failure(self._slabs, float(memory.now[TIME]), period)
        return Cycle(period, start, end, pieces, iterations)

    def velocity(self, cycle: Cycle) -> Array:
        """As `Flow`."""
        return velocity_by_difference(self, cycle)

    def tangent(self, cycle: Cycle) -> Array:
        """As `Flow`."""
        port, changes, pieces = self._port(cycle.period), np.eye(self.size), cycle.pieces
        values, psi = np.zeros((self.size, port.values.size)), changes[:, -1].copy()
        values[:, : self.size - 1] = changes[:, :-1]
        motion = Motion(pieces.z, pieces.psi, False)
        with one_thread():
            carry(
                self._shape, self.scene.law, port, self.scene.transit, self._rule.integral, self.mesh.levels, motion, values, psi
            )
        return np.column_stack([values[:, : self.size - 1], psi]).T

    def pulses(self, cycle: Cycle, functional: Array) -> Pulses:
        """As `Flow`."""
        port, pieces, rule = self._port(cycle.period), cycle.pieces, self._rule.integral
        values, changes = np.zeros(port.values.size + 1), np.empty((2, *pieces.z.shape))
        values[: self.size - 1], values[-1] = functional[:-1], functional[-1]
        motion, transit = Motion(pieces.z, pieces.psi, False), self.scene.transit
        with one_thread():
            carry_back(self._shape, self.scene.law, port, transit, rule, self.mesh.levels, motion, values, changes)
        if not self._slabs.follows_drive:
            changes[1] = math.nan
        return impulses(pieces.time, pieces.length, self.nodes, changes)

    def essential_radius(self, cycle: Cycle) -> float:
        """As `Flow`: 0, because the memory of a port is finite."""
        return 0.0

    @property
    def idle(self) -> Array:
        """As `Flow`: none, but for grids of unlike slabs with the same round trip."""
        return np.zeros((self.size, 0))

    @property
    def undecided(self) -> bool:
        """As `Flow`."""
        return False

    def of(self, scene: Scene) -> "PortFlow":
        """As `Flow`. Raises SceneError if the memory of the slabs of `scene` has another size."""
        slabs = self._slabs.of(scene)
        if slabs.remembered != self._slabs.remembered:
            raise SceneError(
                f"{self.model}: its grid has other numbers of cells there ({slabs.remembered} values for "
                f"{self._slabs.remembered}); begin another branch there, or take --model delay"
            )
        return PortFlow(slabs, self.mesh)

    def remeshed(self, cycle: Cycle, finer: float) -> "tuple[PortFlow, Array]":
        """As `Flow`. The lengths of all levels, and the longest step, are shorter by the factor `finer`."""
        mesh, order = self.mesh, self.nodes.size - 1
        longest, resolution = mesh.longest / finer, max(mesh.resolution / finer**order, _FINEST)
        return PortFlow(
            self._slabs, _mesh_of(self._slabs, cycle.start, cycle.period, longest, resolution, mesh.growth / finer)
        ), cycle.start

    def loosened(self, start: Array, scenes: Sequence[Scene]) -> "tuple[PortFlow, Array]":
        """As `Flow`: itself, since no wave arrives within a step."""
        return self, start

    def roughness(self, cycle: Cycle, tolerance: float) -> float:
        """As `Flow`."""
        psi = cycle.pieces.psi
        z = smooth(self.scene.law, cycle.pieces.z, psi)
        largest = max(float(np.abs(values @ self._rule.tail).max()) for values in (z, psi))
        return largest / resolution_of(tolerance, self.nodes.size)

    def _port(self, period: float) -> Port:
        """Port for the steps of `period`, with arbitrary memory; the last one is kept for the tangent."""
        longest, levels = period / self.mesh.count, self.mesh.levels
        if self._made is None or self._made.length[0] != longest:
            self._made = prepared(self._slabs, self._slabs.port(longest, int(levels.max()) + 1), np.unique(levels)[::-1].tolist())
        return self._made


def flow_near(slabs: Slabs, start: Array, period: float, tolerance: float, longest: float) -> PortFlow:
    """Flow on a mesh that resolves the motion from `start` over `period` (transits) to `tolerance`, the relative error of the
    figures of a cycle, with steps of at most `longest` (transits)."""
    resolution, growth = resolution_of(tolerance, slabs.stages), growth_limit(slabs.stages, tolerance)
    return PortFlow(slabs, _mesh_of(slabs, start, period, longest, resolution, growth))


def _mesh_of(slabs: Slabs, start: Array, period: float, longest: float, resolution: float, growth: float) -> Mesh:
    """The mesh (`Mesh`) of a march over `period` from `start` whose steps follow the motion."""
    count = math.ceil(period / longest - SAME)
    port = slabs.port(period / count)
    stretch = Stretch(0.0, period, period, np.full(LEVELS, math.nan), ANY_LENGTH)
    memory, pieces = _begin(slabs, port, start, _FIRST), empty_pieces(_MOST, slabs.stages)
    drive = Constant(slabs.scene.velocity)
    steps, ended, missing = 0, NOT_READY, {_FIRST, *np.flatnonzero(port.ready).tolist()}
    while ended == NOT_READY:
        for level in missing:
            prepared(slabs, port, [level])
            stretch.resistance[level] = slabs.resistance(port, np.array([level]), growth)[0]
        rest = pieces.part(slice(steps, None))
        more, _, ended = _march(slabs, port, memory, Limits(_NEWTON, resolution, growth), stretch, rest, drive)
        steps, missing = steps + more, {int(memory.levels[NEXT])}
    if memory.now[TIME] < period - SAME:
        raise _failure(slabs, float(memory.now[TIME]), period)
    levels = np.rint(np.log2(port.length[0] / pieces.length[:steps])).astype(np.int64)
    return Mesh(count, levels, longest, resolution, growth)


def _begin(slabs: Slabs, port: Port, start: Array, level: int) -> Memory:
    """Memory of a march from the state `start`, whose first step has the length of `level`."""
    scene, stages = slabs.scene, slabs.stages
    port.values[: slabs.remembered] = start[:-1]
    prepared(slabs, port, [level])
    incoming = port.steady[level] + port.values @ port.free[level]
    z, impedance = unknown_of(scene.law, scene.velocity), float(port.impedance[level, 0].sum())
    guess, _ = first_guess(rule_of(stages)[2], scene.law, impedance, incoming, start[-1], z)
    memory = begin(start[-1], scene.steady_stress, float(guess.z[0]), stages)
    memory.levels[NEXT] = level
    return memory


def _march(
    slabs: Slabs, port: Port, memory: Memory, limits: Limits, stretch: Stretch, pieces: Pieces, drive: Constant
) -> tuple[int, int, int]:
    """`march` under a constant `drive`."""
    scene, (_, rule, nodes) = slabs.scene, rule_of(slabs.stages)
    physics = Physics(scene.law, scene.forcing._replace(nudge=0.0), drive, rule)
    return march(nodes, physics, port, memory, nodal_of(slabs.stages), limits, stretch, pieces)


def _failure(slabs: Slabs, time: float, period: float) -> NumericsError:
    """Error for a march without a solvable step at `time` of `period` (transits)."""
    scene = slabs.scene
    return NumericsError(
        f"{slabs.model}: the step at {time:.6g} of {period:.6g} transits cannot be solved (scene {scene.name!r}, digest "
        f"{scene.digest})"
    )
