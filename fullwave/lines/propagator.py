"""The semi-discrete slabs propagated exactly in time over one step.

With the slip rate u = v - V_0 and the change c of the drive (both polynomials in the step), `fullwave.lines.matrix` gives

    x' = L x + b u + d c,      y = C x + D_u u + D_c c,

y: the stress at the interface and the quantities of the energy balance. Inputs and outputs are taken by their coefficients in
Legendre polynomials P_k(2 tau - 1) on the step: powers of tau would lose five digits. An output is represented by its moments

    m_k = integral of P_k(2 tau - 1) y over tau = 0..1,

i.e. by its L2 projection onto the polynomials. Values at nodes instead would make the coupled step unstable for weak friction.
The map (x, inputs) -> (change of x, moments) of a very short step is a Taylor series (`short_step`); that of a step twice as long
follows from it by products of matrices (`doubled`). The change of x is computed instead of x at the end: next to 1, e^(h L) - 1
of slow modes would lose its digits, and doubling would multiply the error.
"""

import math
from dataclasses import dataclass
from functools import cache

import numpy as np
import scipy.linalg
import scipy.special
from numpy.polynomial import legendre

from slipwave.observe.pieces import Array

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


@dataclass(frozen=True)
class StepMap:
    """One step: x(end) - x = `change` x + `forced` a and m = `free` x + `through` a, with the coefficients a (p,) of all inputs
    and the moments m (q,) of all outputs, one after the other."""

    change: Array
    forced: Array
    free: Array
    through: Array


def grid_impedance_at(slabs: LinearSlabs, s: float) -> float:
    """Z(s) for real s > 0 (1/transit): minus the response of the first output, the stress, to the first input, the slip rate."""
    moved = np.linalg.solve(s * np.eye(slabs.rates.shape[0]) - slabs.rates, slabs.inputs[:, 0])
    return -float(slabs.direct[0, 0] + slabs.outputs[0] @ moved)


def shortest_halving(slabs: LinearSlabs, length: float) -> int:
    """Number of halvings of a step of `length` (transits) after which `short_step` is accurate to rounding."""
    size = float(np.abs(slabs.rates).sum(axis=0).max()) * length
    return max(0, int(np.ceil(np.log2(size / _SMALL)))) if size > 0.0 else 0


def short_step(slabs: LinearSlabs, length: float) -> StepMap:
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


def doubled_map(slabs: LinearSlabs, half: StepMap) -> StepMap:
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


def to_legendre(nodes: Array) -> Array:
    """(s, s): coefficients of the polynomial with given values at `nodes` in [0, 1]."""
    return np.asarray(np.linalg.inv(legendre.legvander(2.0 * nodes - 1.0, nodes.size - 1)))


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
