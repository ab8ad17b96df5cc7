"""Rows of a summary as variables of a Dataset."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from slipwave.extras import require
from slipwave.scene import Scene
from validation.results.facts import leaves
from validation.results.quantities import column_notes
from validation.results.result import Dataset


def table_of(rows: Sequence[Mapping[str, Any]], dimension: str, scene: Scene) -> Dataset:
    """The rows of a summary on `scene` as variables over `dimension`: numbers and words by their dotted keys, NaN where there is
    none."""
    require("files", "a dataset")
    import xarray

    flat = [dict(leaves(row)) for row in rows]
    names = dict.fromkeys(name for row in flat for name in row)
    columns = {name: _column([row.get(name) for row in flat]) for name in names}
    notes = {name: column_notes(name, scene, column.dtype == float) for name, column in columns.items()}
    found = xarray.Dataset({name.replace(".", "_"): (dimension, columns[name], notes[name]) for name in names})
    return found.set_coords("model") if "model" in found else found


def _column(values: Sequence[Any]) -> "np.ndarray[Any, Any]":
    words = any(isinstance(value, str) for value in values)
    empty = "" if words else math.nan
    return np.array([empty if value is None else value for value in values], dtype=object if words else float)
