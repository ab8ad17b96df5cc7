"""Figures of several studies as numbers of the record."""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from reduced.orbit.closing import Closed, close
from reduced.orbit.periodic import FINER
from validation.report import Number, stated

if TYPE_CHECKING:
    from xarray import Dataset


def numbered_period(closed: Closed) -> Number:
    """The orbit's period on a finer mesh, solved to rounding errors; its error is the difference from that on the orbit's own
    mesh."""
    flow, state = closed.flow.remeshed(closed.cycle, FINER)
    period = close(flow, state, closed.cycle.period, 0.0).cycle.period
    return stated(period, abs(period - closed.cycle.period))


def regime_areas(differences: "Dataset", rows: Sequence[Mapping[str, Any]]) -> dict[str, Number]:
    """The share of a map's area in which a model has another regime, in per cent, from the `rows` of its differences. The
    name contains the lattice, because shares on different lattices are not compared; the error is one point of it."""
    sizes = [size for name, size in differences.sizes.items() if name != "model"]
    lattice = " x ".join(map(str, sizes))
    return {
        f"{row['model']} other regime, {lattice} points": stated(
            row["other_regime_percent"], 1e4 / (math.prod(sizes) * row["compared_percent"])
        )
        for row in rows
    }
