"""Lists of scenes and models, the keys of scenes, and a scene as TOML; `models` is a function of Python only.

`slipwave scenes`: List the gallery's scenes, one line each.

`slipwave schema`: Print the JSON Schema of scene files, for an editor that completes and checks them.

`slipwave show`: Print the resolved scene as TOML, for a file of your own: slipwave show paper > mine.toml
"""

import json
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any

import typer

from slipwave.input.assemble import SceneSource, gallery_titles, is_stored, read, to_toml
from slipwave.input.schema import json_schema
from slipwave.input.stored import read_stored
from slipwave.input.wording import one_line
from validation.commands.command_line import on_a_scene, printed
from validation.commands.options import SceneOptions, command
from validation.commands.wording import header
from validation.models.by_name import families, honouring

_UNCHANGED = SceneOptions()


def scenes() -> dict[str, str]:
    """Name -> title of each scene of the gallery."""
    return gallery_titles()


@command
def models(source: "SceneSource | None" = None, options: SceneOptions = _UNCHANGED) -> dict[str, str]:
    """Name -> description of the models of this installation, cheapest first. With a scene, those that can compute it."""
    able = families() if source is None else honouring(options.scene_of(source))
    return {family.pattern: family.title for family in able}


@command
def show(source: SceneSource, options: SceneOptions) -> str:
    """The resolved scene as TOML, for a file of your own. Raises SceneError for wrong input."""
    return to_toml(options.scene_of(source))


def _print_scenes() -> None:
    """The gallery's scenes, one line each."""
    titles = gallery_titles()
    width = max(map(len, titles))
    for name, title in titles.items():
        print(f"{name:<{width}}  {title}")


def _print_schema(
    report: Annotated[bool, typer.Option("--report", help="that of report.json instead")] = False,
    law: Annotated[Path | None, typer.Option(metavar="FILE.py", help="run this Python file, whose laws are in it too")] = None,
) -> None:
    """The table of scene keys, or what report.json holds, as a JSON Schema."""
    SceneOptions(law=law).load_own()
    made = import_module("validation.report.record").report_schema if report else json_schema  # the proof uses the commands
    print(json.dumps(made(), indent=2))


def _print_scene(source: str, options: Any, files: Mapping[Any, Any], as_json: bool) -> None:
    """A scene as pure TOML; what else a file of results holds as comments."""
    scene = read(source, options.settings)
    facts = read_stored(source).facts if is_stored(source) else {}
    stored = [f"{name} = {value}" for name, value in facts.items() if name != "scene_toml"]
    comments = [f"# {one_line(line)}" for line in [*header(scene), *stored]]
    printed(lambda: print("\n".join([*comments, "", to_toml(scene)]), end=""))


COMMAND_LINE = {
    "scenes": (_print_scenes, ("slipwave scenes",)),
    "schema": (_print_schema, ("slipwave schema > scene.schema.json", "slipwave schema --report > report.schema.json")),
    "show": (on_a_scene(SceneOptions, _print_scene), ("slipwave show paper > mine.toml", "slipwave show run.nc")),
}
"""The commands that give no `Result`: functions of the command line's words, and examples."""
