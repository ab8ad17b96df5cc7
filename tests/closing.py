"""Periodic orbits by Newton's method on a `Flow`, and derivatives of its march by differences."""

import numpy as np


def closed(flow, state, period):
    """The cycle of the orbit near `state` and `period`, and its monodromy matrix."""
    for _ in range(8):
        cycle = flow.march(state, period)
        monodromy, change = flow.tangent(cycle), 1e-6 * period
        along = (flow.march(state, period + change).end - flow.march(state, period - change).end) / (2.0 * change)
        system = np.block([[monodromy - np.eye(flow.size), along[:, None]], [along, 0.0]])
        correction = np.linalg.solve(system, np.append(state - cycle.end, 0.0))
        state, period = state + correction[:-1], period + float(correction[-1])
        if np.abs(correction).max() < 1e-10:
            return flow.march(state, period), monodromy
    raise AssertionError(f"Newton's method does not converge: {np.abs(correction).max()}")


def difference(end_at, size, step=1e-5):
    """Derivative (n, size) of `end_at` at zero by central differences of fourth order."""
    rows = []
    for unit in step * np.eye(size):
        near, far = end_at(unit) - end_at(-unit), end_at(2.0 * unit) - end_at(-2.0 * unit)
        rows.append((8.0 * near - far) / (12.0 * step))
    return np.array(rows).T


def largest(matrix):
    return float(np.abs(matrix).max())
