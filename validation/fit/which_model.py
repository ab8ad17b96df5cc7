"""The model of a fit: the default, what it leaves out, and the next to try."""

from slipwave.family import features_of
from slipwave.scene import Scene
from validation.fit.orbits import MOST_TRANSITS
from validation.models.by_name import family_of

CHEAP = "quasidynamic"
_BLOCK = "fitted:0"
_LADDER = ("quasistatic", CHEAP, "block12", _BLOCK, "delay")
"""Each has more of a scene than those before."""

_NO_BLOCK = {"kelvin-voigt", "standard-linear", "reflection"}


def default_model(scene: Scene) -> str:
    """The cheapest model that has the mass on the outer faces, where there is one."""
    features = features_of(scene)
    return _BLOCK if "mass" in features and not features & _NO_BLOCK else CHEAP


def missing_in(model: str, scene: Scene) -> tuple[str, ...]:
    """A line on what a cheap `model` leaves out of the `scene`; none for other models."""
    mass = "the mass on the outer face and " if model in _LADDER[:2] and "mass" in features_of(scene) else ""
    return (f"model {model} leaves out {mass}waves that return",) if model in _LADDER[:-1] else ()


def next_model(model: str, scene: Scene, length: float) -> str:
    """The cheapest model that has more of the `scene` than `model`, for cycles of `length` (transits); empty if there is none."""
    features, place = features_of(scene), _LADDER.index(model) if model in _LADDER else len(_LADDER)
    for name in _LADDER[place + 1 :]:
        family = family_of(name)
        has_block = name != _BLOCK or ("grip" in features and not features & _NO_BLOCK)
        if family and not family.refusal(scene) and has_block and (name != "delay" or length <= MOST_TRANSITS):
            return name
    return ""
