"""The maps of steps of one longest length and its halves, made when first needed, by doubling shorter steps."""

import hashlib
import math
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from fullwave.lines.propagator import LinearSlabs, StepMap, doubled, short_step, shortest_halving
from fullwave.lines.viscous_heat import Dissipation, doubled_heat, short_heat
from slipwave.observe.pieces import Array
from slipwave.step.collocation import from_moments, radau
from slipwave.step.port import LEVELS
from slipwave.threads import one_thread

_MOST_KEPT = 8
_kept: "dict[bytes, StepMaps] | None" = None


class StepMaps:
    """Maps of `slabs` in steps of `longest` (transits) / 2^level, and the `heats` by `dissipation`, if there is any, by level."""

    def __init__(self, slabs: LinearSlabs, dissipation: Dissipation | None, longest: float) -> None:
        self._slabs, self._dissipation, self._longest = slabs, dissipation, longest
        self._maps: dict[int, StepMap] = {}
        self.heats: dict[int, Array] = {}

    def find(self, level: int) -> StepMap:
        """The map of a level: from a series or, where none holds, by doubling that of half the length. The same to the bit,
        whichever levels were asked for before."""
        with one_thread():
            series = min(LEVELS - 1, shortest_halving(self._slabs, self._longest))
            if max(level, series) not in self._maps:
                self._begin(max(level, series))
            for k in range(series, level, -1):
                if k - 1 not in self._maps:
                    self._maps[k - 1] = doubled(self._slabs, self._maps[k])
                    if self._dissipation:
                        self.heats[k - 1] = doubled_heat(self._slabs, self._maps[k], self.heats[k])
        return self._maps[level]

    def _begin(self, level: int) -> None:
        """Make the map of `level`, from a step for which a series holds."""
        length = math.ldexp(self._longest, -level)
        extra = shortest_halving(self._slabs, length)
        first = math.ldexp(length, -extra)
        step = short_step(self._slabs, first)
        heat = short_heat(self._slabs, self._dissipation, first) if self._dissipation else None
        for _ in range(extra):
            heat = doubled_heat(self._slabs, step, heat) if heat is not None else None
            step = doubled(self._slabs, step)
        self._maps[level] = step
        if heat is not None:
            self.heats[level] = heat


@contextmanager
def maps_kept() -> Iterator[None]:
    """While this is open, a march takes the maps that an earlier one made of the same grid: in a sweep over V, friction or r,
    which do not change the slabs on the transit clock. The maps of eight grids or longest steps are kept in memory, but none with
    viscous heat."""
    global _kept
    before, _kept = _kept, {}
    try:
        yield
    finally:
        _kept = before


def maps_of(slabs: LinearSlabs, dissipation: Dissipation | None, longest: float) -> StepMaps:
    """The maps of `slabs` (`StepMaps`), made by an earlier march if `maps_kept` is open."""
    if _kept is None or dissipation is not None:
        return StepMaps(slabs, dissipation, longest)
    tables = (slabs.rates, slabs.inputs, slabs.outputs, slabs.direct)
    shapes = f"{slabs.input_terms} {slabs.output_terms} {longest:.12e} {[table.shape for table in tables]}"
    key = hashlib.sha256(shapes.encode() + b"".join(np.ascontiguousarray(table).tobytes() for table in tables)).digest()
    found = _kept.pop(key, None) or StepMaps(slabs, None, longest)
    _kept[key] = found  # the last used is the last to be forgotten
    if len(_kept) > _MOST_KEPT:
        del _kept[next(iter(_kept))]
    return found


def at_nodes(step: StepMap, stages: int, inputs: Array) -> tuple[Array, Array, Array]:
    """The first output at the nodes of `step` from x, (s, n), and from input values, (s, i), whose Legendre coefficients are
    `inputs` (p, i) times them; the change of x from these, (n, i)."""
    values = from_moments(radau(stages).nodes)
    return values @ step.free[:stages], values @ step.through[:stages] @ inputs, step.forced @ inputs
