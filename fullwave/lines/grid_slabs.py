"""A grid as `Slabs` (`slipwave.step.port`), propagated exactly by tables that are made for a step length when it is first needed,
by doubling shorter steps; and its energy balance: work of the drive and heat of each step, from quantities of its port."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import scipy.linalg
from numpy.polynomial import legendre
from numpy.typing import NDArray

from fullwave.lines.blocks import state_size
from fullwave.lines.budget import MOST_BYTES
from fullwave.lines.matrix import motion_of
from fullwave.lines.propagator import LinearSlabs, StepMap, StepMaps, at_nodes, dissipation_of
from fullwave.lines.system import System
from fullwave.slabs import marched_slabs
from slipwave.compiled import njit
from slipwave.observe.pieces import SAME, Array
from slipwave.scene import Scene
from slipwave.scene.drive import Forcing
from slipwave.step.collocation import Nodes, radau
from slipwave.step.nodal import Nodal
from slipwave.step.port import LEVELS, Levels, Port, blank_port, line_aligned, padded, propagate, record
from slipwave.threads import one_thread

INPUT, FRICTION, RADIATED, VISCOUS = range(4)  # entries of `_GridLedger.entries`


_MOST_KNOWN, _FEWEST_KNOWN = 64, 2
_HELD = 80  # numbers held for one longest length, over the square of the unknowns (33 measured; with viscosity 74)


class _GridLedger(NamedTuple):
    """If `is_kept` (1,), the `entries` (4,) are summed. Per level, from (x, u, c) of the `Port`: `moments` (L, n + 2 s, m), and
    as a quadratic form viscous `heat` (L, n + 2 s, n + 2 s), empty in elastic slabs. `copies` of each marched slab; `sides`,
    their number; the `dashpots`. `taken` (m,) and `spare` (n + 2 s,) are scratch.

    The moments: of all tractions (two), of the slip at faces under a dead load, then those of each dashpot's slip (s each)."""

    is_kept: NDArray[np.bool_]
    entries: Array
    moments: Array
    heat: Array
    forcing: Forcing
    copies: float
    sides: int
    dashpots: Array
    taken: Array
    spare: Array


@record.register(_GridLedger)
def _record_step(ledger, port, nodes, level, rows, integral, nodal):  # type: ignore[no-untyped-def]
    _add_work(ledger, port, nodes, level, rows, integral, nodal)
    if ledger.heat.size:
        scale = ledger.copies * port.length[level] * ledger.forcing.transit
        ledger.entries[VISCOUS] += scale * _heat(ledger.heat, level, rows, port.vector, ledger.spare)


@njit
def _heat(heat: Array, level: int, rows: int, vector: Array, spare: Array) -> float:
    """vector . heat[level] vector."""
    for k in range(spare.size):
        spare[k] = 0.0
    propagate(heat, level, rows, vector, spare)
    total = 0.0
    for k in range(rows):
        total += vector[k] * spare[k]
    return total


@njit
def _add_work(ledger: _GridLedger, port: Port, nodes: Nodes, level: int, rows: int, integral: Array, nodal: Nodal) -> None:
    """Add the step's work of the drive, heat of friction and radiation. Friction's stress and slip rate are polynomials, and the
    drive is linear, so that their moments give their work exactly; a dashpot's slip is represented by its projection."""
    s, forcing, entries, dashpots = len(nodes), ledger.forcing, ledger.entries, ledger.dashpots
    length, moments, taken, vector = port.length[level], ledger.moments, ledger.taken, port.vector
    for k in range(taken.size):
        taken[k] = 0.0
    for i in range(rows):
        for k in range(taken.size):
            taken[k] += moments[level, i, k] * vector[i]
    heat = 0.0
    for j in range(s):
        stress = nodal.incoming[j]
        for m in range(s):
            stress -= port.impedance[level, j, m] * nodal.v[m]
        heat += integral[j, s - 1] * stress * nodal.v[j]
    entries[FRICTION] += length * forcing.transit * heat
    slope = (nodal.drive[s - 1] - nodal.drive[0]) / (nodes[s - 1] - nodes[0])
    middle = nodal.drive[s - 1] - 0.5 * slope
    done = 0.5 * (middle * (ledger.sides * forcing.steady_stress + taken[0]) + 0.5 * slope * taken[1])
    scale = ledger.copies * length * forcing.transit
    entries[INPUT] += scale * (done - forcing.steady_stress * taken[2])
    lost = 0.0
    for side in range(dashpots.size):
        for k in range(s):
            moment = taken[3 + side * s + k]
            lost += dashpots[side] * (2 * k + 1) * moment * moment
    entries[RADIATED] += scale * lost


class GridSlabs:
    """The `Slabs` (slipwave.step.port) of the grid that `grid` makes for `scene`, for steps of `stages` nodes. The memory of a
    port: the grid's values, in `slots` of the explicit march's layout, times the first marched slab's impedance, `scale`, as
    stresses. All ports share the `entries` of the energy balance. Tables of `most_known` longest steps are kept, as far as
    memory allows; with few, for flows, they answer to any drive within a step, else to those of scenes."""

    def __init__(
        self, scene: Scene, grid: Callable[[Scene], System], model: str, stages: int, most_known: int = _MOST_KNOWN
    ) -> None:
        self.scene, self.model, self.stages, self._grid = scene, model, stages, grid
        self.drive_terms = stages if most_known == _FEWEST_KNOWN else min(scene.drive.terms, stages)
        system = grid(scene)
        size, self.scale = state_size(system), marched_slabs(scene)[0].epsilon
        with one_thread():
            motion = motion_of(system)
        self.slots = motion.moving
        self.remembered = self.slots.size
        dashpot = system.tops.dashpot
        damped = np.flatnonzero(dashpot)
        outputs = np.vstack([motion.stress, motion.traction.sum(axis=0), system.tops.dead @ motion.slip, motion.slip[damped]])
        rates = motion.rates[self.slots]
        self.slabs = LinearSlabs(
            rates[:, self.slots],
            rates[:, size:],
            outputs[:, self.slots],
            outputs[:, size:],
            (stages, self.drive_terms),
            (stages, 2, 1, *[stages] * damped.size),
        )
        self._dissipation = dissipation_of(system, motion, self.slots)
        self._power = system.interface.copies, system.interface.sides, dashpot[damped]
        self.entries, self.is_kept = np.zeros(4), np.zeros(1, dtype=np.bool_)
        # coefficients of the polynomial with given values at the nodes, (stages, stages)
        self.to_legendre = np.linalg.inv(legendre.legvander(2.0 * radau(stages).nodes - 1.0, stages - 1))
        self._known: dict[str, tuple[StepMaps, Port]] = {}
        self._most_known = max(_FEWEST_KNOWN, min(most_known, int(MOST_BYTES / (8.0 * _HELD * self.remembered**2))))

    def of(self, scene: Scene) -> "GridSlabs":
        """As `Slabs`; few tables are kept, because a flow makes tables for many periods."""
        return GridSlabs(scene, self._grid, self.model, self.stages, _FEWEST_KNOWN)

    def keep_ledger(self) -> None:
        """Start to keep the energy balance."""
        if self._dissipation and not self.is_kept[0]:
            for key, (_, port) in self._known.items():
                port.ready[:] = False  # their maps lack the heat
                self._known[key] = StepMaps(self.slabs, self._dissipation, float(port.length[0])), port
        self.is_kept[0] = True

    def tables(self, longest: float) -> tuple[StepMaps, Port]:
        """Maps and port of steps of `longest` (transits) and its halves. Lengths that differ by rounding share tables of one
        length that does not depend on their order: a run that continues from a checkpoint sees only the later ones."""
        key = f"{longest:.12e}"
        longest = float(key)
        dissipation = self._dissipation if self.is_kept[0] else None
        known = self._known.pop(key, None) or (StepMaps(self.slabs, dissipation, longest), self._blank(longest))
        self._known[key] = known  # the least recently used is dropped first
        if len(self._known) > self._most_known:
            del self._known[next(iter(self._known))]
        return known

    def port(self, longest: float, levels: int = LEVELS) -> Port:
        """As `Slabs`: with exactly this length, the tables of a length that differs by rounding, and all `LEVELS`."""
        _, port = self.tables(longest)
        values = line_aligned(port.values.size)
        return port._replace(length=np.ldexp(longest, -np.arange(port.length.size)), values=values)

    def _blank(self, longest: float) -> Port:
        port = blank_port(self.scene, longest, LEVELS, self.remembered, self.stages)
        rows, m = port.vector.size, sum(self.slabs.output_terms) - self.stages
        heat = line_aligned(LEVELS, rows, rows) if self._dissipation else np.empty((0, 0, 0))
        moments = np.zeros((LEVELS, rows, m))
        ledger = (self.is_kept, self.entries, moments, heat, self.scene.forcing, *self._power, np.zeros(m), np.zeros(rows))
        return port._replace(ledger=_GridLedger(*ledger))

    def prepare(self, port: Port, level: int) -> None:
        """As `Slabs`."""
        maps, _ = self.tables(float(port.length[0]))
        with one_thread():
            step = maps.find(level)
            self._tabulate(port, level, step, maps.heats.get(level))

    def _tabulate(self, port: Port, level: int, step: StepMap, heat: Array | None) -> None:
        s, n, begin, scale = self.stages, self.remembered, padded(self.remembered), self.scale
        # each face takes half of a change of the drive
        inputs = scipy.linalg.block_diag(self.to_legendre, 0.5 * self.to_legendre[: self.drive_terms])
        free, stress, forced = at_nodes(step, s, inputs)
        port.impedance[level], port.driven[level] = -stress[:, :s], stress[:, s:].T
        port.steady[level] = self.scene.steady_stress + port.impedance[level].sum(axis=1) * self.scene.velocity
        port.free[level, :n] = free.T / scale
        port.change[level, :n, :n], port.change[level, begin:, :n] = step.change.T, scale * forced.T
        moments = port.ledger.moments[level]
        moments[:n], moments[begin:] = step.free[s:].T / scale, (step.through[s:] @ inputs).T
        if heat is not None:
            spread = scipy.linalg.block_diag(np.eye(n, begin) / scale, inputs)
            port.ledger.heat[level] = spread.T @ heat @ spread
        port.ready[level] = True

    def resistance(self, port: Port, levels: Levels, growth: float) -> Array:
        """As `Slabs`."""
        with one_thread():
            return np.array([self.slabs.impedance(growth / length) for length in port.length[levels].tolist()])

    @property
    def follows_drive(self) -> bool:
        """As `Slabs`."""
        return True

    def next_break(self, time: float) -> float:
        """As `Slabs`: knots of the drive, and their arrivals at the interface."""
        travels = [0.5 * slab.round_trip / self.scene.transit for slab in (self.scene.upper, self.scene.lower)]
        return min(self.scene.drive.knot_after(time + SAME - delay) + delay for delay in (0.0, *travels))
