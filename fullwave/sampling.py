"""Samples at the ends of equal steps, grouped into `Pieces`. n steps make a polynomial of degree n, so values between the samples
are of order n + 1 and never limit a scheme of order n or less."""

import numpy as np

from slipwave.observe.pieces import Array, Pieces, empty_pieces


def sample_nodes(steps: int) -> Array:
    """Nodes in [0, 1] of a piece of `steps` steps; neighbouring pieces share their end samples."""
    return np.linspace(0.0, 1.0, steps + 1)


def pieces_until(first: int, step: float, until: float, steps: int, most: int) -> Pieces:
    """Empty pieces (1 to `most`, of `steps` steps each), with times, for a march from sample `first` to `until` (transits)."""
    wanted = (until / step - first) / steps
    pieces = empty_pieces(int(min(most, max(1, np.ceil(wanted - 1e-6)))), steps + 1)
    pieces.time[:] = (first + steps * np.arange(pieces.time.size)) * step
    pieces.length[:] = steps * step
    return pieces
