"""Roots and extrema of random polynomials, as numpy finds them."""

import numpy as np
import pytest
from numpy.polynomial import Polynomial

from slipwave.observe.extrema import evaluate, find_root, raise_record
from slipwave.observe.pieces import lagrange_basis

NODES = {
    "radau": np.array([0.0571041961, 0.2768430136, 0.5835904324, 0.8602401357, 1.0]),
    "equispaced": np.linspace(0.0, 1.0, 5),
}
BASES = {name: lagrange_basis(nodes) for name, nodes in NODES.items()}


def smooth(count):
    """Waves that are longer than a piece: the record trusts the polynomials of these."""
    random = np.random.default_rng(5)
    t = np.linspace(0.0, 1.0, 5)
    for _ in range(count):
        phase, length, height = random.uniform([0.0, 1.3, 0.5], [2.0 * np.pi, 4.0, 3.0])
        yield Polynomial(np.polyfit(t, height * np.cos(2.0 * np.pi * t / length + phase), 4)[::-1])


def greatest(polynomial, *ends, within):
    """Of the values at `ends` and at the turns `within` an interval."""
    turns = [root.real for root in polynomial.deriv().roots() if abs(root.imag) < 1e-12 and within[0] < root.real < within[1]]
    return float(max(polynomial(np.array([*ends, *turns]))))


@pytest.mark.parametrize("basis", BASES.values(), ids=BASES)
def test_the_point_at_which_a_level_is_passed(basis):
    """Levels between the end values of intervals in which the polynomial only rises or falls, and the end values themselves."""
    random = np.random.default_rng(6)
    met = 0
    for polynomial in smooth(60):
        values = polynomial(basis.nodes)
        left, right = np.sort(random.uniform(0.0, 1.0, 2))
        turns = polynomial.deriv().roots()
        if np.any((np.abs(turns.imag) < 1e-12) & (turns.real > left) & (turns.real < right)):
            continue
        level = random.uniform(*np.sort(polynomial(np.array([left, right]))))
        (wanted,) = [root.real for root in (polynomial - level).roots() if abs(root.imag) < 1e-9 and left < root.real < right]
        assert find_root(basis, values, level, left, right) == pytest.approx(wanted, abs=1e-11)
        for end in (left, right):
            assert find_root(basis, values, evaluate(basis, values, end), left, right) == pytest.approx(end, abs=1e-12)
        met += 1
    assert met > 20


def test_a_flat_piece_has_its_level_everywhere():
    point = find_root(BASES["radau"], np.full(5, 2.0), 2.0, 0.25, 0.75)
    assert 0.25 <= point <= 0.75


@pytest.mark.parametrize("basis", BASES.values(), ids=BASES)
def test_the_record_within_a_part_of_a_piece(basis):
    random = np.random.default_rng(7)
    for polynomial in smooth(100):
        begin, end = np.sort(random.uniform(0.0, 1.0, 2))
        memory = np.array([-np.inf, -np.inf])
        raise_record(basis, polynomial(basis.nodes), np.zeros(5), memory, 0, begin, end)
        wanted = [greatest(sign * polynomial, begin, end, within=(begin, end)) for sign in (1.0, -1.0)]
        assert memory == pytest.approx(wanted, abs=1e-12)
