"""`slipwave compare`: several models on one scene, in one figure and one table."""

from pathlib import Path
from typing import Annotated, Any

import typer

import slipwave
from validation.commands.options import (
    Cells,
    Cfl,
    Json,
    Law,
    SceneName,
    Settings,
    TimeMarch,
    Tolerance,
    Until,
    Yes,
    most_seconds,
)
from validation.output import FIGURES, conclude, deliver, figures, print_json, print_table, require_writable

Models = Annotated[
    str, typer.Option(metavar="M1,M2,...", help="the models; the reference is delay if it is among them, else the first")
]
DEFAULT = "compare.png"
OutFile = Annotated[
    Path | None, typer.Option(metavar="FILE.png", help=f"the overlay figure (default {DEFAULT}; with --json none)")
]

EXAMPLES = ("slipwave compare paper --models delay,kelvin-voigt,fd --out compare.png",)


def compare(
    source: SceneName,
    models: Models,
    until: Until = None,
    settings: Settings = None,
    law: Law = None,
    cells: Cells = None,
    cfl: Cfl = None,
    time: TimeMarch = None,
    tol: Tolerance = None,
    out: OutFile = None,
    yes: Yes = False,
    json: Json = False,
) -> None:
    """Draw one cycle of each model in one figure; print periods and stress drops with their errors."""
    from validation.door.result import delivered

    if out is None and not json:
        out = Path(DEFAULT)
    require_writable(out, FIGURES)
    result, failed, stopped = delivered(
        lambda: slipwave.compare(
            source,
            models,
            until=until,
            settings=settings or (),
            cells=cells,
            cfl=cfl,
            time=time,
            tol=tol,
            most_seconds=most_seconds(yes),
        )
    )
    summary = result.summary | ({"figure": str(out)} if out else {})
    problems = deliver(lambda: print_json(summary) if json else _print(summary), (result.save_plot, out))
    conclude(failed, problems, stopped)


def _print(summary: dict[str, Any]) -> None:
    from validation.results.wording import barred, errors_of, remarks

    def mean(row: dict[str, Any], name: str, digits: int) -> str:
        """A cell, with a bar for motion that never repeats."""
        return barred(row[name]["mean"], row["margins"][name] if row["margins"] else 0.0, digits)

    heading = ["model", "period", "std", "stress drop", "elastic drop", "v_max", "v_min", "error T", "error drop", "wall s"]
    table = [
        [
            row["model"],
            mean(row, "period", 9),
            figures(row["period"]["std"], 2),
            mean(row, "stress_drop", 7),
            mean(row, "elastic_stress_drop", 7),
            figures(row["v_max"], 7),
            figures(row["v_min"], 7),
            *errors_of(row),
            figures(row["wall_s"], 3),
        ]
        for row in summary["models"]
    ]
    print_table(heading, table)
    against = f"relative errors against {summary['reference']}"
    print(f"\nperiods in transits, means over the second half, {against}; figure: {summary['figure']}")
    for line in remarks(summary):
        print(line)
