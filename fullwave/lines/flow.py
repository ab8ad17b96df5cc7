"""A grid over one period (`Flow`), propagated exactly between friction's steps: the semi-discrete full wave's own motion."""

import math
from collections.abc import Callable

import numpy as np

from fullwave.lines.blocks import state_size
from fullwave.lines.exact import LONGEST, STAGES, ExactMarch
from fullwave.lines.kernel import STEPS_PER_PIECE
from fullwave.lines.march import MethodOfLines
from fullwave.lines.matrix import motion_of
from fullwave.lines.propagator import LinearSlabs, impedance_at, to_legendre
from fullwave.lines.step_maps import StepMaps, at_nodes
from fullwave.lines.system import ELASTIC, System
from fullwave.lines.system import PSI as SCALAR_PSI
from slipwave.errors import SceneError
from slipwave.observe.pieces import Array
from slipwave.observe.solver import State
from slipwave.scene import Scene
from slipwave.step.collocation import radau
from slipwave.step.flow import Cycle, Flow
from slipwave.step.linear_port import LinearPort, blank_port
from slipwave.step.march import PSI
from slipwave.step.place import Place, stepper_state
from slipwave.step.port_flow import flow_near
from slipwave.threads import one_thread


class GridResponse:
    """`Response` of the grid that `grid` makes for `scene`. It remembers the values that the exact march propagates, times the
    impedance eps of the upper slab, i.e. as stresses."""

    stages = STAGES

    def __init__(self, scene: Scene, grid: Callable[[Scene], System], model: str) -> None:
        self.scene, self.model, self._grid = scene, model, grid
        system = grid(scene)
        motion, size = motion_of(system), state_size(system)
        slots = motion.moving
        self._slabs = LinearSlabs(
            motion.rates[np.ix_(slots, slots)],
            motion.rates[slots, size : size + 1],
            motion.stress[None, slots],
            motion.stress[None, size : size + 1],
            (STAGES,),
            (STAGES,),
        )
        self.remembered, self._impedance = slots.size, scene.upper.epsilon
        self._to_legendre = to_legendre(radau(STAGES).nodes)
        self._maps: tuple[float, StepMaps] | None = None

    def of(self, scene: Scene) -> "GridResponse":
        """As `Response`."""
        return GridResponse(scene, self._grid, self.model)

    def port(self, longest: float, levels: int) -> LinearPort:
        """As `Response`."""
        return blank_port(self.scene.forcing, longest, levels, self.remembered, STAGES)

    def prepare(self, port: LinearPort, level: int) -> None:
        """As `Response`."""
        with one_thread():
            step = self._maps_of(float(port.length[0])).find(level)
        free, stress, gain = at_nodes(step, STAGES, self._to_legendre)
        port.impedance[level], port.free[level] = -stress, free.T / self._impedance
        port.change[level], port.gain[level] = step.change.T, gain.T * self._impedance
        port.ready[level] = True

    def resistance(self, port: LinearPort, level: int, growth: float) -> float:
        """As `Response`."""
        with one_thread():
            return impedance_at(self._slabs, growth / float(port.length[level]))

    def state(self, values: Array, psi: float) -> Array:
        """The state with the `values` that the exact march propagates, and psi."""
        return np.append(values * self._impedance, psi)

    def values(self, state: Array) -> Array:
        """The inverse of `state`, but for psi."""
        return np.asarray(state[:-1] / self._impedance)

    def _maps_of(self, longest: float) -> StepMaps:
        """Those of the last length are kept: of a port, shorter steps may be needed later."""
        if self._maps is None or self._maps[0] != longest:
            self._maps = longest, StepMaps(self._slabs, None, longest)
        return self._maps[1]


def frozen(solver: MethodOfLines, period: float, tolerance: float) -> tuple[Flow, Array]:
    """The flow of `solver`, which marches exactly, on a mesh that suits the next `period` (transits) to `tolerance`, and its
    present state. Raises SceneError if it marches explicitly."""
    if solver.settings["time"] != ExactMarch.name:
        raise SceneError(f"{solver.model}: time = {solver.settings['time']!r}: a flow over a period needs time = exact")
    response = GridResponse(solver.scene, solver.system_of, solver.model)
    memory = solver.state()
    state = response.state(memory["values"], float(memory["now"][PSI]))
    return flow_near(response, state, period, tolerance, LONGEST), state


def placed(solver: MethodOfLines, cycle: Cycle, place: Place) -> State:
    """The state of `solver`, which may march exactly or explicitly, at the start of `cycle`, a motion of the exact march."""
    values = GridResponse(solver.scene, solver.system_of, solver.model).values(cycle.start)
    if solver.settings["time"] == ExactMarch.name:
        return stepper_state(solver.state(), place) | {"values": values}
    return explicit_state(solver, values, place)


def explicit_state(solver: MethodOfLines, values: Array, place: Place) -> State:
    """The same for the explicit march, at the end of its first piece beyond the time of `place`."""
    system, saved = solver.system, solver.state()
    whole = np.zeros_like(saved["state"])
    whole[motion_of(system).moving] = values
    whole[system.interface.size + SCALAR_PSI], whole[system.interface.size + ELASTIC] = place.psi, place.elastic
    pieces = math.ceil(place.time / solver.transits_per_piece - 1e-9)
    counts = np.array([STEPS_PER_PIECE * pieces, 0.0])
    return {"counts": counts, "state": whole, "unknowns": np.full_like(saved["unknowns"], place.z)}
