"""`slipwave branch`: periodic orbits followed in a parameter, through folds, with the points where their stability changes."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from validation.branches import KINDS
from validation.commands.options import Cells, Json, Model, SceneName, Settings

if TYPE_CHECKING:
    from validation.branches.follow import Head, Limits
    from validation.branches.record import Branch, BranchPoint, SpecialPoint

SCHEMA = 1
"""Version of the keys of the JSON."""

_LISTED = 12  # points in the table

OverText = Annotated[
    str,
    typer.Option(
        "--over",
        metavar="KEY=FROM:TO",
        help="the parameter: log10_r, epsilon, V, a, b, or any key of the scene, as upper.epsilon",
    ),
]
BranchTolerance = Annotated[float, typer.Option("--tol", help="requested relative error of period, drops and slip rates")]
OutFile = Annotated[Path | None, typer.Option(metavar="FILE.nc", help="write each point here as it is computed")]
ResumeFile = Annotated[
    Path | None, typer.Option(metavar="FILE.nc", help="go on from the last point in this file, and write the further ones to it")
]
StopAt = Annotated[str | None, typer.Option(metavar="|".join(KINDS), help="stop at the first special point of this kind")]
Longest = Annotated[float | None, typer.Option("--longest-period", metavar="TRANSITS", help="stop at this period")]
Most = Annotated[int, typer.Option("--most-points", help="stop after so many points")]
Switch = Annotated[
    str | None,
    typer.Option(
        metavar="HB|PD",
        help="PD: follow the orbits of twice the period from the first period doubling on",
    ),
]
Plot = Annotated[Path | None, typer.Option(metavar="FILE", help="draw the branch: .png, .pdf or .svg")]


def branch(
    source: SceneName,
    over: OverText,
    model: Model = "auto",
    tol: BranchTolerance = 1e-6,
    settings: Settings = None,
    cells: Cells = None,
    out: OutFile = None,
    resume: ResumeFile = None,
    stop_at: StopAt = None,
    switch: Switch = None,
    longest_period: Longest = None,
    most_points: Most = 2000,
    plot: Plot = None,
    json: Json = False,
) -> None:
    """Follow periodic orbits from where steady sliding loses stability, stable or not, through folds.

    Special points: HB Hopf, LP fold, PD period doubling, NS torus. Where the range holds no Hopf point, the branch begins with
    the orbit that a run at an unstable end leads to.
    """
    import time

    from slipwave.errors import NumericsError
    from validation.branches.drawing import FIGURES, draw
    from validation.branches.follow import is_doubled, limits_of
    from validation.branches.parameter import over_range
    from validation.branches.record import Branch
    from validation.output import attempt, conclude, print_json, printed, require_writable
    from validation.registry.flows import flowing
    from validation.registry.orbits import require_tolerance

    require_tolerance(tol)
    limits, doubled = limits_of(stop_at, longest_period, most_points), is_doubled(switch)
    for path, kinds, option in ((out, (".nc",), "--out"), (resume, (".nc",), "--resume"), (plot, FIGURES, "--plot")):
        if path is not None:
            require_writable(path, kinds, option)
    parameter = over_range(over, source, settings)
    name, why = flowing(model, parameter.base)
    if why:
        typer.echo(f"model auto: {name} ({why})", err=True)
    found, failed, stopped, began = Branch(parameter, name, tol, cells, doubled), "", "", time.perf_counter()
    try:
        _compute(found, limits, out or resume, resume)
    except NumericsError as error:
        failed = str(error)
    except KeyboardInterrupt:
        failed, stopped = f"interrupted after {len(found.points)} points", _way_on(out or resume)
    if not (found.points or found.special):
        conclude(failed, [], stopped)
    result = result_of(found, time.perf_counter() - began, failed)
    tasks = [lambda: printed(lambda: print_json(result) if json else _print(found, result["wall_s"]))]
    if plot is not None:
        tasks.append(lambda: draw(plot, found))
    conclude(failed, attempt(*tasks), stopped)


def _way_on(path: Path | None) -> str:
    return f"--resume {path} goes on from there" if path else "no file was kept: --out FILE.nc keeps one to go on from"


def _compute(found: "Branch", limits: "Limits", path: Path | None, resume: Path | None) -> None:
    """Fill the branch and, after each point, its file."""
    from validation.branches.follow import begin, follow
    from validation.branches.stored import read, write
    from validation.run.progress import progress

    def keep(head: "Head", complete: bool) -> None:
        if path is not None:
            write(path, found, head, complete)

    last = head = read(resume, found) if resume is not None else begin(found)
    keep(last, False)
    with progress(f"{found.over.base.name}, {found.model}, points of the branch", limits.points) as report:
        for last in follow(found, head, limits):
            keep(last, False)
            report(len(found.points))
    keep(last, True)


def result_of(found: "Branch", wall_s: float, failed: str = "") -> dict[str, Any]:
    """The JSON of the command (users rely on its keys); `failed` is there only if the numerics failed or the user stopped it."""
    result = {
        "schema": SCHEMA,
        "scene": found.over.base.name,
        "model": found.model,
        "clock": "transit",
        "parameter": found.over.name,
        "points": [_at(found, point) for point in found.shown],
        "special": [_at(found, special) for special in found.shown_special],
        "wall_s": wall_s,
        "notes": found.notes,
    }
    return result | ({"failed": failed} if failed else {})


def _at(found: "Branch", row: "BranchPoint | SpecialPoint") -> dict[str, Any]:
    """A point with the value of the parameter under its own name."""
    name, facts = found.over.name, row._asdict()
    kind = {"type": facts.pop("kind")} if "kind" in facts else {}
    facts.pop("place", None)
    value = facts.pop("value")
    named = {name: value} if name == "log10_r" else {name: value, "parameter": name, "value": value}
    return kind | named | facts


def _print(found: "Branch", wall_s: float) -> None:
    from validation.commands.wording import describe
    from validation.output import figures, print_table

    for line in describe(found.over.base):
        print(line)
    for note in found.notes:
        print(f"note: {note}")
    points = found.shown
    low, high = found.over.ends
    print(f"model {found.model}: {len(points)} orbits over {found.over.name} from {low:g} to {high:g}")
    print()
    if found.shown_special:
        print_table(*_special_rows(found))
        print()
    every = max(1, -(-len(points) // _LISTED))
    listed = points[::every] + ([points[-1]] if points and (len(points) - 1) % every else [])
    heading = [found.over.name, "period", "stress drop", "elastic stress drop", "v_max", "v_min", "stable"]
    table = [
        [
            figures(point.value, 8),
            *(figures(getattr(point, name), 7) for name in ("period", "stress_drop", "elastic_stress_drop", "v_max", "v_min")),
            {True: "yes", False: f"no ({point.unstable})", None: "not decided"}[point.stable],
        ]
        for point in listed
    ]
    print_table(heading, table)
    print(f"\nperiods in transits; wall time {wall_s:.3g} s")


def _special_rows(found: "Branch") -> tuple[list[str], list[list[str]]]:
    from validation.output import figures

    rows = [
        [
            f"{special.kind} {KINDS[special.kind]}",
            figures(special.value, 11),
            figures(special.bracket, 2),
            figures(special.period),
            figures(special.stress_drop, 7),
            f"{special.unstable_before} -> {special.unstable_after}",
        ]
        for special in found.shown_special
    ]
    return ["special points", found.over.name, "bracket", "period", "stress drop", "unstable multipliers"], rows
