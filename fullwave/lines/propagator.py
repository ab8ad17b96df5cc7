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
`StepMaps` makes the maps of one longest length and its halves when they are first needed.
"""

import math
from dataclasses import dataclass
from functools import cache
from typing import TypeAlias

import numpy as np
import scipy.linalg
import scipy.special
from numpy.polynomial import legendre
from numpy.typing import NDArray

from fullwave.lines.matrix import LinearMotion
from fullwave.lines.system import SCALARS, System, Viscous
from slipwave.observe.pieces import Array
from slipwave.step.collocation import from_moments, radau
from slipwave.step.port import LEVELS
from slipwave.threads import one_thread

_SMALL = 0.5  # largest norm of length * L in a Taylor series
_TERMS = 16  # 0.5^17/17! is 2e-20


@dataclass(frozen=True)
class LinearSlabs:
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
class StepMap:
    """One step: x(end) - x = `change` x + `forced` a and m = `free` x + `through` a, with the coefficients a (p,) of all inputs
    and the moments m (q,) of all outputs, one after the other."""

    change: Array
    forced: Array
    free: Array
    through: Array


def _shortest_halving(slabs: LinearSlabs, length: float) -> int:
    """Number of halvings of a step of `length` (transits) after which `_short_step` is accurate to rounding."""
    size = float(np.abs(slabs.rates).sum(axis=0).max()) * length
    return max(0, int(np.ceil(np.log2(size / _SMALL)))) if size > 0.0 else 0


def _short_step(slabs: LinearSlabs, length: float) -> StepMap:
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
    return StepMap(_grown(step), np.hstack(forced), np.vstack(free), np.block(through))


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


def _doubled_map(slabs: LinearSlabs, half: StepMap) -> StepMap:
    """The map of a step twice as long as that of `half`: exact, because polynomials on the step are polynomials on its halves."""
    first, second = halves(slabs.input_terms)
    early, late = (0.5 * half.T for half in halves(slabs.output_terms))
    forced = half.forced @ first
    return StepMap(
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


Dissipation: TypeAlias = tuple[Array, Array]
"""Power = sum over k of weight_k (rows_k . (x, u, c))^2: rows (k, n + i), weight (k,)."""


def dissipation_of(system: System, motion: LinearMotion, slots: NDArray[np.int64]) -> Dissipation | None:
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


def _short_heat(slabs: LinearSlabs, power: Dissipation, length: float) -> Array:
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


def _doubled_heat(slabs: LinearSlabs, half: StepMap, heat: Array) -> Array:
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


class StepMaps:
    """Maps of `slabs` in steps of `longest` (transits) / 2^level, and, with a `dissipation`, the `heats`, by level."""

    def __init__(self, slabs: LinearSlabs, dissipation: Dissipation | None, longest: float) -> None:
        self._slabs, self._dissipation, self._longest = slabs, dissipation, longest
        self._maps: dict[int, StepMap] = {}
        self.heats: dict[int, Array] = {}

    def find(self, level: int) -> StepMap:
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


def at_nodes(step: StepMap, stages: int, inputs: Array) -> tuple[Array, Array, Array]:
    """The first output at the nodes of `step` from x, (s, n), and from input values, (s, i), whose Legendre coefficients are
    `inputs` (p, i) times them; the change of x from these, (n, i)."""
    values = from_moments(radau(stages).nodes)
    return values @ step.free[:stages], values @ step.through[:stages] @ inputs, step.forced @ inputs
