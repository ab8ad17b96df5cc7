"""`slipwave branch`: Follow periodic orbits from where steady sliding loses stability, stable or not, through folds."""

import math
import time
from abc import abstractmethod
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import groupby, pairwise
from pathlib import Path
from typing import Any, ClassVar, Self

from reduced.orbit.closing import Closed
from slipwave.errors import SceneError
from slipwave.extras import require
from slipwave.files import FIGURES
from slipwave.input.assemble import SceneSource
from slipwave.input.wording import shorten
from slipwave.scene.scene import doubts
from validation.chart import BLUE, GREY, INK, ORANGE, Chart, Look, Panel, Scale, Trace, with_gaps
from validation.chart.looks import NAMES
from validation.commands.options import ModelOptions, announced, command, option
from validation.commands.result import Output, PointOfBranch, Result, aligned, finite, rounded, thinned
from validation.commands.wording import header
from validation.data.datasets import Dataset, new_dataset
from validation.data.variables import EVENTS, figures_at
from validation.models.branch import FollowedBranch
from validation.models.ends import CurveEnd, SpecialEnds
from validation.models.followed import End, Followed, pursue, write_followed
from validation.models.orbits import LARGEST_TOLERANCE, LEAST_TOLERANCE, flowing
from validation.models.parameter import ParameterRange, Values, names_of, over_range, range_text
from validation.models.points import SPECIAL_KINDS, BranchPoint, SpecialPoint, StopAt
from validation.models.provenance import provenance

BRANCH_TOLERANCE, BRANCH_POINTS = 1e-6, 2000
"""Defaults of the options."""

_LISTED = 12  # points in the table

QUANTITIES = {"period": "period $T$ / transits", "stress_drop": "stress drop", "elastic_stress_drop": "elastic stress drop"}
_MARKS = {"HB": (INK, "o"), "LP": (BLUE, "s"), "PD": (ORANGE, "^"), "NS": ("#009e73", "D")}
_LOOKS = {
    True: ("stable", Look(width=1.9)),
    False: ("unstable", Look(GREY, (0, (4, 1.5)), width=0.8)),
    None: ("stability not decided", Look(GREY, width=0.9)),
}


def tolerance_option(default: float, beside: str = "") -> Any:
    """The option `tol` of orbits; `beside`: what it leaves out."""
    return option(
        f"requested relative error of period, drops and slip rates{beside} (default 1e{math.log10(default):.0f})",
        stored=True,
        least=LEAST_TOLERANCE,
        most=LARGEST_TOLERANCE,
        must=f"lie in [{LEAST_TOLERANCE:g}, {LARGEST_TOLERANCE:g}] for an orbit",
    )


def points_option(default: int) -> Any:
    """The option `most_points` of what is followed."""
    return option(f"stop after so many points (default {default})", stored=True, least=1, must="be at least 1")


class FollowedOptions(ModelOptions):
    """Options of `slipwave.branch` and `slipwave.curve`."""

    tol: float | None = tolerance_option(
        BRANCH_TOLERANCE, "; of a full wave without the error of its grid, which --cells decides"
    )
    out: Path | None = option("write each point here as it is computed", metavar="FILE.nc", suffixes=(".nc",))
    resume: Path | None = option(
        "go on from the last point in this file, and write the further ones to it", metavar="FILE.nc", suffixes=(".nc",)
    )

    @property
    def file(self) -> Path | None:
        """Path of the output file; that of `resume` by default."""
        return self.out or self.resume

    def completed(self, source: SceneSource, what: str, **defaults: Any) -> Self:
        """The options completed by those of a file of results, and by the `defaults`."""
        if self.file is not None:
            require("files", f"the file of a {what}")
        known = self.recalled(source, what)
        return replace(known, **{name: value for name, value in defaults.items() if getattr(known, name) is None})

    def origin(self, followed: Followed) -> dict[str, Any]:
        """The attributes of the file of a branch or a curve."""
        return provenance(followed.what, followed.over.base, followed.model, self.stored) | {"parameter": followed.over.name}


class BranchOptions(FollowedOptions):
    """Options of `slipwave.branch`."""

    EXAMPLES: ClassVar = (
        "slipwave branch paper --model kelvin-voigt --over log10_r=-2.72:-2.60 --plot branch.png",
        "slipwave branch paper --set face.kind=reflection --set face.coefficient=1 --over log10_r=-2.72:-2.65 "
        "--ends face.coefficient=1,0.999,0.99",
        "slipwave branch branch.nc",
    )
    DETAILS: ClassVar = (
        "Special points: HB Hopf, LP fold, PD period doubling, NS torus. Where the range holds no Hopf point, the branch begins "
        "with the orbit that a run at an unstable end leads to. A file of an earlier branch as SCENE is computed again."
    )

    over: Values | None = option(
        "the parameter: log10_r, epsilon, V, a, b, any key of the scene, as upper.epsilon, or a variable that a --set names; in "
        'Python also ("log10_r", -2.72, -2.30)',
        metavar="KEY=FROM:TO",
        positional=True,
        stored=True,
    )
    cells: int | None = option("full wave: cells per slab", stored=True)
    stop_at: str | None = option("stop at the first special point of this kind", metavar="|".join(SPECIAL_KINDS), stored=True)
    switch: str | None = option(
        "PD: follow the orbits of twice the period from the first period doubling on", metavar="HB|PD", stored=True
    )
    longest_period: float | None = option("stop at this period", metavar="TRANSITS", stored=True)
    most_points: int | None = points_option(BRANCH_POINTS)
    ends: str | None = option(
        "the special points left at each value of a second parameter, and its extreme on the curves through those at the first",
        metavar="KEY=VALUE,VALUE,...",
        stored=True,
    )

    @property
    def varied(self) -> tuple[str, ...]:
        """The name of the parameter, and of that of `ends`."""
        return names_of(self.over, self.ends)

    @property
    def limits(self) -> StopAt:
        """Where the branch ends. Raises SceneError naming an option that makes no sense."""
        if self.stop_at is not None and self.stop_at not in SPECIAL_KINDS:
            raise SceneError(f"--stop-at {shorten(self.stop_at)}: must be one of {', '.join(SPECIAL_KINDS)}")
        if self.longest_period is not None and not self.longest_period > 0.0:
            raise SceneError(f"--longest-period = {self.longest_period:g}: must be above 0")
        if self.switch not in (None, "HB", "PD"):
            raise SceneError(f"--switch {shorten(self.switch)}: must be HB or PD")
        return StopAt(self.longest_period or StopAt().period, self.most_points or BRANCH_POINTS, self.stop_at or "")


class FollowedResult(Result):
    """The branch or curve `followed`, the options of the call, run time (s), and the `end` from which it can be continued, if
    any."""

    followed: Followed
    options: FollowedOptions
    wall_s: float
    end: End | None = None

    OUTPUTS: ClassVar = (Output("--plot", FIGURES, "save_plot", "draw it: .png, .pdf or .svg"),)

    @property
    def facts(self) -> dict[str, Any]:
        """As `Result`."""
        followed = self.followed
        return {
            "scene": followed.over.base.name,
            "model": followed.model,
            "clock": "transit",
            **followed.over.scenes.facts,
            **self._rows,
            "wall_s": self.wall_s,
            "notes": [*doubts(followed.over.base), *followed.notes],
        }

    @property
    @abstractmethod
    def _rows(self) -> dict[str, Any]:
        """The entries that differ between branches and curves."""

    @property
    def is_empty(self) -> bool:
        """Whether it has no points."""
        return not any(rows for _, rows in self.followed.tables.values())

    def to_go_on(self, options: FollowedOptions) -> str:
        """How to continue from the file, for a message."""
        if options.file is None:
            return "no file was kept: --out FILE.nc keeps one to go on from"
        kept = options.resume if self.end is None else options.file  # which is written with the first point
        return f"--resume {kept} goes on from there" if kept else ""

    def to_netcdf(self, path: str | Path) -> None:
        """Write the points and, if any, the end from which they can be continued. Raises SceneError if the file cannot be
        written."""
        if self.end is None:
            super().to_netcdf(path)
        else:
            write_followed(Path(path), self.followed, self.end, not self.failed, self.options.origin(self.followed))

    def _table(self, first: str, columns: Mapping[str, Sequence[str]]) -> Iterator[str]:
        """Lines of the scene, the line `first`, the columns, and the run time."""
        yield from header(self.followed.over.base)
        yield from self.followed.over.scenes.lines
        yield from (f"note: {note}" for note in self.followed.notes)
        yield f"model {self.followed.model}: {first}"
        yield ""
        yield from self._special_lines()
        yield from aligned(list(columns), list(zip(*columns.values(), strict=True)))
        yield f"\nperiods in transits; wall time {self.wall_s:.3g} s"

    def _special_lines(self) -> Iterator[str]:
        yield from ()

    @staticmethod
    def _column(rows: Sequence[Any], name: str, digits: int = 7) -> list[str]:
        """A column of a printed table."""
        return [rounded(getattr(row, name), digits) for row in rows]


class BranchResult(FollowedResult):
    """A branch, and where its special points end as a second parameter changes, if asked."""

    followed: FollowedBranch
    ends: SpecialEnds | None = None

    @property
    def _rows(self) -> dict[str, Any]:
        followed = self.followed
        points, special = ([self._at(row) for row in rows] for rows in (followed.shown, followed.shown_special))
        ends = {} if self.ends is None else {"ends": self._ends(self.ends)}
        return {"parameter": followed.over.name, "points": points, "special": special} | ends

    def _ends(self, ends: SpecialEnds) -> dict[str, Any]:
        """The special points at each value of the second parameter, and its extremes, by kind."""
        second, first = ends.second.name, self.followed.over.name
        rows = [
            {second: value, "special": [self._at(row) for row in branch.shown_special], "notes": branch.notes}
            for value, branch in zip(ends.values, ends.branches, strict=True)
        ]

        def facts(end: CurveEnd) -> dict[str, Any]:
            others = {"period": end.period, "bracket": end.bracket, "reason": end.reason or None}
            return {second: end.extreme, first: end.first} | others

        extremes = {
            kind: facts(ends.extreme(kind)) | {"curves": [{"points": list(end.points)} | facts(end) for end in curves]}
            for kind, curves in ends.curves.items()
        }
        return {"parameter": second, "values": rows, "extremes": extremes}

    def _at(self, row: BranchPoint | SpecialPoint) -> dict[str, Any]:
        """A point as a dictionary; the parameter's value has the parameter's name."""
        name, facts = self.followed.over.name, row._asdict()
        kind = {"type": facts.pop("kind")} if "kind" in facts else {}
        facts.pop("place", None)
        value = facts.pop("value")
        named = {name: value} if name == "log10_r" else {name: value, "parameter": name, "value": value}
        return kind | named | facts

    @cached_property
    def dataset(self) -> Dataset:
        """The points by `point` and the special points by `special`, at their values of the parameter. The figures of points also
        have their plain names, indexed by the parameter: `.sel(log10_r=-2.6)` (`AlongBranch`)."""
        from validation.models.along import along

        followed = self.followed
        values = _columns("point", BranchPoint._fields, followed.shown, followed.over)
        plain = {name.removeprefix("point_"): value for name, value in values.items()}
        plain |= {followed.over.column: plain.pop("value")}
        values |= plain | _columns("special", SpecialPoint._fields, followed.shown_special, followed.over)
        data = new_dataset(values, attrs=self.options.origin(self.followed)).set_coords(["point_value", "special_value"])
        return along(data, followed.over.column)

    @property
    def points(self) -> list[PointOfBranch]:
        """The points of the JSON; each can be given to `slipwave.orbit` as a scene."""
        points = enumerate(self.followed.points)
        return [self._point_at(point, None, k) for k, point in points if self.followed.over.holds(point.value)]

    @property
    def special(self) -> list[PointOfBranch]:
        """The special points, likewise."""
        followed = self.followed
        return [
            self._point_at(point, followed.closed.get(k))
            for k, point in enumerate(followed.special)
            if followed.over.holds(point.value)
        ]

    def _point_at(self, point: BranchPoint | SpecialPoint, closed: Closed | None, place: int | None = None) -> PointOfBranch:
        facts, scene = finite(self._at(point)), self.followed.over.written_at(point.value)
        return PointOfBranch(facts, scene, self.followed, closed, place)

    def chart(self) -> Chart:
        """Period and stress drops against the parameter, one panel each."""
        followed = self.followed
        panels = [
            Panel("", Scale(followed.over.label), Scale(label), [*_pieces(followed, name), *_special(followed, name)])
            for name, label in QUANTITIES.items()
        ]
        title = f"{followed.over.base.name}, {followed.model}: periodic orbits"
        return Chart(panels, 8.5, legend="outside lower left", legend_columns=4, title=title)

    def lines(self, summary: Mapping[str, Any]) -> Iterator[str]:
        """The special points, and some of the others."""
        followed, scene, listed = self.followed, self.followed.over.base, thinned(self.followed.shown, _LISTED)
        (low, high), values = followed.over.ends, [point.value for point in listed]
        pairs = [pair for pair in pairwise(values) if pair[0] != pair[1]]  # of neighbours, which the digits distinguish
        digits = next((n for n in range(8, 17) if all(rounded(value, n) != rounded(other, n) for value, other in pairs)), 17)
        words = {True: "yes", None: "not decided"}
        columns = {
            followed.over.name: [rounded(value, digits) for value in values],
            "period": self._column(listed, "period"),
        }
        if scene.units:
            seconds = [point.period * followed.over.scene_at(point.value).transit * scene.units.time for point in listed]
            columns["period [s]"] = [rounded(period, 7) for period in seconds]
        rest = {"stress drop": "stress_drop", "elastic stress drop": "elastic_stress_drop", "v_max": "v_max", "v_min": "v_min"}
        columns |= {heading: self._column(listed, name) for heading, name in rest.items()}
        columns["stable"] = [words.get(point.stable, f"no ({point.unstable})") for point in listed]
        return self._table(f"{len(followed.shown)} orbits over {followed.over.name} from {low:g} to {high:g}", columns)

    def _special_lines(self) -> Iterator[str]:
        followed, special = self.followed, self.followed.shown_special
        columns = {
            "special points": [f"{point.kind} {SPECIAL_KINDS[point.kind]}" for point in special],
            followed.over.name: self._column(special, "value", 11),
            "bracket": self._column(special, "bracket", 2),
            "period": self._column(special, "period", 9),
            "stress drop": self._column(special, "stress_drop"),
            "unstable multipliers": [
                "not counted" if point.unstable_before is None else f"{point.unstable_before} -> {point.unstable_after}"
                for point in special
            ],
        }
        yield from [*aligned(list(columns), list(zip(*columns.values(), strict=True))), ""] if special else []
        yield from [] if self.ends is None else self._ends_lines(self.ends)

    def _ends_lines(self, ends: SpecialEnds) -> Iterator[str]:
        """How many special points of each kind are left at each value, and how far their curves lead."""
        name = ends.second.name
        counts = [Counter(special.kind for special in branch.shown_special) for branch in ends.branches]
        left = [
            [f"{value:g}", *(str(count[kind]) for kind in SPECIAL_KINDS)]
            for value, count in zip(ends.values, counts, strict=True)
        ]
        yield from aligned([name, *SPECIAL_KINDS], left)
        yield ""
        rows = []
        for kind in ends.curves:
            end = ends.extreme(kind)
            figures = ((end.extreme, 11), (end.bracket, 2), (end.first, 11), (end.period, 9))
            shown = ["none", "", "", ""] if end.extreme is None else [rounded(*figure) for figure in figures]
            rows.append([f"{kind} {SPECIAL_KINDS[kind]}", str(len(ends.curves[kind])), *shown, end.reason])
        heading = ["kind", "curves", f"extreme {name}", "bracket", self.followed.over.name, "period", ""]
        yield from aligned(heading, rows) if rows else []
        yield ""


def _columns(kind: str, names: tuple[str, ...], rows: Sequence[tuple[Any, ...]], over: ParameterRange) -> dict[str, Any]:
    """Columns of points as variables, in SI each by the units of its own scene, which the parameter may change; `stable` is -1
    where undecided."""
    columns = dict(zip(names, zip(*rows, strict=True) if rows else [()] * len(names), strict=True))
    figures = {name: list(values) for name, values in columns.items() if name in EVENTS}
    others = {
        name: (kind, [-1 if value is None else value for value in values], {"long_name": name.replace("_", " ")})
        for name, values in columns.items()
        if name not in EVENTS
    }
    for name in others.keys() & {"value", "bracket"}:
        others[name][2]["units"] = over.si_unit or "1"
    in_si = figures_at(kind, figures, over.base, lambda: [over.scene_at(value) for value in columns["value"]])
    return {f"{kind}_{name}": variable for name, variable in (others | in_si).items()}


@command
def branch(source: SceneSource, options: BranchOptions) -> BranchResult:
    """Follow periodic orbits from where steady sliding loses stability, stable or not, through folds.

    If `source` is a netCDF file of a branch, it is computed again: its model, range and options hold where none are given.
    Raises SceneError for wrong input; NumericsError where the branch cannot be followed, with the part before as its `result`.
    """
    options = replace(options, over=range_text(options.over))
    options = options.completed(source, "branch", tol=BRANCH_TOLERANCE, most_points=BRANCH_POINTS)
    limits = options.limits
    if options.over is None:
        raise SceneError("--over: missing; must be KEY=FROM:TO, as in log10_r=-2.72:-2.60")
    scenes, ends = options.scenes_of(source), None
    if options.ends is None:
        parameter = over_range(str(options.over), scenes)
    else:
        parameter, ends = SpecialEnds.read(options.ends, str(options.over), scenes)
    name = announced(*flowing(options.model, parameter.base))
    followed = FollowedBranch(parameter, name, options.tol or BRANCH_TOLERANCE, options.cells, options.switch == "PD")
    began = time.perf_counter()
    end, failed, stopped = pursue(followed, limits, options.file, options.resume, options.origin(followed))
    if ends is not None and not failed:
        try:
            ends.follow(followed, limits)
        except KeyboardInterrupt:
            failed, stopped = "interrupted in --ends", True
    wall_s = time.perf_counter() - began
    return BranchResult(followed, options, wall_s, end, None if failed else ends, failed=failed, stopped=stopped)


def _pieces(branch: FollowedBranch, name: str) -> Iterator[Trace]:
    """The branch in pieces of one stability within the range, which meet at the special points between them."""
    ends, holds = {special.place: special for special in branch.special}, branch.over.holds
    for stable, (label, look) in _LOOKS.items():
        pieces = []
        for (own, inside), group in groupby(enumerate(branch.points), lambda item: (item[1].stable, holds(item[1].value))):
            piece = list(group)
            first, last = ends.get(piece[0][0]), ends.get(piece[-1][0] + 1)
            run = [corner for corner in (first, *(point for _, point in piece), last) if corner and holds(corner.value)]
            if own is stable and inside:
                pieces.append(([point.value for point in run], [getattr(point, name) for point in run]))
        if pieces:
            yield Trace(label, *with_gaps(pieces), look)


def _special(branch: FollowedBranch, name: str) -> Iterator[Trace]:
    for kind, (color, marker) in _MARKS.items():
        of_kind = [special for special in branch.shown_special if special.kind == kind]
        if of_kind:
            positions = [special.value for special in of_kind], [getattr(special, name) for special in of_kind]
            yield Trace(NAMES[kind], *positions, Look(color, "", marker, size=4.0, hollow=kind == "HB"))
