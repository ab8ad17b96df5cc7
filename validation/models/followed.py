"""The loop that follows branches and curves, and their netCDF file, written whole after each point, from which a killed process
can be continued."""

import hashlib
import json
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from reduced.continuation.branch import BRANCH_TOLERANCE
from slipwave.errors import NumericsError, SceneError
from slipwave.files import ONE_THREAD, reason_of, whole_or_absent
from slipwave.input.assemble import read
from slipwave.input.stored import read_stored
from slipwave.solve import State
from validation.data.variables import EVENTS, attributes, figures_at
from validation.models.branch import FollowedBranch
from validation.models.curve import Curve
from validation.models.parameter import names_of, over_range, scenes_with
from validation.models.points import StopAt
from validation.models.progress import progress

if TYPE_CHECKING:
    from netCDF4 import Dataset

_UNCOUNTED = -1  # stands for None in a column of numbers
_KINDS = dict.fromkeys(("unstable", "unstable_before", "unstable_after", "place"), int) | {"stable": bool, "idle": bool}
End: TypeAlias = Any
"""The end of a branch or a curve, from which it continues."""

Followed: TypeAlias = FollowedBranch | Curve
"""A branch or a curve; its `points` and `notes` grow."""


def pursue(
    followed: Followed, limits: StopAt, file: Path | None, resume: Path | None, origin: Mapping[str, Any]
) -> tuple[End | None, str, bool]:
    """Fill an empty `followed`, from its beginning or from a file to `resume`, within the limits; write `file`, if given, after
    each point. The end from which it continues, or None; the reason of an early end, or empty; whether the user stopped it.
    Raises SceneError if a file cannot be written, and for a file to resume that cannot be read or has other `facts`."""
    end, failed, stopped = None, "", False
    try:
        for end in ends_of(followed, limits, resume):
            if file is not None:
                write_followed(file, followed, end, False, origin)
        if file is not None and end is not None:
            write_followed(file, followed, end, True, origin)
    except NumericsError as error:
        failed = str(error)
    except KeyboardInterrupt:
        failed, stopped = f"interrupted after {len(followed.points)} points", True
    return end, failed, stopped


def ends_of(followed: Followed, limits: StopAt, resume: Path | None = None) -> Iterator[End]:
    """Fill `followed` with progress, yielding its end after each point. Raises NumericsError where it cannot be followed."""
    try:
        end: End = followed.begin() if resume is None else _read_followed(resume, followed)
        if end is None and len(followed.points) > limits.points:  # Hopf points are found all at once
            del followed.points[limits.points :]
            followed.notes.append(f"stopped after {limits.points} points: --most-points goes further")
        if end is not None:
            yield end
            with progress(f"{followed.over.base.name}, {followed.model}, points of the {followed.what}", limits.points) as report:
                for later in followed.follow(end, limits):
                    yield later
                    report(len(followed.points))
    except NumericsError as error:  # the continuation knows no name of its parameter
        raise NumericsError(str(error).replace("parameter = ", f"{followed.over.name} = ")) from None


def write_followed(path: Path, followed: Followed, end: End, complete: bool, origin: Mapping[str, Any]) -> None:
    """Write `followed` and its `end`, with the attributes `origin`. Raises SceneError if the file cannot be written."""
    from netCDF4 import Dataset

    facts = json.dumps(followed.facts | {"tolerance": followed.tolerance})
    with whole_or_absent(path) as temporary, Dataset(temporary, "w") as file:
        file.setncatts({**origin, "complete": int(complete), "facts": facts, "notes": json.dumps(followed.notes)})
        for kind, (record, rows) in followed.tables.items():
            _write_table(file, kind, record._fields, rows, followed)
            if complete:  # not at each point, which would read all scenes again
                _write_twins(file, kind, record._fields, rows, followed)
        for name, state in followed.saved(end).items():
            _write_arrays(file.createGroup(name), state)
        file.setncattr("contents", _digest(file))


def read_branch(path: Path, option: str) -> FollowedBranch:
    """The branch in a file of `slipwave branch`. Raises SceneError, naming the `option`, if it is none or damaged."""
    stored = read_stored(path, option, "branch")
    given = stored.options
    text = str(given.get("over"))
    scenes = scenes_with(read(stored.tables), names_of(text, given.get("ends")), given.get("set", {}))
    with suppress(LookupError, ValueError, TypeError):  # `_read_followed` says what is wrong
        scenes = replace(scenes, fixed=json.loads(stored.facts["facts"])["fixed"])
    over = over_range(text, scenes, option)
    doubled, tolerance = given.get("switch") == "PD", float(given.get("tol") or BRANCH_TOLERANCE)
    followed = FollowedBranch(over, stored.model, tolerance, given.get("cells"), doubled)
    _read_followed(path, followed, option)
    return followed


def _read_followed(path: Path, followed: Followed, option: str = "--resume") -> End:
    """Fill an empty `followed` from the file, without notes on its end; returns its end. The tolerance may differ: the mesh is
    refined at the next point if necessary. Raises SceneError if the file cannot be read, or has other `facts`."""
    from netCDF4 import Dataset

    try:
        with ONE_THREAD, Dataset(path) as file:
            facts = json.loads(file.getncattr("facts"))
            for name, value in json.loads(json.dumps(followed.facts)).items():
                if facts.get(name) != value:
                    differs = f"{name} is {facts.get(name)!r}; this {followed.what} has {value!r}"
                    anew = "; without --resume it begins anew" if option == "--resume" else ""
                    raise SceneError(f"{option} {str(path)!r}: {differs}{anew}")
            if file.getncattr("contents") != _digest(file):
                raise ValueError("its contents have changed since it was written")
            for kind, (record, rows) in followed.tables.items():
                rows.extend(record._make(row) for row in _read_table(file, kind, record._fields))
            notes = json.loads(file.getncattr("notes"))
            saved = {name: {key: np.asarray(v[:]) for key, v in group.variables.items()} for name, group in file.groups.items()}
            before, last = float(facts["tolerance"]), float(followed.points[-1][0])
    except SceneError:
        raise
    except (OSError, LookupError, ValueError, TypeError, RuntimeError, AttributeError) as error:
        raise SceneError(f"{option} {str(path)!r}: is no file of a {followed.what}, or damaged: {reason_of(error)}") from None
    followed.notes.extend(note for note in notes if not note.startswith(("stopped ", f"the {followed.what} leaves ")))
    if before != followed.tolerance:
        until = f"up to {followed.over.name} = {last:.10g}, {len(followed.points)} in all"
        followed.notes.append(f"points {until}, were computed with tol = {before:g}, those after it with {followed.tolerance:g}")
    return followed.restored(saved)


def _digest(file: "Dataset") -> str:
    """Hash of all variables, also of the groups."""
    digest = hashlib.sha256()
    for group in (file, *(file.groups[name] for name in sorted(file.groups))):
        for name in sorted(group.variables):
            values = np.asarray(group[name][:])
            content = str(values.tolist()).encode() if values.dtype == object else values.tobytes()
            digest.update(f"{group.path} {name} {values.shape}".encode() + content)
    return digest.hexdigest()


def _write_table(file: "Dataset", kind: str, names: tuple[str, ...], rows: list[Any], followed: Followed) -> None:
    """One variable of the dimension `kind` for each column."""
    file.createDimension(kind, len(rows))
    for name, column in zip(names, zip(*rows, strict=True) if rows else [()] * len(names), strict=True):
        text = name == "kind"
        variable = file.createVariable(f"{kind}_{name}", str if text else "f8", (kind,))
        variable[:] = np.array([_UNCOUNTED if value is None else value for value in column], dtype=object if text else float)
        variable.setncatts({"long_name": "kind"} if text else _notes(name, followed))


def _write_twins(file: "Dataset", kind: str, names: tuple[str, ...], rows: list[Any], followed: Followed) -> None:
    """The figures in SI, for a scene with units, each by those of its own scene."""
    figures = {name: [getattr(row, name) for row in rows] for name in names if name in EVENTS}
    every = figures_at(kind, figures, followed.over.base, lambda: [*map(followed.scene_of, rows)])
    for name in (name for name in every if name not in figures):
        variable = file.createVariable(f"{kind}_{name}", "f8", (kind,))
        variable[:] = every[name][1]
        variable.setncatts(every[name][2])


def _notes(name: str, followed: Followed) -> dict[str, Any]:
    """Attributes of a column of numbers, without sizes of units in SI, which may change from point to point."""
    over = followed.over if name == "bracket" else followed.varied.get(name)  # its width in the first parameter
    if over is not None:
        return {"long_name": name if name == "bracket" else over.name, "units": over.si_unit or "1"}
    if name not in EVENTS:
        return {"long_name": name.replace("_", " "), "units": "1"}
    return {key: note for key, note in attributes(EVENTS[name], followed.over.base).items() if key != "si_factor"}


def _read_table(file: "Dataset", kind: str, names: tuple[str, ...]) -> Iterator[tuple[Any, ...]]:
    """The rows that `_write_table` wrote, with whole numbers, truth values and None restored."""
    columns = [(file[f"{kind}_{name}"][:].tolist(), _KINDS.get(name)) for name in names]
    whole = ([None if value == _UNCOUNTED else kind(value) for value in column] if kind else column for column, kind in columns)
    return zip(*whole, strict=True)


def _write_arrays(group: "Dataset", arrays: State) -> None:
    """Write arrays with dimensions of their own."""
    for name, array in arrays.items():
        dimensions = [f"{name}_{axis}" for axis in range(array.ndim)]
        for dimension, size in zip(dimensions, array.shape, strict=True):
            group.createDimension(dimension, size)
        group.createVariable(name, "f8", dimensions)[:] = array
