"""Two special points of one kind between two points of a branch leave the number of unstable multipliers as it was."""

import cmath
from types import SimpleNamespace

import numpy as np
import pytest

from reduced.continuation import special
from reduced.continuation.special import specials_between, trend_of


def point(place, height, angle):
    """A point at `place` of a straight branch; the modulus of one multiplier, or pair, is 1 + height - (place - 1/2)^2 there."""
    value = (1.0 + height - (place - 0.5) ** 2) * cmath.exp(1j * angle)
    values = np.array([value, value.conjugate()] if angle < np.pi else [value.real])
    return SimpleNamespace(
        closed=SimpleNamespace(flow=SimpleNamespace(undecided="")),
        unknowns=np.array([place]),
        tangent=np.array([1.0]),
        parameter=place,
        multipliers=np.array([*values, 0.3]),
        unstable=int((np.abs(values) > 1.0).sum()),
    )


@pytest.fixture(autouse=True)
def straight(monkeypatch):
    """Points between two others without a solve, and special points told by the interval that holds them."""

    def middle(family, left, right, metric):
        return family(0.5 * (left.parameter + right.parameter))

    monkeypatch.setattr(special, "_middle", middle)
    monkeypatch.setattr(special, "_locate", lambda family, left, right, metric, kind: (kind, left.parameter, right.parameter))


METRIC = SimpleNamespace(length=lambda unknowns: float(np.abs(unknowns).max()))


@pytest.mark.parametrize(("angle", "kind"), [(2.0, "NS"), (np.pi, "PD")])
@pytest.mark.parametrize("height", [0.05, 0.003, 1e-4, -1e-6, -0.01])
def test_a_pair_that_comes_and_goes_is_found(height, angle, kind):
    def family(place):
        return point(place, height, angle)

    before, left, right = family(-0.1), family(0.2), family(0.8)
    assert left.unstable == right.unstable == 0
    found = specials_between(family, left, right, METRIC, trend_of(before, left, 0.3))
    places = [0.5 - height**0.5, 0.5 + height**0.5] if height > 0.0 else []
    assert [name for name, *_ in found] == [kind] * len(places)
    assert all(begin <= place <= end for (_, begin, end), place in zip(found, places, strict=True))


def test_a_pair_of_unstable_multipliers_that_dips_into_the_circle_is_found():
    def family(place):
        one = point(place, 0.0, 2.0)
        one.multipliers = np.append((2.0 - 0.01 - np.abs(one.multipliers[:2])) * np.exp(2j * np.array([1.0, -1.0])), 0.3)
        one.unstable = int((np.abs(one.multipliers) > 1.0).sum())
        return one

    before, left, right = family(-0.1), family(0.2), family(0.8)
    assert left.unstable == right.unstable == 2
    found = specials_between(family, left, right, METRIC, trend_of(before, left, 0.3))
    assert [name for name, *_ in found] == ["NS", "NS"]
    assert all(begin <= place <= end for (_, begin, end), place in zip(found, (0.4, 0.6), strict=True))
