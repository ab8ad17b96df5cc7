"""`slipwave report`: run the studies and write the page."""

from pathlib import Path
from typing import Annotated

import typer

from slipwave.errors import Interrupted
from slipwave.extras import require
from validation.output import require_folder

EXAMPLES = (
    "slipwave report --quick",
    "slipwave report --only one-cycle --out reports",
)


def report(
    quick: Annotated[bool, typer.Option("--quick", help="the cheap version of every study")] = False,
    only: Annotated[list[str] | None, typer.Option(metavar="STUDY ...", help="only these studies; may be repeated")] = None,
    out: Annotated[Path, typer.Option(metavar="DIR", help="folder of the page and its data")] = Path("reports"),
) -> None:
    """Run the studies whose scene, code or settings changed and write DIR/index.html."""
    from validation.report.build import make_report
    from validation.report.red import RedReport

    require("report", "the report")
    require_folder(out)
    try:
        print(make_report(out=out, quick=quick, only=only or None))
    except RedReport as red:
        print(red.page)
        for line in red.lines:
            typer.echo(line, err=True)
        raise
    except KeyboardInterrupt:
        raise Interrupted(
            f"interrupted; finished studies are kept in {out / 'data'}, and the same command goes on from there"
        ) from None
