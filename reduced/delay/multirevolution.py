"""A multirevolution Adams method: over many transits of a motion that hardly changes from one to the next.

Marched over one transit, the state u becomes u + d. Where d changes slowly from transit to transit,

    u_(n+N) = u_(n+1) + sum of d_k over k = n + 1 .. n + N - 1

takes d_k from the polynomial in k through the latest ORDER transits that were marched, of which n is the last. Transit n + N is
then marched and gives the next d. This is the explicit Adams method with sums in place of integrals (Graf and Bettis, Celestial
Mechanics 11, 1975; Petzold, SIAM J. Numer. Anal. 18, 1981), of order ORDER in N. The same sum with the new d in place of the
oldest is the implicit Adams method of that order; the difference of both is the estimated error of the leap.
"""

from typing import NamedTuple

import numpy as np

from slipwave.observe.pieces import Array, barycentric_weights

ORDER = 6


class Past(NamedTuple):
    """The latest transits of a stick that were marched, at most ORDER: `number` (p,), the `change` (p, m) of the state in each,
    and the `lowest` (p,) rate unknown at its nodes."""

    number: Array
    change: Array
    lowest: Array

    def then(self, number: float, change: Array, lowest: float) -> "Past":
        """With one more transit, without those that are too old."""
        longer = (np.append(self.number, number), np.vstack([self.change, change]), np.append(self.lowest, lowest))
        return Past(*(values[-ORDER:] for values in longer))

    def total(self, first: float, last: float) -> Array:
        """Sum (m,) of the changes in the transits `first` to `last` - 1."""
        return np.asarray(self._rows(first, last).sum(axis=0) @ self.change)

    def slowest(self, first: float, last: float) -> float | None:
        """The transit between the last two that were marched, `first` and `last`, in which the rate unknown comes to its minimum;
        None if it does not, or if it did not fall before."""
        if self.lowest[-2] >= self.lowest[-3]:
            return None
        lowest = self._rows(first + 1.0, last) @ self.lowest
        return first + 1.0 + float(lowest.argmin()) if lowest.min() < self.lowest[-2:].min() else None

    def _rows(self, first: float, last: float) -> Array:
        """Weights (k, p) of the polynomial's values at the transits `first` to `last` - 1, of which none was marched."""
        end, span = self.number[-1], self.number[-1] - self.number[0]
        marched, at = (self.number - end) / span, (np.arange(first, last) - end) / span
        terms = barycentric_weights(marched) / (at[:, None] - marched)
        return np.asarray(terms / terms.sum(axis=1, keepdims=True))


def no_past(size: int) -> Past:
    """No transit yet of a state of `size` numbers."""
    return Past(np.empty(0), np.empty((0, size)), np.empty(0))
