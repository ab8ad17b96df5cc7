"""`slipwave branch`: periodic orbits followed in a parameter, through folds, with the points where their stability changes."""

from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import slipwave
from validation.branches import KINDS
from validation.commands.options import Cells, Json, Law, Model, SceneName, Settings
from validation.output import FIGURES, conclude, deliver, figures, print_json, print_table, require_writable, thinned

if TYPE_CHECKING:
    from validation.branches.branch import Branch

_LISTED = 12  # points in the table

OverText = Annotated[
    str | None,
    typer.Option(
        "--over",
        metavar="KEY=FROM:TO",
        help="the parameter: log10_r, epsilon, V, a, b, or any key of the scene, as upper.epsilon",
    ),
]
BranchTolerance = Annotated[
    float | None, typer.Option("--tol", help="requested relative error of period, drops and slip rates (default 1e-6)")
]
OutFile = Annotated[Path | None, typer.Option(metavar="FILE.nc", help="write each point here as it is computed")]
ResumeFile = Annotated[
    Path | None, typer.Option(metavar="FILE.nc", help="go on from the last point in this file, and write the further ones to it")
]
StopAt = Annotated[str | None, typer.Option(metavar="|".join(KINDS), help="stop at the first special point of this kind")]
Longest = Annotated[float | None, typer.Option("--longest-period", metavar="TRANSITS", help="stop at this period")]
Most = Annotated[int | None, typer.Option("--most-points", help="stop after so many points (default 2000)")]
Switch = Annotated[
    str | None,
    typer.Option(
        metavar="HB|PD",
        help="PD: follow the orbits of twice the period from the first period doubling on",
    ),
]
Plot = Annotated[Path | None, typer.Option(metavar="FILE", help="draw the branch: .png, .pdf or .svg")]

EXAMPLES = (
    "slipwave branch paper --model kelvin-voigt --over log10_r=-2.72:-2.60 --plot branch.png",
    "slipwave branch branch.nc",
)


def branch(
    source: SceneName,
    over: OverText = None,
    model: Model = "auto",
    tol: BranchTolerance = None,
    settings: Settings = None,
    law: Law = None,
    cells: Cells = None,
    out: OutFile = None,
    resume: ResumeFile = None,
    stop_at: StopAt = None,
    switch: Switch = None,
    longest_period: Longest = None,
    most_points: Most = None,
    plot: Plot = None,
    json: Json = False,
) -> None:
    """Follow periodic orbits from where steady sliding loses stability, stable or not, through folds.

    Special points: HB Hopf, LP fold, PD period doubling, NS torus. Where the range holds no Hopf point, the branch begins with
    the orbit that a run at an unstable end leads to. A file of an earlier branch as SCENE is computed again.
    """
    from validation.door.result import delivered

    require_writable(out, (".nc",))
    require_writable(resume, (".nc",), "--resume")
    require_writable(plot, FIGURES, "--plot")
    result, failed, stopped = delivered(
        lambda: slipwave.branch(
            source,
            over,
            model,
            settings=settings or (),
            tol=tol,
            cells=cells,
            out=out,
            resume=resume,
            stop_at=stop_at,
            switch=switch,
            longest_period=longest_period,
            most_points=most_points,
        )
    )
    problems = []
    if result.found.points or result.found.special:
        problems = deliver(
            lambda: print_json(result.summary) if json else _print(result.found, result.outcome.wall_s), (result.save_plot, plot)
        )
    conclude("; ".join([failed, *([way_on(out or resume)] if stopped else [])]), problems, stopped)


def way_on(path: Path | None) -> str:
    """How to go on after an interruption."""
    return f"--resume {path} goes on from there" if path else "no file was kept: --out FILE.nc keeps one to go on from"


def _print(found: "Branch", wall_s: float) -> None:
    from validation.results.header import header

    print("\n".join(header(found.over.base, found.notes)))
    points = found.shown
    low, high = found.over.ends
    print(f"model {found.model}: {len(points)} orbits over {found.over.name} from {low:g} to {high:g}")
    print()
    if found.shown_special:
        print_table(*_special_rows(found))
        print()
    scene, listed = found.over.base, thinned(points, _LISTED)
    seconds = scene.units.time if scene.units else 0.0
    heading = [found.over.name, "period", *(["period [s]"] if seconds else []), "stress drop", "elastic stress drop"]
    digits = _telling([point.value for point in listed])
    table = [
        [
            figures(point.value, digits),
            figures(point.period, 7),
            *([figures(point.period * found.over.scene_at(point.value).transit * seconds, 7)] if seconds else []),
            *(figures(getattr(point, name), 7) for name in ("stress_drop", "elastic_stress_drop", "v_max", "v_min")),
            {True: "yes", False: f"no ({point.unstable})", None: "not decided"}[point.stable],
        ]
        for point in listed
    ]
    print_table([*heading, "v_max", "v_min", "stable"], table)
    print(f"\nperiods in transits; wall time {wall_s:.3g} s")


def _telling(values: list[float]) -> int:
    """Digits with which neighbours that differ are printed differently."""
    pairs = [pair for pair in pairwise(values) if pair[0] != pair[1]]
    enough = (n for n in range(8, 17) if all(figures(one, n) != figures(other, n) for one, other in pairs))
    return next(enough, 17)


def _special_rows(found: "Branch") -> tuple[list[str], list[list[str]]]:
    rows = [
        [
            f"{special.kind} {KINDS[special.kind]}",
            figures(special.value, 11),
            figures(special.bracket, 2),
            figures(special.period),
            figures(special.stress_drop, 7),
            "not counted" if special.unstable_before is None else f"{special.unstable_before} -> {special.unstable_after}",
        ]
        for special in found.shown_special
    ]
    return ["special points", found.over.name, "bracket", "period", "stress drop", "unstable multipliers"], rows
