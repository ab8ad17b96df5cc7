"""`slipwave curve`: Follow a special point of the branch of orbits in two parameters, also where its curve turns back."""

import time
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

from slipwave.errors import SceneError
from slipwave.input.assemble import SceneSource
from slipwave.input.wording import shorten
from validation.chart import INK, Chart, Look, Panel, Scale, Trace
from validation.commands.branch import (
    BRANCH_TOLERANCE,
    QUANTITIES,
    BranchResult,
    FollowedOptions,
    FollowedResult,
    points_option,
)
from validation.commands.options import announced, command, option
from validation.commands.result import thinned
from validation.data.datasets import Dataset
from validation.data.variables import EVENTS, figures_at, table_of
from validation.models.branch import FollowedBranch
from validation.models.curve import Curve
from validation.models.followed import pursue, read_branch
from validation.models.orbits import flowing
from validation.models.parameter import Values, names_of, over_ranges, range_text
from validation.models.points import SPECIAL_KINDS, CurvePoint, StopAt

CURVE_POINTS = 100
"""Default of `most_points`."""

_CUSP = Look(INK, "", "v", size=5.0)
_LISTED = 24  # points in the table
_NEEDED = {"of": ("--of", "LP"), "over": ("--over", "log10_r=-2.72:-2.68"), "along": ("--and", "V=100:120")}


class CurveOptions(FollowedOptions):
    """Options of `slipwave.curve`."""

    EXAMPLES: ClassVar = (
        "slipwave curve paper --of LP --over log10_r=-2.72:-2.68 --and V=100:120 --plot fold.png",
        "slipwave curve --from branch.nc --point NS2 --and face.coefficient=1:0.99",
        "slipwave curve curve.nc",
    )
    DETAILS: ClassVar = (
        "The curve begins with the first point of its kind on the branch at the second parameter's first value, or with a "
        "--point of the branch in a file. A netCDF file of a curve is computed again, with what it holds where nothing is given."
    )

    of: str | None = option("the kind of special point", metavar="|".join(SPECIAL_KINDS), positional=True, stored=True)
    over: Values | None = option(
        "the branch's parameter: log10_r, epsilon, V, a, b ...", metavar="KEY=FROM:TO", positional=True, stored=True
    )
    along: Values | None = option(
        "the second parameter; the curve begins at FROM and leads towards TO",
        flag="--and",
        metavar="KEY=FROM:TO",
        positional=True,
        stored=True,
    )
    start: Path | BranchResult | None = option(
        "begin on this branch, whose scene, model and range are taken: a file of `slipwave branch`, in Python also its result",
        flag="--from",
        metavar="FILE.nc",
    )
    point: str | None = option(
        "with --from, the special point at which to begin: NS2 for the second torus point", metavar="HB1|LP1|...", stored=True
    )
    most_points: int | None = points_option(CURVE_POINTS)

    @property
    def varied(self) -> tuple[str, ...]:
        """The names of both parameters."""
        return names_of(self.over, self.along)


class CurveResult(FollowedResult):
    """A curve of special points."""

    followed: Curve

    @property
    def _rows(self) -> dict[str, Any]:
        followed = self.followed
        points = [self._at(point) | {"multiplier": point.multiplier} for point in followed.points]
        return {"type": followed.kind, "parameters": [followed.over.name, followed.second.name], "points": points}

    def _at(self, point: CurvePoint) -> dict[str, Any]:
        """A point as a dictionary; the values of both parameters have their names."""
        facts = {name: value for name, value in point._asdict().items() if not name.startswith("multiplier")}
        facts["type"] = facts.pop("kind")
        return {self.followed.over.name: facts.pop("first"), self.followed.second.name: facts.pop("second")} | facts

    @cached_property
    def dataset(self) -> Dataset:
        """The points by `point`."""
        followed = self.followed
        rows = [
            self._at(point) | {"multiplier_re": point.multiplier_re, "multiplier_im": point.multiplier_im}
            for point in followed.points
        ]
        data = table_of(rows, "point", followed.over.base).assign_attrs(self.options.origin(followed))
        figures = {name: data[name].values.tolist() for name in EVENTS if name in data}
        data = data.assign(figures_at("point", figures, followed.over.base, lambda: [*map(followed.scene_of, followed.points)]))
        for over in (followed.over, followed.second):
            data[over.column].attrs["units"] = over.si_unit or "1"
        data["bracket"].attrs["units"] = data[followed.over.column].attrs["units"]
        from validation.models.along import along

        return along(data.set_coords(followed.second.column), followed.over.column)

    def chart(self) -> Chart:
        """Left: the second parameter over the first. Right: the second over the period. A cusp at the end is marked."""
        followed = self.followed
        cusp = [point for point in followed.points if point.kind == "CP"]

        def along(name: str, points: list[CurvePoint], look: Look, label: str = "") -> Trace:
            return Trace(label, [getattr(point, name) for point in points], [point.second for point in points], look)

        panels = []
        for name, label in (("first", followed.over.label), ("period", QUANTITIES["period"])):
            traces = [along(name, followed.points, Look(marker=".")), *([along(name, cusp, _CUSP, "cusp")] if cusp else [])]
            panels.append(Panel("", Scale(label), Scale(followed.second.label), traces, grid=True))
        return Chart(panels, 4.0, 2, title=f"{followed.over.base.name}, {followed.model}: {SPECIAL_KINDS[followed.kind]}")

    def lines(self, summary: Mapping[str, Any]) -> Iterator[str]:
        """Some of the points."""
        followed, listed = self.followed, thinned(self.followed.points, _LISTED)
        columns = {
            followed.over.name: self._column(listed, "first", 11),
            followed.second.name: self._column(listed, "second", 8),
            "period": self._column(listed, "period", 9),
            "stress drop": self._column(listed, "stress_drop"),
            "bracket": self._column(listed, "bracket", 2),
            "kind": [point.kind for point in listed],
            "multiplier": [
                f"{re:.6f}" + (f" +- {abs(im):.6f} i" if im else "") for re, im in (point.multiplier for point in listed)
            ],
        }
        return self._table(f"{followed.kind} {SPECIAL_KINDS[followed.kind]}, {len(followed.points)} points", columns)


_UNCHANGED = CurveOptions()


@command
def curve(source: "SceneSource | None" = None, options: CurveOptions = _UNCHANGED) -> CurveResult:
    """Follow the first special point of the kind `of` (HB, LP, PD, NS) on the branch of orbits in two parameters, or a `point` of
    the branch `start`.

    The curve begins on the branch over `over` at the first value of `along` and is followed in this direction until it leaves one
    of the ranges or ends at a cusp; it may turn back in both parameters. If `source` is a netCDF file of a curve, it is computed
    again: what it holds is taken where nothing is given.

    Raises SceneError for wrong input; NumericsError where there is no such point or the curve cannot be followed, with the part
    before as its `result`.
    """
    options = replace(options, over=range_text(options.over), along=range_text(options.along))
    begun = _begun(source, options)
    if begun is not None:
        branch, kind = begun[0], begun[0].special[begun[1]].kind
        kept = {key: text for key, text in branch.over.scenes.sets.items() if key not in options.varied}
        source = branch.over.base
        options = replace(options, model=branch.model, of=kind, over=options.over or branch.over.text, set=kept)
    elif source is None:
        raise SceneError("SCENE: missing; must be given, or --from FILE.nc with a --point")
    options = options.completed(source, "curve", tol=BRANCH_TOLERANCE, most_points=CURVE_POINTS)
    if begun is None and options.point is not None and options.resume is None:
        raise SceneError(f"--point {shorten(options.point)}: needs --from FILE.nc, a file of the branch on which it lies")
    for name, (flag, example) in _NEEDED.items():
        if getattr(options, name) is None and (begun is None or name != "over"):
            raise SceneError(f"{flag}: missing; must be given, as in {flag} {example}")
    kind, scenes = str(options.of), options.scenes_of(source)
    if options.resume is not None and kind == "HB":
        raise SceneError("--resume: a curve of Hopf points is computed at once; leave it out")
    over, second = over_ranges({"--over": str(options.over), "--and": str(options.along)}, scenes)
    if kind not in SPECIAL_KINDS:
        raise SceneError(f"--of {shorten(kind)}: must be one of {', '.join(SPECIAL_KINDS)}")
    if over.quantity == second.quantity:
        raise SceneError(f"--and {shorten(second.name)}: must be another parameter than --over {shorten(over.name)}")
    model = announced(*flowing(options.model, scenes.base))
    followed = Curve(kind, over, second, model, options.tol or BRANCH_TOLERANCE, begun)
    followed.require_start()
    limits = StopAt(points=options.most_points or CURVE_POINTS)
    began = time.perf_counter()
    end, failed, stopped = pursue(followed, limits, options.file, options.resume, options.origin(followed))
    result = CurveResult(followed, options, time.perf_counter() - began, end, failed=failed, stopped=stopped)
    if options.out is not None and result.end is None and followed.points:
        result.to_netcdf(options.out)
    return result


def _begun(source: "SceneSource | None", options: CurveOptions) -> tuple[FollowedBranch, int] | None:
    """The branch of --from, and the index of --point on it. Raises SceneError for a point that it does not have, and for options
    that the branch gives."""
    start = options.start
    if start is None:
        return None
    changes = options.settings or options.set or options.changes
    given = {"SCENE": source is not None, "--set": changes, "--model": options.model != "auto"}
    for name in (name for name, is_given in given.items() if is_given):
        raise SceneError(f"{name}: leave it out; --from gives the scene and the model")
    branch = start.followed if isinstance(start, BranchResult) else read_branch(start, "--from")
    known = branch.named()
    if options.point not in known:
        wrong = "missing" if options.point is None else shorten(options.point)
        raise SceneError(f"--point {wrong}: must be one of the branch's special points: {', '.join(known) or 'it has none'}")
    index = known[options.point]
    if options.of not in (None, branch.special[index].kind):
        raise SceneError(f"--of {shorten(options.of)}: leave it out; {options.point} has its own kind")
    return branch, index
