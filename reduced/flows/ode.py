"""An ODE reduction over one period (`Flow`): its response to the slip rate as one linear map for each step length."""

from collections.abc import Callable

import numpy as np

from reduced.impedance.reduce import reduction_of
from reduced.ode.march import LONGEST, ReducedModel
from reduced.ode.port import SLIP_RATE, SPRING, ReducedPort
from reduced.ode.reduction import Reduction
from reduced.ode.step_tables import impedance_at, step_port
from slipwave.observe.pieces import Array
from slipwave.observe.solver import State
from slipwave.scene import Scene
from slipwave.step.collocation import Collocation, radau
from slipwave.step.flow import Cycle, Flow
from slipwave.step.linear_port import LinearPort, blank_port
from slipwave.step.march import PSI
from slipwave.step.place import Place, stepper_state
from slipwave.step.port_flow import flow_near


class ReducedResponse:
    """`Response` of the reduction that `reduce` makes of `scene`. It remembers the spring's stress and the slip rate times the
    upper slab's impedance, if there are a spring and a mass, then tau of all modes, and p of those that have it."""

    def __init__(self, scene: Scene, reduce: Callable[[Scene], Reduction], stages: int) -> None:
        self.scene, self.stages, self._reduce = scene, stages, reduce
        self.reduction = reduce(scene)
        self.model = self.reduction.name
        self._rule = radau(stages)
        self.kept = _kept(self.reduction)
        self.remembered = int(self.kept.sum())

    def of(self, scene: Scene) -> "ReducedResponse":
        """As `Response`."""
        return ReducedResponse(scene, self._reduce, self.stages)

    def port(self, longest: float, levels: int) -> LinearPort:
        """As `Response`; all tables are made at once."""
        tables = step_port(self.reduction, self.scene.upper.epsilon, self._rule, levels, longest)
        port = blank_port(self.scene.forcing, longest, levels, self.remembered, self.stages)
        port.ready[:] = True
        port.impedance[:] = tables.impedance
        free, change, gain = _linear_maps(tables, self._rule)
        free[:, SLIP_RATE] /= self.scene.upper.epsilon
        gain[:, :, SLIP_RATE] *= self.scene.upper.epsilon
        port.free[:] = free[:, self.kept]
        port.change[:] = change[:, self.kept][:, :, self.kept]
        port.gain[:] = gain[:, :, self.kept]
        return port

    def prepare(self, port: LinearPort, level: int) -> None:
        """As `Response`."""

    def resistance(self, port: LinearPort, level: int, growth: float) -> float:
        """As `Response`."""
        return self.scene.upper.epsilon * float(impedance_at(self.reduction, growth / port.length[[level]])[0])

    def state(self, spring: float, slip_rate: float, modes: Array, psi: float) -> Array:
        """The state with the stress of the spring, the slip rate, tau and p of the `modes` (N, 2), and psi."""
        face = [spring - self.scene.steady_stress, self.scene.upper.epsilon * (slip_rate - self.scene.velocity)]
        return np.append(np.concatenate([face, modes.T.ravel()])[self.kept], psi)

    def memory(self, state: Array) -> tuple[Array, Array]:
        """The inverse of `state`, but for psi: `face` (spring's stress and slip rate) and `modes` (N, 2) of a `ReducedModel`."""
        values = np.zeros(self.kept.size)
        values[self.kept] = state[:-1]
        spring, slip_rate = values[:2].tolist()
        face = np.array([spring + self.scene.steady_stress, slip_rate / self.scene.upper.epsilon + self.scene.velocity])
        return face, values[2:].reshape(2, -1).T


def frozen(solver: ReducedModel, period: float, tolerance: float) -> tuple[Flow, Array]:
    """The flow of `solver` on a mesh that suits the next `period` (transits) to `tolerance`, and its present state."""
    scene, name, known = solver.scene, solver.model, solver.reduction

    def reduce(other: Scene) -> Reduction:
        """The reduction of a scene of the family; that of the solver serves where the slabs are the same."""
        return known if other.slabs == scene.slabs and other.transit == scene.transit else reduction_of(other, name)

    response = ReducedResponse(scene, reduce, solver.nodes.size)
    memory = solver.state()
    face, psi = memory["face"], float(memory["now"][PSI])
    state = response.state(float(face[SPRING]), float(face[SLIP_RATE]), memory["modes"], psi)
    return flow_near(response, state, period, tolerance, LONGEST), state


def placed(solver: ReducedModel, cycle: Cycle, place: Place) -> State:
    """The state of `solver` at the start of `cycle`, which is one of its own flows."""
    response = ReducedResponse(solver.scene, lambda _: solver.reduction, solver.nodes.size)
    face, modes = response.memory(cycle.start)
    return stepper_state(solver.state(), place) | {"face": face, "modes": modes}


def _kept(reduction: Reduction) -> Array:
    """Which of spring, slip rate, tau and p are states; a relaxation has no p."""
    modes, extra = len(reduction.frequencies), len(reduction.relaxations)
    moving = [bool(omega or offset) for omega, offset in zip(reduction.frequencies, reduction.offsets, strict=True)]
    return np.array([reduction.spring != 0.0, not reduction.is_algebraic, *[True] * (modes + extra), *moving, *[False] * extra])


def _linear_maps(tables: ReducedPort, rule: Collocation) -> tuple[Array, Array, Array]:
    """`free`, `change` and `gain` (`LinearPort`) of all that a `ReducedPort` may remember: spring, slip rate, tau, p."""
    levels, stages, count = tables.length.size, rule.nodes.size, tables.offset.size
    moved = tables.length[:, None] * rule.integral[-1]  # integral over the step from nodal values
    tau, momentum = slice(2, 2 + count), slice(2 + count, 2 + 2 * count)
    free = np.empty((levels, 2 + 2 * count, stages))
    free[:, SPRING], free[:, SLIP_RATE] = 1.0, tables.inertia
    free[:, tau], free[:, momentum] = tables.free[:, :, 0], tables.free[:, :, 1]
    change, gain = np.zeros((levels, 2 + 2 * count, 2 + 2 * count)), np.zeros((levels, stages, 2 + 2 * count))
    change[:, SLIP_RATE, SLIP_RATE], gain[:, -1, SLIP_RATE] = -1.0, 1.0
    gain[:, :, SPRING] = -tables.spring * moved
    for n in range(count):
        for part, place in enumerate((2 + n, 2 + count + n)):
            change[:, place, 2 + n] = tables.free[:, n, part, -1]
            change[:, place, 2 + count + n] = -tables.omega_squared[n] * (tables.free[:, n, part] * moved).sum(axis=1)
        change[:, 2 + n, 2 + n] -= 1.0
        gain[:, :, 2 + n] = -tables.forced[:, n, -1]
        slipped = tables.omega_squared[n] * np.einsum("lj,ljm->lm", moved, tables.forced[:, n])
        gain[:, :, 2 + count + n] = slipped - tables.offset[n] * moved
    return free, change, gain
