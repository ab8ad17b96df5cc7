"""Pairs of slabs that differ: the impedance, the stiffness and the static slip weakening of the interface stay those of the
paper's alike slabs; the ratios of impedances q and of round trips p, lower over upper slab, vary.

    1/Z = 1/epsilon_1 + 1/epsilon_2,    1/k = r_1/epsilon_1 + r_2/epsilon_2        (per V*, per L)
    epsilon_1 = Z (1 + q)/q,  epsilon_2 = Z (1 + q),    r_1 = r (1 + q)/(q + p),  r_2 = p r_1

so that at p = 1 the interface cannot tell the pair from alike slabs of epsilon = 2 Z and r, and k = Z/r for all q and p. Times
are given in transits of these alike slabs, a clock that does not change.
"""

import math
from typing import NamedTuple

from validation.measure.in_words import command_words
from validation.report.text import minus

IMPEDANCE = 1.4e-5
"""Z, half of the paper's epsilon."""
ROUND_TRIPS = (1.0, math.sqrt(2.0), 2.0, 3.0, 5.0, 10.0)
IMPEDANCES = (1.0, 3.0, 10.0)
NUDGE = 0.5


class Pair(NamedTuple):
    """Slabs of two ratios, lower over upper, whose alike slabs have this log10 r."""

    impedances: float
    round_trips: float
    log10_r: float

    @property
    def clock(self) -> float:
        """A transit of the upper slab, in transits of the alike slabs."""
        return (1.0 + self.impedances) / (self.impedances + self.round_trips)

    @property
    def settings(self) -> str:
        """The words that give the scene in a command."""
        q, upper = self.impedances, 10.0**self.log10_r * self.clock
        keys = {
            "upper.epsilon": IMPEDANCE * (1.0 + q) / q,
            "lower.epsilon": IMPEDANCE * (1.0 + q),
            "upper.r": upper,
            "lower.r": upper * self.round_trips,
            "start.size": NUDGE,
        }
        return command_words("paper", keys)

    @property
    def title(self) -> str:
        """Its numbers in a few words."""
        return minus(f"q = {self.impedances:g}, p = {self.round_trips:.4g}, log_{{10}} r = {self.log10_r:g}")


def pairs_at(log10_r: float) -> list[Pair]:
    """Every pair once: at equal round trips the ratio of impedances changes nothing."""
    return [Pair(q, p, log10_r) for q in IMPEDANCES for p in ROUND_TRIPS if p > 1.0 or q == 1.0]
