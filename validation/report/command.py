"""`slipwave report`: Run the studies whose scene, code or settings changed and write DIR/index.html."""

from pathlib import Path
from typing import Annotated

import typer

from slipwave.errors import Interrupted
from slipwave.extras import require
from slipwave.files import require_folder
from validation.commands.command_line import printed


def report(
    quick: Annotated[bool, typer.Option("--quick", help="the cheap version of every study")] = False,
    only: Annotated[list[str] | None, typer.Option(metavar="STUDY ...", help="only these studies; may be repeated")] = None,
    out: Annotated[Path, typer.Option(metavar="DIR", help="folder of the page and its data")] = Path("reports"),
    against: Annotated[
        Path | None,
        typer.Option(metavar="FILE|DIR", help="compare with another report.json, or the folder of one, not with the baseline"),
    ] = None,
    law: Annotated[
        Path | None, typer.Option(metavar="FILE.py", help="run this Python file, which registers a friction law that studies use")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="print report.json, and nothing else, on stdout")] = False,
) -> None:
    """Run the studies; write the page and its files."""
    from slipwave.friction.own import load_laws
    from validation.report.baseline import RedReport, change_lines
    from validation.report.build import make_report
    from validation.report.record import NAME, read_report
    from validation.report.registered import choose

    require("report", "the report")
    if law is not None:
        load_laws(law)
    choose(only)  # an unknown name is refused before the folder is made
    earlier = read_report(against) if against else None
    require_folder(out)

    def tell() -> None:
        """Print the path of the page and the changes, or the whole record."""
        if as_json:
            print((out / NAME).read_text(encoding="utf-8"), end="")
        else:
            print("\n".join([str(out / "index.html"), *(change_lines(read_report(out).changes) if against else ())]))

    try:
        make_report(out=out, quick=quick, only=only or None, against=earlier)
        printed(tell)
    except RedReport as red:
        printed(tell)
        for line in red.lines:
            typer.echo(line, err=True)
        raise
    except KeyboardInterrupt:
        raise Interrupted(
            f"interrupted; finished studies are kept in {out / 'data'}, and the same command goes on from there"
        ) from None


COMMAND_LINE = {
    "report": (
        report,
        (
            "slipwave report --quick",
            "slipwave report --only one-cycle --out reports",
            "slipwave report --against last-release/report.json",
            "slipwave report --json > report.json",
        ),
    ),
}
"""As that of `validation.commands.listing`."""
