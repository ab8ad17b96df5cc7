"""`slipwave show`: a scene as pure TOML; what else a file of results holds as comments."""

import slipwave
from validation.commands.options import Law, SceneName, Settings
from validation.output import printed

EXAMPLES = (
    "slipwave show paper > mine.toml",
    "slipwave show run.nc",
)


def show(source: SceneName, settings: Settings = None, law: Law = None) -> None:
    """Print the resolved scene as TOML, for a file of your own: slipwave show paper > mine.toml"""
    from slipwave.input.stored import is_stored, read_stored
    from slipwave.input.tables import to_toml
    from slipwave.input.wording import one_line
    from validation.results.header import header

    scene = slipwave.read(source, settings or ())
    facts = read_stored(source).facts if is_stored(source) else {}
    stored = [f"{name} = {value}" for name, value in facts.items() if name != "scene_toml"]
    comments = [f"# {one_line(line)}" for line in [*header(scene), *stored]]
    printed(lambda: print("\n".join([*comments, "", to_toml(scene)]), end=""))
