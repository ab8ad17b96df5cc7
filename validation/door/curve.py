"""`slipwave.curve`: a special point of branches of orbits followed in two parameters."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from slipwave.errors import SceneError
from slipwave.input import SceneSource
from slipwave.input.stored import recall
from validation.branches.curve import Curve, require_curve
from validation.branches.drawing import figure_of_curve
from validation.branches.followed import Limits, pursue
from validation.branches.parameter import Values, over_range, range_text
from validation.branches.points import CurvePoint
from validation.door.branch import FollowedResult, facts_of_file
from validation.door.checked import checked
from validation.door.result import Dataset, announced, as_path, deliver, scene_of
from validation.registry.orbits import flowing, require_tolerance
from validation.results.tables import along as in_order
from validation.results.tables import parameter_column, table_of
from validation.study.drawing import Drawing, styled

_DEFAULTS = {"tol": 1e-6, "most_points": 100}
_EXAMPLES = {"of": "LP", "over": "log10_r=-2.72:-2.68", "and": "V=100:120"}


@dataclass(frozen=True, repr=False, eq=False)
class CurveResult(FollowedResult):
    """A curve of special points."""

    found: Curve

    def _rows(self) -> dict[str, Any]:
        found = self.found
        points = [self._at(point) | {"multiplier": point.multiplier} for point in found.points]
        return {"type": found.kind, "parameters": [found.over.name, found.second.name], "points": points}

    def _at(self, point: CurvePoint) -> dict[str, Any]:
        """A point with the values of both parameters under their own names."""
        facts = {name: value for name, value in point._asdict().items() if not name.startswith("multiplier")}
        return {self.found.over.name: facts.pop("first"), self.found.second.name: facts.pop("second")} | facts

    @cached_property
    def dataset(self) -> Dataset:
        """The points by `point`."""
        found = self.found
        rows = [self._at(one) | {"multiplier_re": one.multiplier_re, "multiplier_im": one.multiplier_im} for one in found.points]
        data = table_of(rows, "point", found.over.base).assign_attrs(facts_of_file(found, self.options))
        return in_order(data.set_coords(parameter_column(found.second.name)), found.over.name)

    def plot(self) -> Drawing:
        """The plane of both parameters, and the period."""
        with styled():
            return figure_of_curve(self.found)


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
    found = Curve(options["of"], *parameters, announced(*flowing(model, scene)), options["tol"])
    outcome = pursue(found, Limits(points=options["most_points"]), out or resume, resume, facts_of_file(found, options))
    result = CurveResult(found, outcome, options)
    if out is not None and outcome.head is None and found.points:
        result.to_netcdf(out)
    return deliver(result, outcome.failed, outcome.stopped)


def _complete(options: Mapping[str, Any]) -> dict[str, Any]:
    """`options` with the defaults in place of None. Raises SceneError for one that is missing or out of range."""
    missing = next((name for name in _EXAMPLES if options[name] is None), None)
    if missing:
        raise SceneError(f"--{missing}: missing; must be given, as in --{missing} {_EXAMPLES[missing]}")
    known = {**options, **{name: value for name, value in _DEFAULTS.items() if options[name] is None}}
    if known["most_points"] < 1:
        raise SceneError(f"--most-points = {known['most_points']}: must be at least 1")
    return known
