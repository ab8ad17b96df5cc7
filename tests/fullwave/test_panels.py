"""The vector loops against plain ones."""

import numpy as np

from fullwave.lines.panels import add_rows, differentiate_rows
from slipwave.compiled import njit


@njit
def compiled_add(weight, first, count, rows, start, stride, base, out, at):
    add_rows(weight, first, count, rows, start, stride, base, out, at)


@njit
def compiled_differentiate(weight, first, count, rows, start, stride, scale, lane, out, at):
    differentiate_rows(weight, first, count, rows, start, stride, scale, lane, out, at)


GENERATOR = np.random.default_rng(3)
WEIGHT, ROWS, BASE = (GENERATOR.standard_normal(n) for n in (20, 80, 24))


def plain_sum(first, count, start, stride):
    return sum((WEIGHT[first + j] * ROWS[start + j * stride :][:8] for j in range(count)), np.zeros(8))


def test_add_rows():
    for count in (0, 1, 5):
        out = BASE.copy()
        compiled_add(WEIGHT, 3, count, ROWS, 2, 16, BASE, out, 8)
        expected = BASE.copy()
        expected[8:16] += plain_sum(3, count, 2, 16)
        np.testing.assert_allclose(out, expected, rtol=1e-14)


def test_add_rows_onto_itself():
    out = BASE.copy()
    compiled_add(WEIGHT, 0, 4, ROWS, 0, 8, out, out, 0)
    np.testing.assert_allclose(out[:8], BASE[:8] + plain_sum(0, 4, 0, 8), rtol=1e-14)


def test_differentiate_rows_scales_and_exchanges_the_halves():
    out = np.zeros(24)
    compiled_differentiate(WEIGHT, 1, 6, ROWS, 0, 10, BASE, 8, out, 16)
    np.testing.assert_allclose(out[16:], BASE[8:16] * np.roll(plain_sum(1, 6, 0, 10), 4), rtol=1e-13)
    assert not out[:16].any()
