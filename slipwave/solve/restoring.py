"""Restores a solver's state from a checkpoint: all of it or, with one line that says what is wrong, nothing."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipwave.errors import SceneError
from slipwave.observe.pieces import Array


def whole_numbers(state: Mapping[str, NDArray[Any]], name: str, least: tuple[int, ...]) -> list[int]:
    """The counts in `state[name]`, one per entry of `least`. Raises SceneError unless each is a whole number >= that entry."""
    counts = state.get(name)
    if counts is None or counts.shape != (len(least),) or counts.dtype.kind not in "if":
        raise SceneError(f"{name} is missing or does not hold {len(least)} numbers")
    for count, lowest in zip(counts.tolist(), least, strict=True):
        if not (lowest <= count <= 2**53 and count == int(count)):
            raise SceneError(f"{name} holds {count!r}: must be a whole number from {lowest}")
    return [int(count) for count in counts.tolist()]


def tables(state: Mapping[str, NDArray[Any]], shapes: Mapping[str, tuple[int, ...]], model: str) -> dict[str, Array]:
    """Copies of the arrays of `state` named in `shapes` (-1: any length). Raises SceneError unless they are finite and fit."""
    saved = {}
    for name, shape in shapes.items():
        array = state.get(name, np.empty(0, dtype=bool))
        fits = len(shape) == array.ndim and all(wanted in (-1, size) for wanted, size in zip(shape, array.shape, strict=True))
        if array.dtype != np.float64 or not fits:
            raise SceneError(f"checkpoint: {name} does not fit this scene with model {model}")
        if not np.isfinite(array).all():
            raise SceneError(f"checkpoint: {name} holds numbers that are not finite")
        saved[name] = array.copy()
    return saved


def take_back(own: Mapping[str, Array], state: Mapping[str, NDArray[Any]], model: str) -> None:
    """own[name][...] = state[name] for every name. Raises SceneError before any is set unless all fit and are finite."""
    saved = tables(state, {name: array.shape for name, array in own.items()}, model)
    for name, array in own.items():
        array[...] = saved[name]
