"""The maps of steps of one longest length and its halves, made when first needed, by doubling shorter steps.

Viscous heat of a step is a quadratic form in the grid's values and the inputs' coefficients. Dissipated power is a quadratic form
in (x, u, c). Over a step x is linear in y = (x at its start, coefficients a), so the heat is y^T G y with one symmetric matrix G
for each step length; that of a step twice as long follows as for the step's map.
"""

import math
from typing import TypeAlias

import numpy as np
import scipy.linalg
from numpy.polynomial import legendre
from numpy.typing import NDArray

from fullwave.lines.matrix import LinearMotion
from fullwave.lines.propagator import LinearSlabs, StepMap, doubled_map, halves, short_step, shortest_halving
from fullwave.lines.system import SCALARS, System, Viscous
from slipwave.observe.pieces import Array
from slipwave.step.collocation import from_moments, radau
from slipwave.step.port import LEVELS
from slipwave.threads import one_thread

_TERMS = 16


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
    """G of a step so short that a Taylor series holds (`propagator.short_step`), by Gauss quadrature in time."""
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
            series = min(LEVELS - 1, shortest_halving(self._slabs, self._longest))
            if max(level, series) not in self._maps:
                self._begin(max(level, series))
            for k in range(series, level, -1):
                if k - 1 not in self._maps:
                    self._maps[k - 1] = doubled_map(self._slabs, self._maps[k])
                    if self._dissipation:
                        self.heats[k - 1] = _doubled_heat(self._slabs, self._maps[k], self.heats[k])
        return self._maps[level]

    def _begin(self, level: int) -> None:
        """Make the map of `level` from a step short enough for the Taylor series."""
        length = math.ldexp(self._longest, -level)
        extra = shortest_halving(self._slabs, length)
        first = math.ldexp(length, -extra)
        step = short_step(self._slabs, first)
        heat = _short_heat(self._slabs, self._dissipation, first) if self._dissipation else None
        for _ in range(extra):
            heat = _doubled_heat(self._slabs, step, heat) if heat is not None else None
            step = doubled_map(self._slabs, step)
        self._maps[level] = step
        if heat is not None:
            self.heats[level] = heat


def at_nodes(step: StepMap, stages: int, inputs: Array) -> tuple[Array, Array, Array]:
    """The first output at the nodes of `step` from x, (s, n), and from input values, (s, i), whose Legendre coefficients are
    `inputs` (p, i) times them; the change of x from these, (n, i)."""
    values = from_moments(radau(stages).nodes)
    return values @ step.free[:stages], values @ step.through[:stages] @ inputs, step.forced @ inputs
