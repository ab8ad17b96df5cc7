"""A branch as a netCDF file that is written whole after each point: a process killed at any time leaves a file to go on from."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from reduced.continuation.point import Metric
from reduced.continuation.start import Stored, from_stored, stored
from slipwave.errors import SceneError
from slipwave.files import reason_of, whole_or_absent
from slipwave.sources import source_digest
from validation.branches.follow import Head, family_at
from validation.branches.record import Branch, BranchPoint, SpecialPoint

if TYPE_CHECKING:
    from netCDF4 import Dataset

FORMAT = 2
_UNDECIDED = -1  # of `stable`
_POINT = ("unknowns", "tangent", "monodromy", "velocity", "drift")


def write(path: Path, branch: Branch, head: Head, complete: bool, origin: Mapping[str, Any] | None = None) -> None:
    """Write all of the branch and where it goes on, with attributes that say its `origin`. Raises SceneError if the file cannot
    be written."""
    from netCDF4 import Dataset

    with whole_or_absent(path) as temporary, Dataset(temporary, "w") as file:
        file.setncatts({**(origin or {}), "complete": int(complete)})
        file.setncattr("facts", json.dumps(_facts(branch)))
        file.setncattr("notes", json.dumps(branch.notes))
        _table(file, "point", BranchPoint._fields, branch.points, branch.over.name)
        _table(file, "special", SpecialPoint._fields, branch.special, branch.over.name)
        _arrays(file.createGroup("resume"), _state(head))


def read(path: Path, branch: Branch) -> Head:
    """Fill an empty `branch` from the file, and say where it goes on.

    Raises SceneError if the file cannot be read, or holds a branch of another scene, model, parameter or tolerance.
    """
    from netCDF4 import Dataset

    try:
        with Dataset(path) as file:
            facts, wanted = json.loads(file.getncattr("facts")), json.loads(json.dumps(_facts(branch)))
            _require_same(path, facts, wanted)
            branch.notes.extend(
                note for note in json.loads(file.getncattr("notes")) if not note.startswith(("stopped ", "the branch leaves "))
            )
            branch.points.extend(_point(row) for row in _rows(file, "point", BranchPoint._fields))
            branch.special.extend(SpecialPoint(*row) for row in _rows(file, "special", SpecialPoint._fields))
            state = {name: np.asarray(variable[:]) for name, variable in file["resume"].variables.items()}
    except SceneError:
        raise
    except (OSError, LookupError, ValueError, AttributeError) as error:
        raise SceneError(f"--resume {str(path)!r}: is no file of a branch, or damaged: {reason_of(error)}") from None
    return _head(branch, state)


def _facts(branch: Branch) -> dict[str, Any]:
    """What a file and the branch that goes on from it must have in common."""
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


def _require_same(path: Path, facts: dict[str, Any], wanted: dict[str, Any]) -> None:
    for name, value in wanted.items():
        if facts.get(name) != value:
            raise SceneError(f"--resume {str(path)!r}: {name} is {facts.get(name)!r}; this branch has {value!r}")


def _table(file: "Dataset", kind: str, names: tuple[str, ...], rows: Any, parameter: str) -> None:
    file.createDimension(kind, len(rows))
    for name, column in zip(names, zip(*rows, strict=True) if rows else [()] * len(names), strict=True):
        text = name == "kind"
        values = [_UNDECIDED if value is None else value for value in column]
        variable = file.createVariable(f"{kind}_{name}", str if text else "f8", (kind,))
        variable[:] = np.array(values, dtype=object if text else float)
        variable.setncatts(
            {"long_name": parameter if name == "value" else name.replace("_", " ")} | ({} if text else {"units": "1"})
        )


def _rows(file: "Dataset", kind: str, names: tuple[str, ...]) -> list[tuple[Any, ...]]:
    columns = [file[f"{kind}_{name}"][:].tolist() for name in names]
    whole = {"unstable", "unstable_before", "unstable_after", "place"}
    columns = [[int(value) for value in column] if name in whole else column for name, column in zip(names, columns, strict=True)]
    return list(zip(*columns, strict=True))


def _point(row: tuple[Any, ...]) -> BranchPoint:
    point = BranchPoint(*row)
    return point._replace(stable=None if point.stable == _UNDECIDED else bool(point.stable))


def _arrays(group: "Dataset", arrays: dict[str, Any]) -> None:
    for name, array in arrays.items():
        dimensions = [f"{name}_{axis}" for axis in range(array.ndim)]
        for dimension, size in zip(dimensions, array.shape, strict=True):
            group.createDimension(dimension, size)
        group.createVariable(name, "f8", dimensions)[:] = array


def _state(head: Head) -> dict[str, Any]:
    """All of a head as arrays."""
    saved, metric = stored(head.point, head.step), head.metric
    arrays = {f"mesh_{name}": np.atleast_1d(array) for name, array in saved.mesh.items()}
    arrays |= {name: getattr(saved, name) for name in _POINT}
    return arrays | {"step": np.array([saved.step]), "metric": np.array([metric.period, metric.parameter])}


def _head(branch: Branch, state: dict[str, Any]) -> Head:
    """The inverse of `_state`."""
    mesh = {name.removeprefix("mesh_"): array for name, array in state.items() if name.startswith("mesh_")}
    saved = Stored(step=float(state["step"][0]), mesh=mesh, **{name: state[name] for name in _POINT})
    period, parameter = saved.unknowns[-2:].tolist()
    _, point = from_stored(family_at(branch, parameter, period), saved)
    return Head(point, saved.step, Metric(*state["metric"].tolist()))
