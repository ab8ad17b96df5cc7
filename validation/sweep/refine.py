"""Refines a map: a coarse lattice and, from level to level, the cells in which the regime changes.

A cell is divided if its corners, or a neighbour's, differ in regime. Each level is completed before the next is chosen, so that
the result does not depend on the order of computation. One in a hundred of the other cells, selected by its number, is divided
too: the share of these with another regime inside is the map's error bar.
"""

from collections.abc import Callable, Mapping
from itertools import product
from typing import Any

import numpy as np
import numpy.typing as npt
from numpy.lib.stride_tricks import sliding_window_view
from scipy.ndimage import binary_dilation

from validation.sweep.measures import Measure, decided_regimes
from validation.sweep.plan import Indices, Plan

_AUDITED = 100
_UNKNOWN = -1
Regimes = npt.NDArray[np.int64]
Cells = npt.NDArray[np.bool_]


def regime_numbers(measure: Measure, arrays: Mapping[str, npt.NDArray[Any]]) -> Regimes:
    """One number per point for its regime, from the columns that distinguish regimes and its status; -1 if not computed.
    Undecided verdicts are one regime."""
    numbers = arrays["status"].astype(np.int64)
    for name in measure.regime:
        values = np.nan_to_num(arrays[name], nan=-1.0) if name in arrays else np.full(numbers.size, -1.0)
        values = decided_regimes(values) if name == "verdict" else values
        numbers = numbers * 1024 + np.clip(values, -1, 1022).astype(np.int64) + 1
    return np.where(arrays["status"] < 0, _UNKNOWN, numbers)


def refine(plan: Plan, levels: int, compute: Callable[[Indices], None], regimes: Callable[[], Regimes]) -> tuple[int, int]:
    """Compute the points that the map of `plan` needs, level by level. `compute` takes numbers of points, which may exist
    already; `regimes` returns the regimes of all points. A neighbour of a cell whose corners differ may not exist, because its
    parent was not divided: then the parent is divided too, and all levels are repeated until nothing changes. Returns the number
    of cells divided for the audit, and of those in which another regime was hidden.
    """
    steps = {level: 2**level for level in range(levels, 0, -1)}
    divided = {level: np.zeros(_cells(plan, step), dtype=bool) for level, step in steps.items()}
    compute(np.flatnonzero(_points_of(np.ones(_cells(plan, 2**levels), dtype=bool), 2**levels, 1, plan)))
    before = -1
    while before != (before := sum(int(cells.sum()) for cells in divided.values())):
        for level, step in steps.items():
            there = _there(divided, level, levels)
            known = regimes().reshape(plan.shape)
            changed = divided[level] & _coarser(_differing(known, step // 2), 2)  # in which division found another regime
            wanted = _around((_differing(known, step) | changed) & there)
            divided[level] |= (wanted | _audited(there.shape)) & there
            for above in range(level + 1, levels + 1):
                divided[above] |= _coarser(wanted & ~there, 2 ** (above - level))
            compute(np.flatnonzero(_points_of(divided[level], step, 2, plan)))
    return _audit(plan, regimes().reshape(plan.shape), divided, levels)


def fill(plan: Plan, levels: int, regimes: Regimes, columns: Mapping[str, npt.NDArray[Any]]) -> None:
    """Fill points that are not computed from the corners of their cell, which have one regime: numbers by linear interpolation
    along each axis, words by copying."""
    known = regimes.reshape(plan.shape)
    given = {name: column.reshape(plan.shape).copy() for name, column in columns.items()}
    for level in range(levels, 0, -1):
        step = 2**level
        whole = (_corners(known, step) != _UNKNOWN).all(axis=-1)
        cells = [np.minimum(np.arange(n) // step, (n - 1) // step - 1) for n in plan.lattice]
        at = np.ix_(range(plan.shape[0]), *cells)
        wanted = whole[at] & (known == _UNKNOWN)
        for name, column in columns.items():
            corners = _coarse(given[name], step)
            if column.dtype.kind == "f":
                for axis, n in enumerate(plan.lattice, start=1):
                    positions = np.arange(n) / step
                    before = np.minimum(positions.astype(int), corners.shape[axis] - 2)
                    share = np.expand_dims(positions - before, tuple(range(1, corners.ndim - axis)))
                    corners = np.take(corners, before, axis) * (1.0 - share) + np.take(corners, before + 1, axis) * share
                column.reshape(plan.shape)[wanted] = corners[wanted]
            else:
                column.reshape(plan.shape)[wanted] = corners[at][wanted]


def _cells(plan: Plan, step: int) -> tuple[int, ...]:
    return (plan.shape[0], *((n - 1) // step for n in plan.lattice))


def _coarse(values: npt.NDArray[Any], step: int) -> npt.NDArray[Any]:
    """Every `step`-th value along each axis."""
    return values[(slice(None), *[slice(None, None, step)] * (values.ndim - 1))]


def _corners(known: Regimes, step: int) -> Regimes:
    """The regimes at the corners of all cells; the corners of a cell are the last axis."""
    pairs = sliding_window_view(_coarse(known, step), (2,) * (known.ndim - 1), tuple(range(1, known.ndim)))
    return pairs.reshape(*pairs.shape[: known.ndim], -1)


def _differing(known: Regimes, step: int) -> Cells:
    corners = _corners(known, step)
    return np.asarray((corners != corners[..., :1]).any(axis=-1))


def _around(cells: Cells) -> Cells:
    """These cells and their neighbours, for each model."""
    return np.asarray(binary_dilation(cells, np.ones((1, *[3] * (cells.ndim - 1)), dtype=bool)))


def _audited(shape: tuple[int, ...]) -> Cells:
    """One in a hundred cells, by a hash of their numbers (Knuth's multiplicative one)."""
    numbers = np.arange(1, int(np.prod(shape)) + 1, dtype=np.uint64) * np.uint64(2654435761) % np.uint64(2**32)
    return np.asarray(numbers % np.uint64(_AUDITED) == 0).reshape(shape)


def _there(divided: Mapping[int, Cells], level: int, levels: int) -> Cells:
    """The cells of a level: all of the coarsest, else the parts of those divided."""
    if level == levels:
        return np.ones_like(divided[level])
    cells = divided[level + 1]
    return np.kron(cells, np.ones((1, *[2] * (cells.ndim - 1)), dtype=bool))


def _coarser(cells: Cells, factor: int) -> Cells:
    """The cells, larger by `factor`, that contain one of `cells`."""
    for axis in range(1, cells.ndim):
        cells = np.logical_or.reduceat(cells, range(0, cells.shape[axis], factor), axis)
    return cells


def _points_of(cells: Cells, step: int, parts: int, plan: Plan) -> Cells:
    """The points of these cells on the lattice that divides each into `parts` along each axis."""
    lattice = np.zeros((cells.shape[0], *(n * parts + 1 for n in cells.shape[1:])), dtype=bool)
    for offsets in product(range(parts + 1), repeat=cells.ndim - 1):
        ends = (slice(offset, offset + (n - 1) * parts + 1, parts) for offset, n in zip(offsets, cells.shape[1:], strict=True))
        lattice[(slice(None), *ends)] |= cells
    points = np.zeros(plan.shape, dtype=bool)
    _coarse(points, step // parts)[...] = lattice
    return points


def _audit(plan: Plan, known: Regimes, divided: Mapping[int, Cells], levels: int) -> tuple[int, int]:
    """Numbers of audited cells, and of those with another regime than their corners."""
    count = hidden = 0
    for level in divided:
        step, there = 2**level, _there(divided, level, levels)
        chosen = _audited(there.shape) & there & ~_around(_differing(known, step) & there)
        other = _coarser(_differing(known, step // 2), 2)
        count, hidden = count + int(chosen.sum()), hidden + int((chosen & other).sum())
    return count, hidden
