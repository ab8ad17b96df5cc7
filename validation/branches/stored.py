"""A branch as a netCDF file that is written whole after each point: a process killed at any time leaves a file to go on from."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from reduced.continuation.point import Metric
from reduced.continuation.start import from_stored, stored
from slipwave.sources import source_digest
from validation.branches.follow import Head, family_at
from validation.branches.points_file import (
    UNDECIDED,
    arrays,
    read_arrays,
    read_points,
    rows,
    saved_arrays,
    saved_point,
    table,
    write_points,
)
from validation.branches.record import Branch, BranchPoint, SpecialPoint

if TYPE_CHECKING:
    from netCDF4 import Dataset

FORMAT = 2


def write(path: Path, branch: Branch, head: Head, complete: bool, origin: Mapping[str, Any] | None = None) -> None:
    """Write all of the branch and where it goes on, with attributes that say its `origin`. Raises SceneError if the file cannot
    be written."""

    def fill(file: "Dataset") -> None:
        """The tables, and where to go on."""
        table(file, "point", BranchPoint._fields, branch.points, branch.over.name)
        table(file, "special", SpecialPoint._fields, branch.special, branch.over.name)
        arrays(file.createGroup("resume"), _state(head))

    write_points(path, _facts(branch), branch.notes, complete, origin or {}, fill)


def read(path: Path, branch: Branch) -> Head:
    """Fill an empty `branch` from the file, and say where it goes on.

    It may go on with another tolerance: its mesh is refined, or kept, as the next point asks for.

    Raises SceneError if the file cannot be read, or holds a branch of another scene, model or parameter.
    """

    def take(file: "Dataset", notes: list[str]) -> dict[str, Any]:
        """Fill the branch."""
        branch.notes.extend(notes)
        branch.points.extend(_point(row) for row in rows(file, "point", BranchPoint._fields))
        branch.special.extend(SpecialPoint(*row) for row in rows(file, "special", SpecialPoint._fields))
        before = json.loads(file.getncattr("facts"))["tolerance"]
        if before != branch.tolerance:
            until = f"up to {branch.over.name} = {branch.points[-1].value:.10g}, {len(branch.points)} in all"
            branch.notes.append(f"points {until}, were computed with tol = {before:g}, those after it with {branch.tolerance:g}")
        return read_arrays(file["resume"])

    shared = {name: value for name, value in _facts(branch).items() if name != "tolerance"}
    return _head(branch, read_points(path, "branch", shared, take))


def _facts(branch: Branch) -> dict[str, Any]:
    """What a file and the branch that goes on from it must have in common, but for the tolerance."""
    return {
        "format": FORMAT,
        "scene": branch.over.base.digest,
        "model": branch.model,
        "cells": branch.cells,
        "doubled": branch.doubled,
        "parameter": branch.over.name,
        "tolerance": branch.tolerance,
        "sources": source_digest(),
    }


def _point(row: tuple[Any, ...]) -> BranchPoint:
    point = BranchPoint(*row)
    return point._replace(stable=None if point.stable == UNDECIDED else bool(point.stable))


def _state(head: Head) -> dict[str, Any]:
    """All of a head as arrays."""
    metric = np.array([head.metric.period, head.metric.parameter])
    return saved_arrays(stored(head.point, head.step)) | {"metric": metric}


def _head(branch: Branch, state: dict[str, Any]) -> Head:
    """The inverse of `_state`."""
    saved = saved_point(state)
    period, parameter = saved.unknowns[-2:].tolist()
    _, point = from_stored(family_at(branch, parameter, period), saved)
    return Head(point, saved.step, Metric(*state["metric"].tolist()))
