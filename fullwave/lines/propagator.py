"""The semi-discrete slabs propagated exactly in time over one step.

With the slip rate u = v - V_0 and the change c of the drive (both polynomials in the step), `fullwave.lines.matrix` gives

    x' = L x + b u + d c,      y = C x + D_u u + D_c c,

y: the stress at the interface and the quantities of the energy balance. Inputs and outputs are taken by their coefficients in
Legendre polynomials P_k(2 tau - 1) on the step: powers of tau would lose five digits. An output is represented by its moments

    m_k = integral of P_k(2 tau - 1) y over tau = 0..1,

i.e. by its L2 projection onto the polynomials. Values at nodes instead would make the coupled step unstable for weak friction.
The map (x, inputs) -> (change of x, moments) of a very short step is a Taylor series (`_short_step`); that of a step twice as
long follows from it by products of matrices (`_doubled_map`). The change of x is computed instead of x at the end: next to 1,
e^(h L) - 1 of slow modes would lose its digits, and doubling would multiply the error.

Dissipated power is a quadratic form in (x, u, c). Over a step x is linear in y = (x at its start, coefficients a), so the viscous
heat of a step is y^T G y with one symmetric matrix G for each step length; that of a step twice as long follows as for the map.
`_StepMaps` makes the maps of one longest length and its halves when they are first needed, and `GridSlabs` from these the tables
of a port (`slipwave.step.port`), with its energy balance: work of the drive and heat of each step.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple, TypeAlias

import numpy as np
import scipy.linalg
import scipy.special
from numpy.polynomial import legendre
from numpy.typing import NDArray

from fullwave.lines.blocks import state_size
from fullwave.lines.budget import MOST_BYTES
from fullwave.lines.matrix import LinearMotion, motion_of
from fullwave.lines.system import SCALARS, System, Viscous
from fullwave.slabs import marched_slabs
from slipwave.compiled import njit
from slipwave.observe.pieces import SAME, Array
from slipwave.scene import Scene
from slipwave.scene.drive import Forcing
from slipwave.step.collocation import Nodes, from_moments, radau
from slipwave.step.nodal import Nodal
from slipwave.step.port import LEVELS, Levels, Port, line_aligned, padded, propagate, record
from slipwave.threads import one_thread

_SMALL = 0.5  # largest norm of length * L in a Taylor series
_TERMS = 16  # 0.5^17/17! is 2e-20

_MOST_KNOWN, _FEWEST_KNOWN = 64, 2
_HELD = 80  # numbers held for one longest length, over the square of the unknowns (33 measured; with viscosity 74)


@dataclass(frozen=True)
class _LinearSlabs:
    """`rates` L (n, n); `inputs` (n, i), one column per input; `outputs` (o, n) and `direct` (o, i); `input_terms` and
    `output_terms`: numbers of Legendre coefficients of every input and moments of every output."""

    rates: Array
    inputs: Array
    outputs: Array
    direct: Array
    input_terms: tuple[int, ...]
    output_terms: tuple[int, ...]

    def impedance(self, s: float) -> float:
        """Z(s) for real s > 0 (1/transit): minus the response of the first output, the stress, to the first input, the slip
        rate."""
        moved = np.linalg.solve(s * np.eye(self.rates.shape[0]) - self.rates, self.inputs[:, 0])
        return -float(self.direct[0, 0] + self.outputs[0] @ moved)


@dataclass(frozen=True)
class _StepMap:
    """One step: x(end) - x = `change` x + `forced` a and m = `free` x + `through` a, with the coefficients a (p,) of all inputs
    and the moments m (q,) of all outputs, one after the other."""

    change: Array
    forced: Array
    free: Array
    through: Array


def _shortest_halving(slabs: _LinearSlabs, length: float) -> int:
    """Number of halvings of a step of `length` (transits) after which `_short_step` is accurate to rounding."""
    size = float(np.abs(slabs.rates).sum(axis=0).max()) * length
    return max(0, int(np.ceil(np.log2(size / _SMALL)))) if size > 0.0 else 0


def _short_step(slabs: _LinearSlabs, length: float) -> _StepMap:
    """The map of a step of `length` (transits) so short that the norm of length * L is at most 1/2, by Taylor series."""
    step = length * slabs.rates
    inputs, outputs = [length * slabs.inputs], [slabs.outputs]
    for _ in range(1, _TERMS):
        inputs.append(step @ inputs[-1])
        outputs.append(outputs[-1] @ step)
    markov = np.array([slabs.outputs @ power for power in inputs])
    most_in, most_out = max(slabs.input_terms), max(slabs.output_terms)
    entering, leaving, passing = _taylor_weights(most_in, most_out)
    forced = [np.einsum("mn,mk->nk", [power[:, i] for power in inputs], entering[:, :k]) for i, k in enumerate(slabs.input_terms)]
    free = [np.einsum("mn,mk->kn", [power[o] for power in outputs], leaving[:, :k]) for o, k in enumerate(slabs.output_terms)]
    overlap = np.diag(1.0 / (2.0 * np.arange(max(most_in, most_out)) + 1.0))
    through = [
        [
            slabs.direct[o, i] * overlap[:rows, :columns] + np.einsum("m,mkl->kl", markov[:, o, i], passing[:, :rows, :columns])
            for i, columns in enumerate(slabs.input_terms)
        ]
        for o, rows in enumerate(slabs.output_terms)
    ]
    return _StepMap(_grown(step), np.hstack(forced), np.vstack(free), np.block(through))


def _grown(step: Array) -> Array:
    """e^step - 1 by Taylor series, in six products instead of fifteen (Paterson and Stockmeyer, SIAM J. Comput. 2, 1973)."""
    powers = [np.eye(step.shape[0]), step, step @ step]
    powers.append(step @ powers[2])
    fourth = powers[2] @ powers[2]
    change = fourth / math.factorial(_TERMS)
    for least in range(_TERMS - 4, 0, -4):
        change = fourth @ (change + sum(power / math.factorial(least + k) for k, power in enumerate(powers)))
    return change + sum(power / math.factorial(k) for k, power in enumerate(powers) if k)


@cache
def _taylor_weights(most_in: int, most_out: int) -> tuple[Array, Array, Array]:
    """Integrals over the step of t^m/m! against Legendre polynomials: for inputs, with t the time left (m, k); for outputs, with
    t the time since the start (m, k); for both, with t the time between them (m, k, l)."""
    points, weights = legendre.leggauss(_TERMS // 2 + max(most_in, most_out) + 1)
    times, weights = 0.5 * (points + 1.0), 0.5 * weights
    factorials = scipy.special.factorial(np.arange(_TERMS))[:, None]
    powers = times ** np.arange(_TERMS)[:, None] / factorials
    late = weights[:, None] * legendre.legvander(points, most_out - 1)
    entering = powers[:, ::-1] @ (weights[:, None] * legendre.legvander(points, most_in - 1))
    passing = np.zeros((_TERMS, most_out, most_in))
    for time, row in zip(times, late, strict=True):
        early = weights[:, None] * legendre.legvander(2.0 * time * times - 1.0, most_in - 1)
        inner = (time * (1.0 - times)) ** np.arange(_TERMS)[:, None] / factorials @ early
        passing += time * row[None, :, None] * inner[:, None, :]
    return entering, powers @ late, passing


def _doubled_map(slabs: _LinearSlabs, half: _StepMap) -> _StepMap:
    """The map of a step twice as long as that of `half`: exact, because polynomials on the step are polynomials on its halves."""
    first, second = halves(slabs.input_terms)
    early, late = (0.5 * half.T for half in halves(slabs.output_terms))
    forced = half.forced @ first
    return _StepMap(
        2.0 * half.change + half.change @ half.change,
        forced + half.change @ forced + half.forced @ second,
        early @ half.free + late @ (half.free + half.free @ half.change),
        early @ half.through @ first + late @ (half.free @ forced + half.through @ second),
    )


@cache
def halves(terms: tuple[int, ...]) -> tuple[Array, Array]:
    """Coefficients of all inputs or outputs on the first and on the second half of a step from those on the whole."""
    first, second = (np.asarray(scipy.linalg.block_diag(*[_on_half(count)[k] for count in terms])) for k in (0, 1))
    return first, second


@cache
def _on_half(terms: int) -> tuple[Array, Array]:
    """Coefficients on the first and on the second half from those on the whole step."""
    points = legendre.leggauss(terms)[0]
    back = np.linalg.inv(legendre.legvander(points, terms - 1))
    first, second = (np.asarray(back @ legendre.legvander(0.5 * (points + side), terms - 1)) for side in (-1.0, 1.0))
    return first, second


_Dissipation: TypeAlias = tuple[Array, Array]
"""Power = sum over k of weight_k (rows_k . (x, u, c))^2: rows (k, n + i), weight (k,)."""


def _short_heat(slabs: _LinearSlabs, power: _Dissipation, length: float) -> Array:
    """G of a step so short that a Taylor series holds (`_short_step`), by Gauss quadrature in time."""
    n, terms = slabs.rates.shape[0], slabs.input_terms
    points, weights = legendre.leggauss(_TERMS // 2 + max(terms))
    points, weights = 0.5 * (points + 1.0), 0.5 * weights
    step = length * slabs.rates
    free = [np.eye(n)]
    for m in range(1, _TERMS):
        free.append(step @ free[-1] / m)
    series = np.stack(free)
    driven = series @ (length * slabs.inputs)
    form = np.zeros((n + sum(terms), n + sum(terms)))
    for point, weight, powers in zip(points, weights, np.vander(points, _TERMS, increasing=True), strict=True):
        past = point * points
        left = np.tensordot(np.vander(point - past, _TERMS, increasing=True), driven, axes=1)
        moved = np.tensordot(point * weights, left @ _values(terms, past), axes=1)
        now = np.block([[np.tensordot(powers, series, axes=1), moved], [np.zeros((len(terms), n)), _values(terms, point)]])
        rows = power[0] @ now
        form += weight * rows.T @ (power[1][:, None] * rows)
    return form


def _doubled_heat(slabs: _LinearSlabs, half: _StepMap, heat: Array) -> Array:
    """G of a step twice as long as that of `half`, whose own is `heat`."""
    n = slabs.rates.shape[0]
    first, second = halves(slabs.input_terms)
    early = scipy.linalg.block_diag(np.eye(n), first)
    late = scipy.linalg.block_diag(np.eye(n) + half.change, second)
    late[:n, n:] = half.forced @ first
    form: Array = 0.5 * (early.T @ heat @ early + late.T @ heat @ late)
    return form


def _values(terms: tuple[int, ...], time: Array | float) -> Array:
    """(..., i, p): values of the inputs at `time` (...) in [0, 1] from their coefficients."""
    values = np.zeros((*np.shape(time), len(terms), sum(terms)))
    begin = 0
    for row, count in enumerate(terms):
        values[..., row, begin : begin + count] = legendre.legvander(2.0 * np.asarray(time) - 1.0, count - 1)
        begin += count
    return values


class _StepMaps:
    """Maps of `slabs` in steps of `longest` (transits) / 2^level, and, with a `dissipation`, the `heats`, by level."""

    def __init__(self, slabs: _LinearSlabs, dissipation: _Dissipation | None, longest: float) -> None:
        self._slabs, self._dissipation, self._longest = slabs, dissipation, longest
        self._maps: dict[int, _StepMap] = {}
        self.heats: dict[int, Array] = {}

    def find(self, level: int) -> _StepMap:
        """The map of a level, from the Taylor series or by doubling the map of half the length; bit-identical, whatever levels
        were computed before."""
        with one_thread():
            series = min(LEVELS - 1, _shortest_halving(self._slabs, self._longest))
            if max(level, series) not in self._maps:
                self._begin(max(level, series))
            for k in range(series, level, -1):
                if k - 1 not in self._maps:
                    self._maps[k - 1] = _doubled_map(self._slabs, self._maps[k])
                    if self._dissipation:
                        self.heats[k - 1] = _doubled_heat(self._slabs, self._maps[k], self.heats[k])
        return self._maps[level]

    def _begin(self, level: int) -> None:
        """Make the map of `level` from a step short enough for the Taylor series."""
        length = math.ldexp(self._longest, -level)
        extra = _shortest_halving(self._slabs, length)
        first = math.ldexp(length, -extra)
        step = _short_step(self._slabs, first)
        heat = _short_heat(self._slabs, self._dissipation, first) if self._dissipation else None
        for _ in range(extra):
            heat = _doubled_heat(self._slabs, step, heat) if heat is not None else None
            step = _doubled_map(self._slabs, step)
        self._maps[level] = step
        if heat is not None:
            self.heats[level] = heat


INPUT, FRICTION, RADIATED, VISCOUS = range(4)  # entries of `_GridLedger.entries`


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


def _dissipation_of(system: System, motion: LinearMotion, slots: NDArray[np.int64]) -> _Dissipation | None:
    """The dissipated power in the marched slabs per transit, for the grid's values in `slots`; None in elastic slabs."""
    medium = system.medium
    if not isinstance(medium, Viscous):
        return None
    columns = np.r_[slots, motion.rates.shape[0], motion.rates.shape[0] + 1]
    retarded, relaxing = np.flatnonzero(medium.retardation), np.flatnonzero(medium.rate)
    memory = np.eye(motion.rates.shape[0], motion.rates.shape[1])[system.interface.size + SCALARS + relaxing]
    rows = np.vstack([motion.rates[retarded], memory])[:, columns]
    weights = medium.weight[retarded] * medium.retardation[retarded]
    relaxed = medium.weight[relaxing] * medium.rate[relaxing] / medium.fraction[relaxing]
    return rows, np.concatenate([weights, relaxed])


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
        self.slabs = _LinearSlabs(
            rates[:, self.slots],
            rates[:, size:],
            outputs[:, self.slots],
            outputs[:, size:],
            (stages, self.drive_terms),
            (stages, 2, 1, *[stages] * damped.size),
        )
        self._dissipation = _dissipation_of(system, motion, self.slots)
        self._power = system.interface.copies, system.interface.sides, dashpot[damped]
        self.entries, self.is_kept = np.zeros(4), np.zeros(1, dtype=np.bool_)
        # coefficients of the polynomial with given values at the nodes, (stages, stages)
        self.to_legendre = np.linalg.inv(legendre.legvander(2.0 * radau(stages).nodes - 1.0, stages - 1))
        self._known: dict[str, tuple[_StepMaps, Port]] = {}
        self._most_known = max(_FEWEST_KNOWN, min(most_known, int(MOST_BYTES / (8.0 * _HELD * self.remembered**2))))

    def of(self, scene: Scene) -> "GridSlabs":
        """As `Slabs`; few tables are kept, because a flow makes tables for many periods."""
        return GridSlabs(scene, self._grid, self.model, self.stages, _FEWEST_KNOWN)

    def keep_ledger(self) -> None:
        """Start to keep the energy balance."""
        if self._dissipation and not self.is_kept[0]:
            for key, (_, port) in self._known.items():
                port.ready[:] = False  # their maps lack the heat
                self._known[key] = _StepMaps(self.slabs, self._dissipation, float(port.length[0])), port
        self.is_kept[0] = True

    def tables(self, longest: float) -> tuple[_StepMaps, Port]:
        """Maps and port of steps of `longest` (transits) and its halves. Lengths that differ by rounding share tables of one
        length that does not depend on their order: a run that continues from a checkpoint sees only the later ones."""
        key = f"{longest:.12e}"
        longest = float(key)
        dissipation = self._dissipation if self.is_kept[0] else None
        known = self._known.pop(key, None) or (_StepMaps(self.slabs, dissipation, longest), self._blank(longest))
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
        """A port whose tables are zero and not ready."""
        scene, s, n = self.scene, self.stages, padded(self.remembered)
        rows, m = n + 2 * s, sum(self.slabs.output_terms) - s
        heat = line_aligned(LEVELS, rows, rows) if self._dissipation else np.empty((0, 0, 0))
        moments = np.zeros((LEVELS, rows, m))
        ledger = (self.is_kept, self.entries, moments, heat, scene.forcing, *self._power, np.zeros(m), np.zeros(rows))
        return Port(
            np.ldexp(longest, -np.arange(LEVELS)),
            np.zeros(LEVELS, dtype=np.bool_),
            np.zeros((LEVELS, s, s)),
            np.zeros((LEVELS, s)),
            line_aligned(LEVELS, n, s),
            np.zeros((LEVELS, s, s)),
            line_aligned(LEVELS, rows, n),
            scene.velocity,
            scene.drive.is_constant,
            line_aligned(n),
            np.zeros(rows),
            _GridLedger(*ledger),
        )

    def prepare(self, port: Port, level: int) -> None:
        """As `Slabs`."""
        maps, _ = self.tables(float(port.length[0]))
        with one_thread():
            step = maps.find(level)
            self._tabulate(port, level, step, maps.heats.get(level))

    def _tabulate(self, port: Port, level: int, step: _StepMap, heat: Array | None) -> None:
        s, n, begin, scale = self.stages, self.remembered, padded(self.remembered), self.scale
        # each face takes half of a change of the drive
        inputs = scipy.linalg.block_diag(self.to_legendre, 0.5 * self.to_legendre[: self.drive_terms])
        values = from_moments(radau(s).nodes)
        free, stress, forced = values @ step.free[:s], values @ step.through[:s] @ inputs, step.forced @ inputs
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
