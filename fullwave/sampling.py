"""Samples at the ends of equal steps, grouped into `Pieces`. n steps make a polynomial of degree n, so values between the samples
are of order n + 1 and never limit a scheme of order n or less. Neighbouring pieces share their end samples."""

import numpy as np

from slipwave.observe.pieces import Pieces, empty_pieces


def pieces_until(first: int, step: float, until: float, steps: int, most: int) -> Pieces:
    """Empty pieces (1 to `most`, of `steps` steps each), with times, for a march from sample `first` to `until` (transits)."""
    wanted = (until / step - first) / steps
    pieces = empty_pieces(int(min(most, max(1, np.ceil(wanted - 1e-6)))), steps + 1)
    pieces.time[:] = (first + steps * np.arange(pieces.time.size)) * step
    pieces.length[:] = steps * step
    return pieces
