"""Slip rates of whole arrays."""

import numpy as np
from numpy.typing import NDArray

from slipwave.compiled import allocating
from slipwave.friction.law import Law, rate_of


@allocating
def rates(law: Law, unknowns: NDArray[np.float64]) -> NDArray[np.float64]:
    """Slip rates (V*) at the rate unknowns z; an array of the same shape."""
    found = np.empty_like(unknowns)
    for i in range(unknowns.size):
        found.flat[i] = rate_of(law, unknowns.flat[i])
    return found
