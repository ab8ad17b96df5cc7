"""Index of the points of a branch by its parameter, which may turn back."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from xarray import Dataset
from xarray.core.indexing import IndexSelResult
from xarray.indexes import PandasIndex


class _AlongBranch(PandasIndex):
    """`.sel(log10_r=-2.6)` gives the nearest point on each part of the branch that passes this value, `slice(a, b)` all points
    between."""

    def sel(self, labels: Mapping[Any, Any], method: str | None = None, tolerance: Any = None) -> IndexSelResult:
        """Indices of the points. Raises KeyError where no part of the branch passes the value."""
        ((name, label),) = labels.items()
        values = np.asarray(self.index, dtype=float)
        if isinstance(label, slice):
            low, high = sorted(
                (values.min() if label.start is None else label.start, values.max() if label.stop is None else label.stop)
            )
            indices = np.flatnonzero((values >= low) & (values <= high))
        else:  # for each crossing of the value the nearer one of the two points next to it
            value = float(np.asarray(label))
            side = np.sign(values - value)
            before = np.flatnonzero(side[:-1] * side[1:] < 0.0)
            nearer = np.abs(values[before] - value) <= np.abs(values[before + 1] - value)
            indices = np.union1d(np.where(nearer, before, before + 1), np.flatnonzero(side == 0.0))
        if not indices.size:
            raise KeyError(f"{name} = {label}: the branch goes from {values.min():g} to {values.max():g}")
        return IndexSelResult({self.dim: indices})


def along(data: Dataset, name: str) -> Dataset:
    """`data` of points of a branch, indexed by the variable `name`, the parameter (`_AlongBranch`)."""
    return data.set_coords(name).set_xindex(name, _AlongBranch)
