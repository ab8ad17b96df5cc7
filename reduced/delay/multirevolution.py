"""A multirevolution Adams method: over many transits of a motion that hardly changes from one to the next.

Marched over one transit, the state u becomes u + d. Where d changes slowly from transit to transit,

    u_(n+N) = u_(n+1) + sum of d_k over k = n + 1 .. n + N - 1

with d_k from the polynomial in k through the latest p marched transits, of which n is the last. Transit n + N is then marched
and gives the next d. This is the explicit Adams method with sums instead of integrals (Graf and Bettis, Celestial Mechanics 11,
1975; Petzold, SIAM J. Numer. Anal. 18, 1981), of order p in N. The same sum with the new d instead of the oldest is the
implicit Adams method of that order; the difference of both is the estimated error of the leap.
"""

from functools import cache
from typing import NamedTuple

import numpy as np

from slipwave.observe.pieces import Array, barycentric_weights

LONGEST = 4096
"""Transits or blocks that a leap skips, at most."""


class MarchedTransits(NamedTuple):
    """The latest transits that were marched, at most `order`, which is even: `number` (p,), the `change` (p, m) of the state in
    each, and the `highest` (p, q) values of q quantities in it."""

    order: int
    number: Array
    change: Array
    highest: Array

    def then(self, number: float, change: Array, highest: Array) -> "MarchedTransits":
        """`MarchedTransits` with one more transit, without those that are too old."""
        longer = (np.append(self.number, number), np.vstack([self.change, change]), np.vstack([self.highest, highest]))
        return MarchedTransits(self.order, *(values[-self.order :] for values in longer))

    def total(self, first: float, last: float) -> Array:
        """Sum (m,) of the changes in the transits `first` to `last` - 1."""
        nodes, weights = (rule[int(last - first)] for rule in sum_rules(self.order))
        return np.asarray(weights @ self._rows(first + nodes) @ self.change)

    def error(self, first: float, last: float, change: Array) -> Array:
        """Change (m,) of `total` if the transit `last`, marched since with this `change`, replaces the oldest. Both polynomials
        agree at the other transits, so that their difference follows from that at `last`."""
        nodes, weights = (rule[int(last - first)] for rule in sum_rules(self.order))
        others = self.number[1:]
        shares = np.prod((first + nodes[:, None] - others) / (last - others), axis=1)
        return np.asarray(weights @ shares * (change - self._rows(np.array([last]))[0] @ self.change))

    def peaks(self, first: float, last: float) -> list[float]:
        """The transits between the last two marched ones, `first` and `last`, in which a quantity that rose before has its
        maximum, in order."""
        inside = np.arange(first + 1.0, last)
        rising = self.highest[-2] > self.highest[-3]
        if not (inside.size and rising.any()):
            return []
        turned = rising & (self._rows(inside[-1:])[0] @ self.highest > self.highest[-1])
        rows = self._rows(inside) @ self.highest[:, turned] if turned.any() else np.empty((inside.size, 0))
        return sorted({float(inside[row.argmax()]) for row in rows.T})

    def _rows(self, at: Array) -> Array:
        """Weights (k, p) that give the polynomial's values `at` k transits, none of them marched."""
        end, span = self.number[-1], self.number[-1] - self.number[0]
        marched = (self.number - end) / span
        terms = barycentric_weights(marched) / ((at[:, None] - end) / span - marched)
        return np.asarray(terms / terms.sum(axis=1)[:, None])


@cache
def sum_rules(order: int) -> tuple[Array, Array]:
    """Nodes and weights (LONGEST + 1, order/2) with which the sum of a polynomial of degree `order` - 1 over 0, 1, .. n - 1 is
    exact, for each n: Gauss's rule for sums, from the recurrence of the discrete Chebyshev polynomials."""
    k, count = np.arange(1.0, order // 2), np.arange(LONGEST + 1.0)[:, None]
    beside = np.sqrt(k**2 * np.maximum(count**2 - k**2, 0.0) / (4.0 * (4.0 * k**2 - 1.0)))
    matrices = np.zeros((LONGEST + 1, order // 2, order // 2))
    matrices[:, np.arange(1, order // 2), np.arange(order // 2 - 1)] = beside  # and as much above the diagonal
    nodes, vectors = np.linalg.eigh(matrices)
    return 0.5 * (count - 1.0) + nodes, count * vectors[:, 0] ** 2
