"""The commands without a `Result`: `scenes`, `schema`, `show` and `report`."""

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

import slipwave
from slipwave.errors import Interrupted
from slipwave.extras import require
from slipwave.files import require_folder
from validation.command_line import printed

EXAMPLES = {
    "report": (
        "slipwave report --quick",
        "slipwave report --only one-cycle --out reports",
        "slipwave report --against last-release/report.json",
        "slipwave report --json > report.json",
    ),
    "scenes": ("slipwave scenes",),
    "schema": ("slipwave schema > scene.schema.json", "slipwave schema --report > report.schema.json"),
    "show": ("slipwave show paper > mine.toml", "slipwave show run.nc"),
}


def print_scenes() -> None:
    """The gallery's scenes, one line each."""
    from slipwave.input.source import gallery_titles

    titles = gallery_titles()
    width = max(map(len, titles))
    for name, title in titles.items():
        print(f"{name:<{width}}  {title}")


def schema(report: Annotated[bool, typer.Option("--report", help="that of report.json instead")] = False) -> None:
    """The table of scene keys, or what report.json holds, as a JSON Schema."""
    if report:
        from validation.report.record import report_schema as made
    else:
        from slipwave.input.schema import json_schema as made
    print(json.dumps(made(), indent=2))


def print_scene(source: str, options: Any, files: Mapping[Any, Any], as_json: bool) -> None:
    """A scene as pure TOML; what else a file of results holds as comments."""
    from slipwave.input.source import is_stored, read_stored, to_toml
    from slipwave.input.wording import one_line
    from validation.results.wording import header

    scene = slipwave.read(source, options.settings)
    facts = read_stored(source).facts if is_stored(source) else {}
    stored = [f"{name} = {value}" for name, value in facts.items() if name != "scene_toml"]
    comments = [f"# {one_line(line)}" for line in [*header(scene), *stored]]
    printed(lambda: print("\n".join([*comments, "", to_toml(scene)]), end=""))


def report(
    quick: Annotated[bool, typer.Option("--quick", help="the cheap version of every study")] = False,
    only: Annotated[list[str] | None, typer.Option(metavar="STUDY ...", help="only these studies; may be repeated")] = None,
    out: Annotated[Path, typer.Option(metavar="DIR", help="folder of the page and its data")] = Path("reports"),
    against: Annotated[
        Path | None,
        typer.Option(metavar="FILE|DIR", help="compare with another report.json, or the folder of one, not with the baseline"),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="print report.json, and nothing else, on stdout")] = False,
) -> None:
    """Run the studies; write the page and its files."""
    from validation.report.baseline import RedReport
    from validation.report.build import make_report
    from validation.report.changes import change_lines
    from validation.report.recorded import NAME, read_report
    from validation.studies import choose

    require("report", "the report")
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


WITHOUT_SCENE: dict[str, Callable[..., None]] = {"report": report, "scenes": print_scenes, "schema": schema}
"""Commands whose options are declared here, by name."""
