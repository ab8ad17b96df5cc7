"""Explicit Runge-Kutta methods as data, and the one compiled sum they all need.

CLASSICAL        order 4, 4 stages. Stable on the imaginary axis up to 2.83, on the negative real axis up to 2.785.
DORMAND_PRINCE_8 order 8, 12 stages: the propagating formula of DOP853 (Hairer, Norsett, Wanner, Solving Ordinary Differential
                 Equations I, 2nd ed., section II.10). Imaginary axis up to 5.960, real axis up to 6.394. Of the order-8 methods
                 tried it spends the fewest stages on a transit of a wave (the 11 stages of Cooper and Verner, 1972, reach 3.0 on
                 the imaginary axis).
"""

from typing import NamedTuple

import numpy as np

from fullwave.lines.panels import LANES, add_rows
from slipwave.compiled import inlined
from slipwave.observe.pieces import Array


class RungeKutta(NamedTuple):
    """Butcher's array, flat: row s of `weight` (stages + 1 rows of `stages` numbers) holds stage s's weights, the last row the
    final ones. `abscissae` (stages,) are in units of the step."""

    order: int
    stages: int
    weight: Array
    abscissae: Array


def runge_kutta(order: int, rows: tuple[dict[int, float], ...]) -> RungeKutta:
    """Pack a Butcher array given row by row as {stage: weight} (the first row empty, the last the final weights)."""
    stages = len(rows) - 1
    table = np.zeros((stages + 1, stages))
    for row, entries in zip(table, rows, strict=True):
        row[list(entries)] = list(entries.values())
    return RungeKutta(order, stages, table.ravel(), table[:-1].sum(axis=1))


def stability_polynomial(method: RungeKutta) -> Array:
    """c_k of R(z) = sum c_k z^k, the factor by which a step multiplies a solution of u' = lambda u, z = lambda dt."""
    table = method.weight.reshape(-1, method.stages)
    powers, coefficients = np.ones(method.stages), [1.0]
    for _ in range(method.stages):
        coefficients.append(float(table[-1] @ powers))
        powers = table[:-1] @ powers
    return np.array(coefficients)


@inlined
def combine(weight: Array, stages: int, row: int, base: Array, rates: Array, out: Array) -> None:
    """out = base + sum of row `row` of `weight` (times the step) over the earlier stages' rates (flat, stages times base.size).
    Sizes are multiples of panels.LANES; out may be base."""
    for i in range(0, base.size, LANES):
        add_rows(weight, row * stages, row, rates, i, base.size, base, out, i)


CLASSICAL = runge_kutta(4, ({}, {0: 1 / 2}, {1: 1 / 2}, {2: 1.0}, {0: 1 / 6, 1: 1 / 3, 2: 1 / 3, 3: 1 / 6}))

# fmt: off
DORMAND_PRINCE_8 = runge_kutta(
    8,
    (
        {},
        {0: 0.05260015195876773},
        {0: 0.0197250569845379, 1: 0.0591751709536137},
        {0: 0.02958758547680685, 2: 0.08876275643042054},
        {0: 0.2413651341592667, 2: -0.8845494793282861, 3: 0.924834003261792},
        {0: 0.037037037037037035, 3: 0.17082860872947386, 4: 0.12546768756682242},
        {0: 0.037109375, 3: 0.17025221101954405, 4: 0.06021653898045596, 5: -0.017578125},
        {
            0: 0.03709200011850479,
            3: 0.17038392571223998,
            4: 0.10726203044637328,
            5: -0.015319437748624402,
            6: 0.008273789163814023,
        },
        {
            0: 0.6241109587160757,
            3: -3.3608926294469414,
            4: -0.868219346841726,
            5: 27.59209969944671,
            6: 20.154067550477894,
            7: -43.48988418106996,
        },
        {
            0: 0.47766253643826434,
            3: -2.4881146199716677,
            4: -0.590290826836843,
            5: 21.230051448181193,
            6: 15.279233632882423,
            7: -33.28821096898486,
            8: -0.020331201708508627,
        },
        {
            0: -0.9371424300859873,
            3: 5.186372428844064,
            4: 1.0914373489967295,
            5: -8.149787010746927,
            6: -18.52006565999696,
            7: 22.739487099350505,
            8: 2.4936055526796523,
            9: -3.0467644718982196,
        },
        {
            0: 2.273310147516538,
            3: -10.53449546673725,
            4: -2.0008720582248625,
            5: -17.9589318631188,
            6: 27.94888452941996,
            7: -2.8589982771350235,
            8: -8.87285693353063,
            9: 12.360567175794303,
            10: 0.6433927460157636,
        },
        {
            0: 0.054293734116568765,
            5: 4.450312892752409,
            6: 1.8915178993145003,
            7: -5.801203960010585,
            8: 0.3111643669578199,
            9: -0.1521609496625161,
            10: 0.20136540080403034,
            11: 0.04471061572777259,
        },
    ),
)
# fmt: on
