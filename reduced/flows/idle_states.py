"""States of slabs in which they swing without stress or slip at the interface (`reduced.stability.idle`), and what is left
without them."""

import numpy as np

from slipwave.observe.pieces import Array
from slipwave.threads import one_thread

_SQUARINGS = 20
_LEFT = 1e-6  # singular value, over the largest, of what has not died out


def idle_states(step: Array) -> Array:
    """Orthonormal states (n, m) that do not die out under the map `step` (n, n), whose other motions all do."""
    power = step
    with one_thread():
        for _ in range(_SQUARINGS):
            power = power @ power
        states, sizes, _ = np.linalg.svd(power)
    return np.asarray(states[:, sizes > _LEFT * max(float(sizes[0]), 1.0)])


def without(matrix: Array, states: Array) -> Array:
    """What a `matrix` (n, n) that maps the orthonormal `states` (n, m) to each other does with all others, up to these: its
    eigenvalues (n - m) are those of the matrix without those that belong to the states."""
    if not states.size:
        return matrix
    rest = np.linalg.qr(states, mode="complete")[0][:, states.shape[1] :]
    return np.asarray(rest.T @ matrix @ rest)
