"""`slipwave.scenes`, `slipwave.models` and `slipwave.show`: what there is to compute, and by what."""

from collections.abc import Iterable
from typing import Any

from slipwave.input import SceneSource
from slipwave.input.source import gallery_titles
from slipwave.input.tables import to_toml
from validation.door.checked import checked
from validation.door.result import scene_of
from validation.registry.choice import families, honouring


@checked
def scenes() -> dict[str, str]:
    """The gallery: name and title of each scene."""
    return gallery_titles()


@checked
def models(source: "SceneSource | None" = None, *, settings: Iterable[str] = (), **changes: Any) -> dict[str, str]:
    """The models of this installation, cheapest first: name and what it is. With a scene, those that can compute it."""
    able = families() if source is None else honouring(scene_of(source, settings, changes))
    return {family.pattern: family.title for family in able}


@checked
def show(source: SceneSource, *, settings: Iterable[str] = (), **changes: Any) -> str:
    """The resolved scene as TOML, for a file of your own. Raises SceneError for wrong input."""
    return to_toml(scene_of(source, settings, changes))
