"""The commands without a `Result`: `scenes`, `schema` and `show`; by name what commands call of the proof, as `report`."""

import json
from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Annotated, Any

import typer

import slipwave
from validation.commands.command_line import printed

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


def _print_scenes() -> None:
    """The gallery's scenes, one line each."""
    from slipwave.input.assemble import gallery_titles

    titles = gallery_titles()
    width = max(map(len, titles))
    for name, title in titles.items():
        print(f"{name:<{width}}  {title}")


def _print_schema(report: Annotated[bool, typer.Option("--report", help="that of report.json instead")] = False) -> None:
    """The table of scene keys, or what report.json holds, as a JSON Schema."""
    if report:
        made = of_proof("schema")
    else:
        from slipwave.input.schema import json_schema as made
    print(json.dumps(made(), indent=2))


def print_scene(source: str, options: Any, files: Mapping[Any, Any], as_json: bool) -> None:
    """A scene as pure TOML; what else a file of results holds as comments."""
    from slipwave.input.assemble import is_stored, to_toml
    from slipwave.input.stored import read_stored
    from slipwave.input.wording import one_line
    from validation.commands.wording import header

    scene = slipwave.read(source, options.settings)
    facts = read_stored(source).facts if is_stored(source) else {}
    stored = [f"{name} = {value}" for name, value in facts.items() if name != "scene_toml"]
    comments = [f"# {one_line(line)}" for line in [*header(scene), *stored]]
    printed(lambda: print("\n".join([*comments, "", to_toml(scene)]), end=""))


WITHOUT_SCENE: dict[str, Callable[..., None]] = {"scenes": _print_scenes, "schema": _print_schema}
"""Commands whose options are declared here, by name."""

PROOF = {"report": "validation.report.command:report", "schema": "validation.report.record:report_schema"}
"""What these commands call of the proof, which uses the commands: imported when it is called, as `slipwave.verify` is."""


def of_proof(command: str) -> Any:
    """The function of `PROOF` that `command` calls."""
    module, _, name = PROOF[command].partition(":")
    return getattr(import_module(module), name)
