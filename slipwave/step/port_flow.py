"""The motion over one period (`Flow`) of every model that friction meets as a port: reductions and grids propagated exactly.

Steps are fixed fractions of the period, 1/count and its halves (`flow_mesh`). A march over another period makes the tables of the
scaled lengths, so that the end is a smooth function of the period.
"""

import math

import numpy as np

from slipwave.errors import SceneError
from slipwave.observe.pieces import Array, empty_pieces
from slipwave.scene import Scene
from slipwave.solve import State
from slipwave.step.carry import carry
from slipwave.step.collocation import growth_limit, rule_of
from slipwave.step.flow import Cycle, velocity_by_difference
from slipwave.step.flow_mesh import NEWTON, Mesh, begin_at, failure, march_on, mesh_of
from slipwave.step.impedance import full_impedance
from slipwave.step.march import DONE, TIME, Limits, resolution_of
from slipwave.step.port import Port, Slabs
from slipwave.threads import one_thread

_FINEST = 1e-12  # highest coefficient that rounding errors leave meaningful


class PortFlow:
    """The motion of `slabs` on `mesh`. A state is what the slabs remember, then psi."""

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

    def march(self, start: Array, period: float) -> Cycle:
        """As `Flow`."""
        port = self._port(period)
        memory = begin_at(self._slabs, port, start, int(self.mesh.levels[0]))
        pieces = empty_pieces(self.mesh.levels.size, self.nodes.size)
        limits = Limits(NEWTON, math.inf, math.inf, np.zeros(port.length.size))
        _, iterations, ended = march_on(self._slabs, port, memory, math.inf, limits, self.mesh.levels, pieces)
        end = np.append(port.values[: self.size - 1], pieces.psi[-1, -1])
        if ended != DONE or not np.isfinite(end).all():
            raise failure(self._slabs, float(memory.now[TIME]), period)
        return Cycle(period, start, end, pieces, iterations)

    def velocity(self, cycle: Cycle) -> Array:
        """As `Flow`."""
        return velocity_by_difference(self, cycle)

    def tangent(self, cycle: Cycle) -> Array:
        """As `Flow`."""
        return self._carry(cycle, False)

    def frozen_tangent(self, cycle: Cycle) -> Array:
        """As `Flow`."""
        return self._carry(cycle, True)

    def essential_radius(self, cycle: Cycle) -> float:
        """As `Flow`: what a port remembers is finite."""
        return 0.0

    @property
    def idle(self) -> Array:
        """As `Flow`: a port remembers nothing that the interface does not feel, but for grids of unlike slabs with one round
        trip."""
        return np.zeros((self.size, 0))

    @property
    def undecided(self) -> bool:
        """As `Flow`."""
        return False

    def of(self, scene: Scene) -> "PortFlow":
        """As `Flow`. Raises SceneError if the model of `scene` remembers another number of values."""
        slabs = self._slabs.of(scene)
        if slabs.remembered != self._slabs.remembered:
            raise SceneError(
                f"{self.model}: it remembers {slabs.remembered} values in scene {scene.name!r}, but "
                f"{self._slabs.remembered} in {self.scene.name!r}"
            )
        return PortFlow(slabs, self.mesh)

    def remeshed(self, cycle: Cycle, finer: float) -> "tuple[PortFlow, Array]":
        """As `Flow`. All lengths that a step may have, and the length that fits any motion, are shorter by `finer`."""
        mesh, order = self.mesh, self.nodes.size - 1
        longest, resolution = mesh.longest / finer, max(mesh.resolution / finer**order, _FINEST)
        return PortFlow(
            self._slabs, mesh_of(self._slabs, cycle.start, cycle.period, longest, resolution, mesh.growth / finer)
        ), cycle.start

    def roughness(self, cycle: Cycle, tolerance: float) -> float:
        """As `Flow`."""
        largest = max(float(np.abs(values @ self._rule.tail).max()) for values in (cycle.pieces.z, cycle.pieces.psi))
        return largest / resolution_of(tolerance, self.nodes.size)

    def _port(self, period: float) -> Port:
        """The port of the steps of `period`; it remembers what it likes. The last one is kept for the tangent."""
        longest, levels = period / self.mesh.count, self.mesh.levels
        if self._made is None or self._made.length[0] != longest:
            self._made = self._slabs.port(longest, int(levels.max()) + 1)
            for level in np.unique(levels)[::-1]:
                if not self._made.ready[level]:
                    self._slabs.prepare(self._made, int(level))
        return self._made

    def _carry(self, cycle: Cycle, frozen: bool) -> Array:
        """Derivative of the end with respect to the start."""
        port, changes = self._port(cycle.period), np.eye(self.size)
        values, psi = np.zeros((self.size, port.values.size)), changes[:, -1].copy()
        values[:, : self.size - 1] = changes[:, :-1]
        law, transit, pieces = self.scene.law, self.scene.transit, cycle.pieces
        steps = (port, full_impedance(self.nodes.size), transit, self._rule.integral, self.mesh.levels)
        with one_thread():
            carry(self._shape, law, *steps, pieces.z, pieces.psi, frozen, values, psi)
        return np.column_stack([values[:, : self.size - 1], psi]).T


def flow_near(slabs: Slabs, start: Array, period: float, tolerance: float, longest: float) -> PortFlow:
    """A flow whose mesh suits the motion from `start` over `period` (transits) to `tolerance`, the relative error of the figures
    of a cycle, with steps not above `longest` (transits)."""
    resolution, growth = resolution_of(tolerance, slabs.stages), growth_limit(slabs.stages, tolerance)
    return PortFlow(slabs, mesh_of(slabs, start, period, longest, resolution, growth))
