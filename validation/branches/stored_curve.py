"""A curve of special points as a netCDF file that is written whole after each point, as that of a branch (`stored`)."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from reduced.continuation.curve import OnCurve, Place, Reached
from reduced.continuation.point import Family
from reduced.continuation.special import Special
from reduced.continuation.start import from_stored, stored
from slipwave.sources import source_digest
from validation.branches.curve import Curve, CurvePoint
from validation.branches.follow import family_at
from validation.branches.points_file import (
    arrays,
    read_arrays,
    read_points,
    rows,
    saved_arrays,
    saved_point,
    table,
    write_points,
)
from validation.branches.record import Branch

if TYPE_CHECKING:
    from netCDF4 import Dataset

FORMAT = 1
_COLUMNS = (*CurvePoint._fields[:-1], "multiplier_re", "multiplier_im")


def write(path: Path, curve: Curve, reached: Reached, complete: bool, origin: Mapping[str, Any]) -> None:
    """Write all of the curve and what is `reached`. Raises SceneError if the file cannot be written."""

    def fill(file: "Dataset") -> None:
        """The table, and where to go on."""
        table(file, "point", _COLUMNS, [(*point[:-1], *point.multiplier) for point in curve.points], curve.over.name)
        for name, point in (("before", reached.before), ("last", reached.last)):
            arrays(file.createGroup(name), _state(point, reached.length))
        arrays(file.createGroup("resume"), {"direction": np.array(reached.direction)})

    write_points(path, _facts(curve), curve.notes, complete, origin, fill)


def read(path: Path, curve: Curve) -> Reached:
    """Fill an empty `curve` from the file, and say where it goes on.

    Raises SceneError if the file cannot be read, or holds a curve of another scene, model, kind, rectangle or tolerance."""

    def take(file: "Dataset", notes: list[str]) -> tuple[dict[str, Any], dict[str, Any], Place]:
        """Fill the curve."""
        curve.notes.extend(notes)
        curve.points.extend(CurvePoint._make((*row[:-2], row[-2:])) for row in rows(file, "point", _COLUMNS))
        along, across = read_arrays(file["resume"])["direction"].tolist()
        return read_arrays(file["before"]), read_arrays(file["last"]), (along, across)

    before, last, direction = read_points(path, "curve", _facts(curve), take)
    end = _on_curve(curve, last)
    first = len(curve.points) < 2
    return Reached(end if first else _on_curve(curve, before), end, direction, saved_point(last).step)


def _facts(curve: Curve) -> dict[str, Any]:
    """What a file and the curve that goes on from it must have in common."""
    ends = [[one.name, one.first, one.last] for one in (curve.over, curve.second)]
    return {
        "format": FORMAT,
        "scene": curve.over.base.digest,
        "model": curve.model,
        "type": curve.kind,
        "rectangle": ends,
        "tolerance": curve.tolerance,
        "sources": source_digest(),
    }


def _state(one: OnCurve, length: float) -> dict[str, Any]:
    """A point of the curve as arrays."""
    special = one.special
    numbers = (special.bracket, special.unstable_before, special.unstable_after, special.multiplier.real, special.multiplier.imag)
    return saved_arrays(stored(special.point, length)) | {"place": np.array(one.place), "special": np.array(numbers)}


def _on_curve(curve: Curve, state: Mapping[str, Any]) -> OnCurve:
    """The inverse of `_state`."""
    first, second = state["place"].tolist()
    bracket, before, after, real, imaginary = state["special"].tolist()
    scene = curve.plane.scene_at(first, second)
    saved = saved_point(state)
    branch = Branch(curve.at_first(), curve.model, curve.tolerance)
    flow = family_at(branch, first, float(saved.unknowns[-2]))(first)
    _, point = from_stored(Family(flow, lambda _: scene), saved)
    passing = complex(real, imaginary)
    return OnCurve((first, second), Special(curve.kind, point, bracket, round(before), round(after), passing))
