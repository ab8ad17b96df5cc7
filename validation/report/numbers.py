"""Figures of several studies as numbers of the record."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

from reduced.orbit.closing import Closed, close
from reduced.orbit.periodic import FINER
from validation.report import Number, stated


def numbered_period(closed: Closed) -> Number:
    """The orbit's period on a finer mesh, solved to rounding errors; its error is the difference from that on the orbit's own
    mesh."""
    flow, state = closed.flow.remeshed(closed.cycle, FINER)
    period = close(flow, state, closed.cycle.period, 0.0).cycle.period
    return stated(period, abs(period - closed.cycle.period))


def regime_areas(sizes: Mapping[Any, int], rows: Sequence[Mapping[str, Any]]) -> dict[str, Number]:
    """The share of a map's area in which a model has another regime, in per cent, from the `rows` of its differences and the
    `sizes` of its axes. The name contains the lattice, because shares on different lattices are not compared; the error is one
    point of it."""
    counts = [size for name, size in sizes.items() if name != "model"]
    lattice = " x ".join(map(str, counts))
    return {
        f"{row['model']} other regime, {lattice} points": stated(
            row["other_regime_percent"], 1e4 / (math.prod(counts) * row["compared_percent"])
        )
        for row in rows
    }
