"""The maps of steps of one longest length and its halves, made when first needed, by doubling shorter steps."""

import math

from fullwave.lines.propagator import LinearSlabs, StepMap, doubled, short_step, shortest_halving
from fullwave.lines.viscous_heat import Dissipation, doubled_heat, short_heat
from slipwave.observe.pieces import Array
from slipwave.step.collocation import from_moments, radau
from slipwave.threads import one_thread

LEVELS = 32
"""Number of step lengths."""


class StepMaps:
    """Maps of `slabs` in steps of `longest` (transits) / 2^level, and the `heats` by `dissipation`, if there is any, by level."""

    def __init__(self, slabs: LinearSlabs, dissipation: Dissipation | None, longest: float) -> None:
        self._slabs, self._dissipation, self._longest = slabs, dissipation, longest
        self._maps: dict[int, StepMap] = {}
        self.heats: dict[int, Array] = {}

    def forget(self, dissipation: Dissipation | None) -> None:
        """Make all maps again when they are needed, with the heats by `dissipation`."""
        self._dissipation = dissipation
        self._maps.clear()
        self.heats.clear()

    def find(self, level: int) -> StepMap:
        """The map of a level; makes those of levels between it and a shorter one for which a series holds."""
        with one_thread():
            if level > max(self._maps, default=-1):
                self._begin(level)
            for k in range(max(self._maps), level, -1):
                if k - 1 not in self._maps:
                    self._maps[k - 1] = doubled(self._slabs, self._maps[k])
                    if self._dissipation:
                        self.heats[k - 1] = doubled_heat(self._slabs, self._maps[k], self.heats[k])
        return self._maps[level]

    def _begin(self, level: int) -> None:
        """Make the map of `level` or, if a series does not hold for it yet, of the longest level for which one does."""
        shortest = max(level, min(LEVELS - 1, shortest_halving(self._slabs, self._longest)))
        length = math.ldexp(self._longest, -shortest)
        extra = shortest_halving(self._slabs, length)
        first = math.ldexp(length, -extra)
        step = short_step(self._slabs, first)
        heat = short_heat(self._slabs, self._dissipation, first) if self._dissipation else None
        for _ in range(extra):
            heat = doubled_heat(self._slabs, step, heat) if heat is not None else None
            step = doubled(self._slabs, step)
        self._maps[shortest] = step
        if heat is not None:
            self.heats[shortest] = heat


def at_nodes(step: StepMap, stages: int, inputs: Array) -> tuple[Array, Array, Array]:
    """The first output at the nodes of `step` from x, (s, n), and from input values, (s, i), whose Legendre coefficients are
    `inputs` (p, i) times them; the change of x from these, (n, i)."""
    values = from_moments(radau(stages).nodes)
    return values @ step.free[:stages], values @ step.through[:stages] @ inputs, step.forced @ inputs
