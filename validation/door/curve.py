"""`slipwave.curve`: a special point of branches of orbits followed in two parameters."""

import time
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from reduced.continuation.curve import Reached
from slipwave.errors import NumericsError, SceneError
from slipwave.input import SceneSource
from slipwave.input.stored import recall
from slipwave.scene.doubts import doubts
from validation.branches.curve import Curve, CurvePoint, begin_curve, require_curve, trace, trace_onsets
from validation.branches.curve_drawing import figure_of
from validation.branches.parameter import Values, over_range, range_text
from validation.branches.stored_curve import read, write
from validation.door.checked import checked
from validation.door.result import Dataset, Result, announced, as_path, deliver, finite, parameter_column, scene_of, table_of
from validation.door.result import along as in_order
from validation.registry.orbits import flowing, require_tolerance
from validation.results.provenance import SCHEMA, provenance
from validation.run.progress import progress
from validation.study.drawing import Drawing, styled

_DEFAULTS = {"tol": 1e-6, "most_points": 100}
_EXAMPLES = {"of": "LP", "over": "log10_r=-2.72:-2.68", "and": "V=100:120"}


@dataclass(frozen=True, repr=False, eq=False)
class CurveResult(Result):
    """The curve that was `found`, where it can go on (`reached`), the options of the call, and run time in seconds; `failed` says
    why it ended early, or is empty."""

    found: Curve
    reached: Reached | None
    options: Mapping[str, Any]
    wall_s: float
    failed: str = ""

    @property
    def summary(self) -> dict[str, Any]:
        """The JSON of `slipwave curve`; `failed` is there only if the numerics failed or the user stopped it."""
        found = self.found
        result = {
            "schema": SCHEMA,
            "scene": found.over.base.name,
            "model": found.model,
            "clock": "transit",
            "type": found.kind,
            "parameters": [found.over.name, found.second.name],
            "points": [_at(found, point) for point in found.points],
            "wall_s": self.wall_s,
            "notes": [*doubts(found.over.base), *found.notes],
        }
        return dict(finite(result | ({"failed": self.failed} if self.failed else {})))

    @cached_property
    def dataset(self) -> Dataset:
        """The points by `point`."""
        rows = [_at(self.found, point) for point in self.found.points]
        rows = [row | dict(zip(("multiplier_re", "multiplier_im"), row.pop("multiplier"), strict=True)) for row in rows]
        data = table_of(rows, "point", self.found.over.base).assign_attrs(_facts(self.found, self.options))
        return in_order(data.set_coords(parameter_column(self.found.second.name)), self.found.over.name)

    def plot(self) -> Drawing:
        """The plane of both parameters, and the period."""
        with styled():
            return figure_of(self.found)

    def to_netcdf(self, path: str | Path) -> None:
        """Write the curve and, where there is one, the point from which it can go on. Raises SceneError if the file cannot be
        written."""
        if self.reached is None:
            super().to_netcdf(path)
        else:
            write(Path(path), self.found, self.reached, not self.failed, _facts(self.found, self.options))


@checked
def curve(
    source: SceneSource,
    of: str | None = None,
    over: Values | None = None,
    along: Values | None = None,
    model: str = "auto",
    *,
    tol: float | None = None,
    out: str | Path | None = None,
    resume: str | Path | None = None,
    most_points: int | None = None,
    settings: Iterable[str] = (),
    **changes: Any,
) -> CurveResult:
    """Follow the first special point of the kind `of` (HB, LP, PD, NS) on the branch of orbits in two parameters; `changes` are
    those of `slipwave.read_scene`.

    `over` is the branch's parameter with its range, as "log10_r=-2.72:-2.30" or ("log10_r", -2.72, -2.30); `along` the second
    one, as "V=100:200": the curve begins on the branch at its first value and is followed in this direction until it leaves one
    of the ranges, or for `most_points` (default 100). It may turn back in both parameters. `tol` is the requested relative error
    of the figures (default 1e-6). Each point is written to the file `out` as it is computed; `resume` goes on from such a file
    in the same ranges. If `source` is a netCDF file of a curve, it is computed again: what it holds is taken where nothing is
    given.

    Raises SceneError for wrong input; NumericsError where there is no such point or the curve cannot be followed, with the part
    before as its `result`.
    """
    out, resume = as_path(out), as_path(resume)
    given = {"of": of, "over": range_text(over), "and": range_text(along), "tol": tol, "most_points": most_points}
    model, options = recall(source, "curve", model, given)
    options = _complete(options)
    require_tolerance(options["tol"])
    if resume is not None and options["of"] == "HB":
        raise SceneError("--resume: a curve of Hopf points is computed at once; leave it out")
    scene = scene_of(source, settings, changes)
    parameters = over_range(options["over"], scene), over_range(options["and"], scene, "--and")
    require_curve(options["of"], *parameters)
    name = announced(*flowing(model, scene))
    found, failed, stopped, began = Curve(options["of"], *parameters, name, options["tol"]), "", False, time.perf_counter()
    reached: Reached | None = None
    try:
        for step in _steps(found, options["most_points"], out or resume, resume, _facts(found, options)):
            reached = step
    except NumericsError as error:
        failed = str(error)
    except KeyboardInterrupt:
        failed, stopped = f"interrupted after {len(found.points)} points", True
    result = CurveResult(found, reached, options, time.perf_counter() - began, failed)
    if out is not None and reached is None and found.points:
        result.to_netcdf(out)
    return deliver(result, failed, stopped)


def _complete(options: Mapping[str, Any]) -> dict[str, Any]:
    """`options` with the defaults in place of None. Raises SceneError for one that is missing or out of range."""
    missing = next((name for name in _EXAMPLES if options[name] is None), None)
    if missing:
        raise SceneError(f"--{missing}: missing; must be given, as in --{missing} {_EXAMPLES[missing]}")
    known = {**options, **{name: value for name, value in _DEFAULTS.items() if options[name] is None}}
    if known["most_points"] < 1:
        raise SceneError(f"--most-points = {known['most_points']}: must be at least 1")
    return known


def _facts(found: Curve, options: Mapping[str, Any]) -> dict[str, Any]:
    """The attributes of a curve's file."""
    return provenance("curve", found.over.base, found.model, options)


def _steps(found: Curve, most: int, path: Path | None, resume: Path | None, facts: Mapping[str, Any]) -> Iterator[Reached]:
    """Fill the curve and, after each point, its file; yields where the curve can go on. Hopf points are recorded at once."""
    if found.kind == "HB":
        trace_onsets(found)
        return

    def keep(reached: Reached, complete: bool) -> Reached:
        """Write the file, if one is wanted."""
        if path is not None:
            write(path, found, reached, complete, facts)
        return reached

    with progress(f"{found.over.base.name}, {found.model}, points of the curve", most) as report:
        reached = last = keep(read(resume, found) if resume is not None else begin_curve(found), False)
        yield last
        for last in trace(found, reached, most):
            yield keep(last, False)
            report(len(found.points))
    keep(last, True)


def _at(found: Curve, point: CurvePoint) -> dict[str, Any]:
    """A point with the values of both parameters under their own names."""
    facts = point._asdict()
    return {found.over.name: facts.pop("first"), found.second.name: facts.pop("second")} | facts
