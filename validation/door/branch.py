"""`slipwave.branch`: periodic orbits followed in a parameter, through folds, with the points where their stability changes."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from reduced.orbit.closing import Closed
from slipwave.errors import SceneError
from slipwave.extras import require
from slipwave.input import SceneSource
from slipwave.input.stored import recall
from slipwave.input.wording import shorten
from slipwave.scene import Scene
from slipwave.scene.doubts import doubts
from validation.branches import KINDS
from validation.branches.branch import Branch
from validation.branches.drawing import figure_of_branch
from validation.branches.followed import Followed, Limits, Outcome, pursue, write
from validation.branches.parameter import Values, over_range, range_text, scene_along
from validation.branches.points import BranchPoint, SpecialPoint
from validation.door.checked import checked
from validation.door.result import Dataset, Place, Result, announced, as_path, deliver, finite, scene_of
from validation.registry.orbits import flowing, require_tolerance
from validation.results.provenance import SCHEMA, provenance
from validation.results.quantities import EVENTS, variables
from validation.results.tables import along, parameter_column
from validation.study.drawing import Drawing, styled

_DEFAULTS = {"tol": 1e-6, "most_points": 2000}


@dataclass(frozen=True, repr=False, eq=False)
class FollowedResult(Result):
    """What was `found`, how its computation ended, and the options of the call."""

    found: Followed
    outcome: Outcome
    options: Mapping[str, Any]

    @property
    def summary(self) -> dict[str, Any]:
        """The JSON of the command (users rely on its keys); `failed` is there only if the numerics failed or the user stopped
        it."""
        found, outcome = self.found, self.outcome
        result = {
            "schema": SCHEMA,
            "scene": found.over.base.name,
            "model": found.model,
            "clock": "transit",
            **self._rows(),
            "wall_s": outcome.wall_s,
            "notes": [*doubts(found.over.base), *found.notes],
        }
        return dict(finite(result | ({"failed": outcome.failed} if outcome.failed else {})))

    def _rows(self) -> dict[str, Any]:
        """What differs between branches and curves."""
        raise NotImplementedError

    def to_netcdf(self, path: str | Path) -> None:
        """Write it and, where there is one, the point from which it can go on. Raises SceneError if the file cannot be
        written."""
        if self.outcome.head is None:
            super().to_netcdf(path)
        else:
            write(Path(path), self.found, self.outcome.head, not self.outcome.failed, facts_of_file(self.found, self.options))


@dataclass(frozen=True, repr=False, eq=False)
class BranchResult(FollowedResult):
    """A branch."""

    found: Branch

    def _rows(self) -> dict[str, Any]:
        found = self.found
        points, special = ([_at(found, row) for row in rows] for rows in (found.shown, found.shown_special))
        return {"parameter": found.over.name, "points": points, "special": special}

    @cached_property
    def dataset(self) -> Dataset:
        """The points by `point` and the special points by `special`, at their values of the parameter. The figures of points
        are there under their plain names too, over an index of the parameter: `.sel(log10_r=-2.6)` (`AlongBranch`)."""
        require("files", "a dataset")
        import xarray

        found, scene = self.found, self.found.over.base
        values = _table("point", BranchPoint._fields, found.shown, scene)
        plain = {name.removeprefix("point_"): value for name, value in values.items()}
        plain |= {parameter_column(found.over.name): plain.pop("value")}
        values |= plain | _table("special", SpecialPoint._fields, found.shown_special, scene)
        data = xarray.Dataset(values, attrs=facts_of_file(found, self.options)).set_coords(["point_value", "special_value"])
        return along(data, found.over.name)

    @property
    def points(self) -> list[Place]:
        """Those of the JSON; each can be given to `slipwave.orbit` in place of a scene."""
        return [self._place(point, None) for point in self.found.shown]

    @property
    def special(self) -> list[Place]:
        """The special points, likewise."""
        found = self.found
        return [self._place(one, found.closed.get(k)) for k, one in enumerate(found.special) if found.over.holds(one.value)]

    def _place(self, point: BranchPoint | SpecialPoint, closed: Closed | None) -> Place:
        found = self.found
        return Place(finite(_at(found, point)), scene_along(found.over, point.value), found.model, closed, found.tolerance)

    def plot(self) -> Drawing:
        """Period and stress drops against the parameter."""
        with styled():
            return figure_of_branch(self.found)


@checked
def branch(
    source: SceneSource,
    over: Values | None = None,
    model: str = "auto",
    *,
    tol: float | None = None,
    cells: int | None = None,
    out: str | Path | None = None,
    resume: str | Path | None = None,
    stop_at: str | None = None,
    switch: str | None = None,
    longest_period: float | None = None,
    most_points: int | None = None,
    settings: Iterable[str] = (),
    **changes: Any,
) -> BranchResult:
    """Follow periodic orbits from where steady sliding loses stability, stable or not, through folds; `changes` are those of
    `slipwave.read_scene`.

    `over` is the parameter with its range: "log10_r=-2.72:-2.30" or ("log10_r", -2.72, -2.30). `tol` is the requested relative
    error of the figures (default 1e-6). Each point is written to the file `out` as it is computed; `resume` goes on from such a
    file. The branch ends at the first special point of the kind `stop_at` (HB, LP, PD, NS), at `longest_period` (transits), or
    after `most_points` (default 2000). With `switch` = "PD" it is that of the orbits of twice the period. If `source` is a
    netCDF file of a branch, it is computed again: its model, range and options hold where none are given.

    Raises SceneError for wrong input; NumericsError where the branch cannot be followed, with the part before as its `result`.
    """
    out, resume = as_path(out), as_path(resume)
    if out is not None or resume is not None:
        require("files", "the file of a branch")
    given = {"over": range_text(over), "tol": tol, "cells": cells, "stop_at": stop_at, "switch": switch}
    model, options = recall(source, "branch", model, given | {"longest_period": longest_period, "most_points": most_points})
    options |= {name: value for name, value in _DEFAULTS.items() if options[name] is None}
    limits = _limits(options)
    if options["over"] is None:
        raise SceneError("--over: missing; must be KEY=FROM:TO, as in log10_r=-2.72:-2.60")
    parameter = over_range(options["over"], scene_of(source, settings, changes))
    name = announced(*flowing(model, parameter.base))
    found = Branch(parameter, name, options["tol"], options["cells"], options["switch"] == "PD")
    outcome = pursue(found, limits, out or resume, resume, facts_of_file(found, options))
    return deliver(BranchResult(found, outcome, options), outcome.failed, outcome.stopped)


def _limits(options: Mapping[str, Any]) -> Limits:
    """Where the branch ends. Raises SceneError naming an option that makes no sense."""
    kind, period, points, switch = (options[name] for name in ("stop_at", "longest_period", "most_points", "switch"))
    require_tolerance(options["tol"])
    if kind is not None and kind not in KINDS:
        raise SceneError(f"--stop-at {shorten(kind)}: must be one of {', '.join(KINDS)}")
    if period is not None and not period > 0.0:
        raise SceneError(f"--longest-period = {period:g}: must be above 0")
    if points < 1:
        raise SceneError(f"--most-points = {points}: must be at least 1")
    if switch not in (None, "HB", "PD"):
        raise SceneError(f"--switch {shorten(switch)}: must be HB or PD")
    return Limits(period or Limits().period, points, kind or "")


def facts_of_file(found: Followed, options: Mapping[str, Any]) -> dict[str, Any]:
    """The attributes of its file."""
    return provenance(found.what, found.over.base, found.model, options) | {"parameter": found.over.name}


def _table(kind: str, names: tuple[str, ...], rows: Sequence[tuple[Any, ...]], scene: Scene) -> dict[str, Any]:
    """Columns of points as variables; `stable` is -1 where it is not decided."""
    found: dict[str, Any] = {}
    for name, column in zip(names, zip(*rows, strict=True) if rows else [()] * len(names), strict=True):
        if name in EVENTS:
            twins = variables(kind, {name: list(column)}, EVENTS, scene)
            found |= {f"{kind}_{label}": variable for label, variable in twins.items()}
        else:
            values = [-1 if value is None else value for value in column]
            found[f"{kind}_{name}"] = (kind, values, {"long_name": name.replace("_", " ")})
    return found


def _at(found: Branch, row: BranchPoint | SpecialPoint) -> dict[str, Any]:
    """A point with the value of the parameter under its own name."""
    name, facts = found.over.name, row._asdict()
    kind = {"type": facts.pop("kind")} if "kind" in facts else {}
    facts.pop("place", None)
    value = facts.pop("value")
    named = {name: value} if name == "log10_r" else {name: value, "parameter": name, "value": value}
    return kind | named | facts
