"""The tables of the exact march: made for a step length when it is first needed, by doubling shorter steps."""

import math
from typing import NamedTuple

import numpy as np
import scipy.linalg

from fullwave.lines.budget import MOST_BYTES
from fullwave.lines.grid_port import GridPort, Power
from fullwave.lines.matrix import motion_of
from fullwave.lines.propagator import LinearSlabs, StepMap, impedance_at, to_legendre
from fullwave.lines.step_maps import LEVELS, StepMaps, at_nodes, maps_of
from fullwave.lines.system import DASHPOT, DEAD, System
from fullwave.lines.viscous_heat import dissipation_of
from slipwave.observe.pieces import SAME, Array
from slipwave.scene import Scene
from slipwave.step.collocation import radau
from slipwave.threads import one_thread

DRIVE_TERMS = 2
"""The drive is linear in a step."""

_MOST_KNOWN = 64
_HELD = 80  # numbers held for one longest length, over the square of the unknowns (33 measured; with viscosity 74)
_LANES = 8  # doubles in a cache line; rows of the tables begin and end with a line, otherwise a step costs twice as much


class Known(NamedTuple):
    """What is known of steps of one longest length and its halves: their `maps` and the `port`."""

    maps: StepMaps
    port: GridPort


class GridPorts:
    """The `Ports` (slipwave.step.stepper) of `system`, for steps of `stages` nodes. They remember the grid's `values`, in `slots`
    of the explicit march's layout of `size`, and the `ledger`."""

    def __init__(self, scene: Scene, system: System, size: int, stages: int) -> None:
        self._scene, self._stages = scene, stages
        with one_thread():
            motion = motion_of(system)
        self.slots = motion.moving
        dashpot = system.tops[DASHPOT]
        damped = np.flatnonzero(dashpot)
        outputs = np.vstack([motion.stress, motion.traction.sum(axis=0), system.tops[DEAD] @ motion.slip, motion.slip[damped]])
        rates = motion.rates[self.slots]
        self.slabs = LinearSlabs(
            rates[:, self.slots],
            rates[:, size:],
            outputs[:, self.slots],
            outputs[:, size:],
            (stages, DRIVE_TERMS),
            (stages, 2, 1, *[stages] * damped.size),
        )
        self._dissipation = dissipation_of(system, motion, self.slots)
        self._power = Power(system.interface.copies, system.interface.sides, dashpot[damped])
        self._padded, self.ledger = _aligned(-(-self.slots.size // _LANES) * _LANES), np.zeros(4)
        self._padded[:] = 0.0
        self.values = self._padded[: self.slots.size]
        self.keeps_ledger = np.zeros(1, dtype=np.bool_)
        self.to_legendre = to_legendre(radau(stages).nodes)
        self._known: dict[str, Known] = {}
        self._most_known = max(2, min(_MOST_KNOWN, int(MOST_BYTES / (8.0 * _HELD * self.values.size**2))))

    def keep_ledger(self) -> None:
        """From now on the `ledger` is kept."""
        if self._dissipation and not self.keeps_ledger[0]:
            for key, known in self._known.items():
                known.port.ready[:] = False  # their maps know no heat
                longest = float(known.port.length[0])
                self._known[key] = known._replace(maps=StepMaps(self.slabs, self._dissipation, longest))
        self.keeps_ledger[0] = True

    def known(self, longest: float) -> Known:
        """What is known of steps of `longest` (transits) and its halves."""
        key = f"{longest:.12e}"  # stretches of equal length differ by rounding
        dissipation = self._dissipation if self.keeps_ledger[0] else None
        known = self._known.pop(key, None) or Known(maps_of(self.slabs, dissipation, longest), self._blank(longest))
        self._known[key] = known  # the last used is the last to be forgotten
        if len(self._known) > self._most_known:
            del self._known[next(iter(self._known))]
        return known

    def port(self, longest: float) -> GridPort:
        """As `Ports`: of exactly this length, with the tables of any that differs by rounding."""
        port = self.known(longest).port
        return port._replace(length=np.ldexp(longest, -np.arange(LEVELS)))

    def _blank(self, longest: float) -> GridPort:
        n, s, m = self._padded.size, self._stages, sum(self.slabs.output_terms) - self._stages
        rows = n + 2 * s
        return GridPort(
            np.ldexp(longest, -np.arange(LEVELS)),
            np.zeros(LEVELS, dtype=np.bool_),
            np.empty((LEVELS, s, s)),
            np.empty((LEVELS, s)),
            _aligned(LEVELS, n, s),
            np.empty((LEVELS, s, s)),
            _aligned(LEVELS, rows, n),
            np.empty((LEVELS, rows, m)),
            _aligned(LEVELS, rows, rows) if self._dissipation else np.empty((0, 0, 0)),
            self._scene.forcing,
            self._power,
            self._scene.drive.is_constant,
            self.keeps_ledger,
            self._padded,
            self.ledger,
            np.zeros(rows),
            np.zeros(m),
            np.zeros(rows),
        )

    def prepare(self, port: GridPort, level: int) -> None:
        """As `Ports`."""
        known = self.known(float(port.length[0]))
        with one_thread():
            step = known.maps.find(level)
            self._tabulate(port, level, step, known.maps.heats.get(level))

    def _tabulate(self, port: GridPort, level: int, step: StepMap, heat: Array | None) -> None:
        s, n, padded = self._stages, self.values.size, self._padded.size
        inputs = scipy.linalg.block_diag(self.to_legendre, self.to_legendre[:DRIVE_TERMS])
        free, stress, forced = at_nodes(step, s, inputs)
        port.impedance[level] = -stress[:, :s]
        port.driven[level] = stress[:, s:].T
        port.steady[level] = self._scene.steady_stress + port.impedance[level].sum(axis=1) * self._scene.velocity
        for table in (port.free, port.change, port.moments):
            table[level] = 0.0
        port.free[level, :n] = free.T
        port.change[level, :n, :n], port.change[level, padded:, :n] = step.change.T, forced.T
        port.moments[level, :n], port.moments[level, padded:] = step.free[s:].T, (step.through[s:] @ inputs).T
        if heat is not None:
            spread = scipy.linalg.block_diag(np.eye(n, padded), inputs)
            port.heat[level] = spread.T @ heat @ spread
        port.ready[level] = True

    def resistance(self, port: GridPort, level: int, growth: float) -> float:
        """As `Ports`."""
        with one_thread():
            return impedance_at(self.slabs, growth / float(port.length[level]))

    def next_break(self, time: float) -> float:
        """As `Ports`: knots of the drive, and their arrivals at the interface."""
        travels = [0.5 * slab.round_trip / self._scene.transit for slab in (self._scene.upper, self._scene.lower)]
        arrivals = (knot + delay for knot in self._scene.drive.knots for delay in (0.0, *travels))
        return min((arrival for arrival in arrivals if arrival > time + SAME), default=math.inf)


def _aligned(*shape: int) -> Array:
    """An array, not initialised, that begins at a cache line."""
    size = math.prod(shape)
    memory = np.empty(size + _LANES)
    first = -(memory.ctypes.data // memory.itemsize) % _LANES
    return memory[first : first + size].reshape(shape)
