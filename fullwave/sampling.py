"""Time-step samples grouped into `Pieces`: four steps make a quartic, so event times and extrema are read to fifth order in the
step and an observer's interpolation never limits a scheme of order four or less."""

import numpy as np

from scene.observe.pieces import Array

STEPS_PER_PIECE = 4
"""Steps of the solver in one piece; neighbouring pieces share their end samples."""

MOST_PIECES = 1024
"""Pieces in one chunk: memory stays at some 200 kB and the cost of leaving compiled code is spread over 4096 steps."""


def sample_nodes() -> Array:
    """Nodes of a piece in [0, 1]."""
    return np.linspace(0.0, 1.0, STEPS_PER_PIECE + 1)


def pieces_until(first: int, step: float, until: float, most: int = MOST_PIECES) -> int:
    """Pieces (1 to `most`) that take a run of equal steps (transits) from sample `first` to `until` or just past it."""
    wanted = (until / step - first) / STEPS_PER_PIECE
    return int(min(most, max(1, np.ceil(wanted - 1e-6))))
