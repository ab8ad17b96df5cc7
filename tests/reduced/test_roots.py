"""Zeros of polynomials with known roots: all found, each once; a double one is refused after so many halvings."""

from types import SimpleNamespace

import numpy as np
import pytest

from reduced.stability import roots
from slipwave.errors import NumericsError


def polynomial(*zeros):
    def jet(s):
        factors = np.array([s - zero for zero in zeros])
        others = [np.prod(np.delete(factors, k, axis=0), axis=0) for k in range(len(zeros))]
        return SimpleNamespace(value=np.prod(factors, axis=0), slope=np.sum(others, axis=0))

    return jet


@pytest.mark.parametrize("apart", [1.0, 1e-3, 1e-6])
def test_all_zeros_are_found_each_once(apart):
    true = np.array([0.3 + 0.2j, 0.3 + apart + 0.2j, 1.7 - 0.6j, *(0.1 * k + 0.9j for k in range(1, 9))])
    found = roots.zeros_in(polynomial(*true), -1.0 - 1.0j, 2.0 + 1.5j, true.size)
    assert np.sort_complex(found) == pytest.approx(np.sort_complex(true), abs=1e-9)


def test_a_double_zero_is_refused():
    with pytest.raises(NumericsError, match=r"2 roots near s = 0.3\+0.19999\dj are too close to be distinguished"):
        roots.zeros_in(polynomial(0.3 + 0.2j, 0.3 + 0.2j), -1.0 - 1.0j, 2.0 + 1.5j, 2)
