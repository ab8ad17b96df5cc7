"""`slipwave.scenes`, `slipwave.models` and `slipwave.show`: the scenes of the gallery, the models, and a scene as TOML."""

from slipwave.input.assemble import SceneSource, gallery_titles, to_toml
from validation.commands.options import SceneOptions, command
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
