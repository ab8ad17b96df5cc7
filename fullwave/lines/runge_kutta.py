"""Explicit Runge-Kutta methods as data, and the compiled sum that all of them use.

CLASSICAL        order 4, 4 stages. Stable on the imaginary axis up to 2.83, on the negative real axis up to 2.785.
method_of(8)     order 8, 12 stages: the propagating formula of DOP853 (Hairer, Norsett, Wanner, Solving Ordinary Differential
                 Equations I, 2nd ed., section II.10). Imaginary axis up to 5.960, real axis up to 6.394. Of the order-8 methods
                 tried it needs the fewest stages per transit (the 11 stages of Cooper and Verner, 1972, reach 3.0 on the
                 imaginary axis).
"""

from functools import cache
from typing import NamedTuple

import numpy as np

from fullwave.lines.panels import LANES, add_rows
from slipwave.compiled import inlined
from slipwave.observe.pieces import Array


class RungeKutta(NamedTuple):
    """Butcher's array, flat: row s of `weight` (stages + 1 rows of `stages` numbers) holds the weights of stage s, the last row
    the final weights. `abscissae` (stages,) are in units of the step."""

    order: int
    stages: int
    weight: Array
    abscissae: Array


def _packed(order: int, table: Array, final: Array) -> RungeKutta:
    """Butcher's array with the weights of all stages (stages, stages) and the final ones (stages,)."""
    return RungeKutta(order, final.size, np.vstack((table, final)).ravel(), table.sum(axis=1))


def scaled_method(method: RungeKutta, step: float) -> RungeKutta:
    """The method with weights and abscissae times the length of a step."""
    return method._replace(weight=step * method.weight, abscissae=step * method.abscissae)


def stability_polynomial(method: RungeKutta) -> Array:
    """c_k of R(z) = sum c_k z^k, the factor by which a step multiplies a solution of u' = lambda u, z = lambda dt."""
    table = method.weight.reshape(-1, method.stages)
    powers, coefficients = np.ones(method.stages), [1.0]
    for _ in range(method.stages):
        coefficients.append(float(table[-1] @ powers))
        powers = table[:-1] @ powers
    return np.array(coefficients)


@inlined
def combine_stages(weight: Array, stages: int, row: int, base: Array, rates: Array, out: Array) -> None:
    """out = base + sum of row `row` of `weight` (times the step) over the earlier stages' rates (flat, stages times base.size).
    Sizes are multiples of panels.LANES; out may be base."""
    for i in range(0, base.size, LANES):
        add_rows(weight, row * stages, row, rates, i, base.size, base, out, i)


CLASSICAL = _packed(4, np.array([[0, 0, 0, 0], [1 / 2, 0, 0, 0], [0, 1 / 2, 0, 0], [0, 0, 1, 0]]), np.array([1, 2, 2, 1]) / 6)


@cache
def method_of(order: int) -> RungeKutta:
    """The method of order 4 or 8."""
    if order == CLASSICAL.order:
        return CLASSICAL
    from scipy.integrate import DOP853  # takes a tenth of a second to load

    return _packed(8, DOP853.A, DOP853.B)
