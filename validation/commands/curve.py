"""`slipwave curve`: a special point of branches of orbits followed in two parameters."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import slipwave
from validation.branches import KINDS
from validation.commands.branch import OutFile, ResumeFile, way_on
from validation.commands.options import Json, Law, Model, SceneName, Settings
from validation.output import FIGURES, conclude, deliver, figures, print_json, print_table, require_writable, thinned

if TYPE_CHECKING:
    from validation.branches.curve import Curve

_LISTED = 24  # points in the table

Kind = Annotated[str | None, typer.Option("--of", metavar="|".join(KINDS), help="the kind of special point")]
OverText = Annotated[
    str | None, typer.Option("--over", metavar="KEY=FROM:TO", help="the branch's parameter: log10_r, epsilon, V, a, b ...")
]
AndText = Annotated[
    str | None,
    typer.Option("--and", metavar="KEY=FROM:TO", help="the second parameter; the curve begins at FROM and leads towards TO"),
]
CurveTolerance = Annotated[
    float | None, typer.Option("--tol", help="requested relative error of period, drops and slip rates (default 1e-6)")
]
Most = Annotated[int | None, typer.Option("--most-points", help="stop after so many points (default 100)")]
Plot = Annotated[Path | None, typer.Option(metavar="FILE", help="draw the curve: .png, .pdf or .svg")]

EXAMPLES = ("slipwave curve paper --of LP --over log10_r=-2.72:-2.68 --and V=100:120 --plot fold.png", "slipwave curve curve.nc")


def curve(
    source: SceneName,
    of: Kind = None,
    over: OverText = None,
    along: AndText = None,
    model: Model = "auto",
    tol: CurveTolerance = None,
    settings: Settings = None,
    law: Law = None,
    out: OutFile = None,
    resume: ResumeFile = None,
    most_points: Most = None,
    plot: Plot = None,
    json: Json = False,
) -> None:
    """Follow a special point of the branch of orbits in two parameters, also where its curve turns back.

    The curve begins with the first point of its kind on the branch at the second parameter's first value. A netCDF file of a
    curve is computed again, with what it holds where nothing is given.
    """
    from validation.door.result import delivered

    require_writable(out, (".nc",))
    require_writable(resume, (".nc",), "--resume")
    require_writable(plot, FIGURES, "--plot")
    result, failed, stopped = delivered(
        lambda: slipwave.curve(
            source,
            of,
            over,
            along,
            model,
            settings=settings or (),
            tol=tol,
            out=out,
            resume=resume,
            most_points=most_points,
        )
    )
    problems = []
    if result.found.points:
        problems = deliver(
            lambda: print_json(result.summary) if json else _print(result.found, result.outcome.wall_s), (result.save_plot, plot)
        )
    conclude("; ".join([failed, *([way_on(out or resume)] if stopped else [])]), problems, stopped)


def _print(found: "Curve", wall_s: float) -> None:
    from validation.results.header import header

    print("\n".join(header(found.over.base, found.notes)))
    print(f"model {found.model}: {found.kind} {KINDS[found.kind]}, {len(found.points)} points")
    print()
    rows = [
        [
            figures(point.first, 11),
            figures(point.second, 8),
            figures(point.period),
            figures(point.stress_drop, 7),
            figures(point.bracket, 2),
            f"{point.multiplier[0]:.6f} +- {abs(point.multiplier[1]):.6f} i",
        ]
        for point in thinned(found.points, _LISTED)
    ]
    print_table([found.over.name, found.second.name, "period", "stress drop", "bracket", "multiplier"], rows)
    print(f"\nperiods in transits; wall time {wall_s:.3g} s")
