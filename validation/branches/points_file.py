"""What files of branches and of curves have in common: tables of points, and arrays from which they go on."""

import hashlib
import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from reduced.continuation.start import Stored
from slipwave.errors import SceneError
from slipwave.files import reason_of, whole_or_absent

if TYPE_CHECKING:
    from netCDF4 import Dataset

UNDECIDED = -1
"""In place of None in a column of numbers."""

_POINT = ("unknowns", "tangent", "monodromy", "velocity", "drift")

Read = TypeVar("Read")


def write_points(
    path: Path,
    facts: Mapping[str, Any],
    notes: list[str],
    complete: bool,
    origin: Mapping[str, Any],
    fill: "Callable[[Dataset], None]",
) -> None:
    """Write a file whole: its `facts`, which a continuation must share, `notes`, and what `fill` adds; with attributes that say
    its `origin`. Raises SceneError if it cannot be written."""
    from netCDF4 import Dataset

    with whole_or_absent(path) as temporary, Dataset(temporary, "w") as file:
        file.setncatts({**origin, "complete": int(complete)})
        file.setncattr("facts", json.dumps(facts))
        file.setncattr("notes", json.dumps(notes))
        fill(file)
        file.setncattr("contents", _digest(file))


def read_points(path: Path, what: str, facts: Mapping[str, Any], take: "Callable[[Dataset, list[str]], Read]") -> Read:
    """What `take` gives of the file and its notes, those of an earlier end left out.

    Raises SceneError if the file cannot be read as one of `what`, or has other `facts`."""
    from netCDF4 import Dataset

    try:
        with Dataset(path) as file:
            _require_same(path, what, json.loads(file.getncattr("facts")), json.loads(json.dumps(facts)))
            notes = [
                note for note in json.loads(file.getncattr("notes")) if not note.startswith(("stopped ", f"the {what} leaves "))
            ]
            if file.getncattr("contents") != _digest(file):
                raise ValueError("its contents have changed since it was written")
            return take(file, notes)
    except SceneError:
        raise
    except (OSError, LookupError, ValueError, TypeError, RuntimeError, AttributeError) as error:
        raise SceneError(f"--resume {str(path)!r}: is no file of a {what}, or damaged: {reason_of(error)}") from None


def _digest(file: "Dataset") -> str:
    """Hash of all variables, also of the groups."""
    digest = hashlib.sha256()
    for group in (file, *(file.groups[name] for name in sorted(file.groups))):
        for name in sorted(group.variables):
            values = np.asarray(group[name][:])
            content = str(values.tolist()).encode() if values.dtype == object else values.tobytes()
            digest.update(f"{group.path} {name} {values.shape}".encode() + content)
    return digest.hexdigest()


def _require_same(path: Path, what: str, facts: dict[str, Any], wanted: dict[str, Any]) -> None:
    for name, value in wanted.items():
        if facts.get(name) != value:
            raise SceneError(f"--resume {str(path)!r}: {name} is {facts.get(name)!r}; this {what} has {value!r}")


def table(file: "Dataset", kind: str, names: tuple[str, ...], rows: Any, parameter: str) -> None:
    """Write the rows of points as one variable of the dimension `kind` for each of their `names`."""
    file.createDimension(kind, len(rows))
    for name, column in zip(names, zip(*rows, strict=True) if rows else [()] * len(names), strict=True):
        text = name == "kind"
        values = [UNDECIDED if value is None else value for value in column]
        variable = file.createVariable(f"{kind}_{name}", str if text else "f8", (kind,))
        variable[:] = np.array(values, dtype=object if text else float)
        variable.setncatts(
            {"long_name": parameter if name == "value" else name.replace("_", " ")} | ({} if text else {"units": "1"})
        )


def rows(file: "Dataset", kind: str, names: tuple[str, ...]) -> list[tuple[Any, ...]]:
    """The rows that `table` wrote, with whole numbers where they count, or None."""
    columns = [file[f"{kind}_{name}"][:].tolist() for name in names]
    whole = {"unstable", "unstable_before", "unstable_after", "place"}
    for n, name in enumerate(names):
        if name in whole:
            columns[n] = [None if value == UNDECIDED else int(value) for value in columns[n]]
    return list(zip(*columns, strict=True))


def arrays(group: "Dataset", arrays: dict[str, Any]) -> None:
    """Write arrays with dimensions of their own."""
    for name, array in arrays.items():
        dimensions = [f"{name}_{axis}" for axis in range(array.ndim)]
        for dimension, size in zip(dimensions, array.shape, strict=True):
            group.createDimension(dimension, size)
        group.createVariable(name, "f8", dimensions)[:] = array


def saved_arrays(saved: Stored) -> dict[str, Any]:
    """A point of a branch as arrays by name."""
    found = {f"mesh_{name}": np.atleast_1d(array) for name, array in saved.mesh.items()}
    return found | {name: getattr(saved, name) for name in _POINT} | {"step": np.array([saved.step])}


def saved_point(state: Mapping[str, Any]) -> Stored:
    """The inverse of `saved_arrays`."""
    mesh = {name.removeprefix("mesh_"): array for name, array in state.items() if name.startswith("mesh_")}
    return Stored(step=float(state["step"][0]), mesh=mesh, **{name: state[name] for name in _POINT})


def read_arrays(group: "Dataset") -> dict[str, Any]:
    """What `arrays` wrote."""
    return {name: np.asarray(variable[:]) for name, variable in group.variables.items()}
