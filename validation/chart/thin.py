"""Which of the computed numbers a file keeps.

A curve keeps at most `MOST` points and its gaps. The points are divided into equal runs; of each, the first and last are kept,
and those of least and largest y (and of x where the curve turns back), so that every extremum is kept.
"""

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipwave.observe.pieces import Array
from validation.chart import Chart, Trace, with_limits

MOST = 2000
"""Most points of a curve in a panel."""

CELLS = 64
"""Most cells of a picture in each direction."""


def with_fewer(chart: Chart) -> Chart:
    """The chart with some of its numbers, none of them changed."""
    panels = [replace(panel, traces=[_thinned(trace) for trace in panel.traces]) for panel in with_limits(chart).panels]
    return replace(chart, panels=panels)


def _thinned(trace: Trace) -> Trace:
    columns = trace.columns
    if trace.value is not None:
        x, y, value = (np.asarray(values, float) for values in (trace.x, trace.y, trace.value))
        rows, across = (np.unique(np.linspace(0, n - 1, min(n, CELLS)).astype(int)) for n in value.shape)
        return replace(trace, x=x[across], y=y[rows], value=value[np.ix_(rows, across)])
    if not trace.is_said:
        return trace
    chosen = staying(columns["x"], columns["y"])
    changes: dict[str, Any] = {name: values[chosen] for name, values in columns.items()}
    return replace(trace, **changes)


def staying(x: Array, y: Array, most: int = MOST) -> NDArray[np.intp]:
    """Indices of the points that are kept (see the docstring of this module)."""
    if x.size <= most:
        return np.arange(x.size)
    both = (y,) if np.all(np.diff(x) >= 0.0) else (x, y)
    edges = np.linspace(0, x.size, max(1, most // (2 + 2 * len(both))) + 1).astype(int)
    chosen = [*edges[:-1], *(edges[1:] - 1), *np.flatnonzero(np.isnan(y))]
    for begin, end in pairwise(edges):
        finite = [values[begin:end] for values in both if np.isfinite(values[begin:end]).any()]
        chosen += [begin + int(find(values)) for values in finite for find in (np.nanargmin, np.nanargmax)]
    return np.unique(chosen)
