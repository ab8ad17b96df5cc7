"""Parameters of a scene by name, for boundaries and branches. A new one needs one function and one line of `PARAMETERS`."""

import dataclasses
from collections.abc import Callable
from difflib import get_close_matches
from typing import Any

from slipwave.errors import SceneError
from slipwave.scene import Scene
from slipwave.scene.drive import steady_drive
from slipwave.scene.slab import Slab


def scaled(scene: Scene, round_trip: float = 1.0, epsilon: float = 1.0, velocity: float | None = None) -> Scene:
    """The scene with both round trips and both epsilons multiplied, and with constant drive `velocity` (V*) if given."""
    drive = scene.drive if velocity is None else steady_drive(velocity)
    return _both(
        dataclasses.replace(scene, drive=drive),
        lambda slab: dataclasses.replace(slab, round_trip=slab.round_trip * round_trip, epsilon=slab.epsilon * epsilon),
    )


def held(scene: Scene, before: Scene) -> Scene:
    """The scene, whose slabs were other ones `before`, with its faces as they were then in what was given in SI."""
    if not (before.upper.face.own or before.lower.face.own) or (scene.upper, scene.lower) == (before.upper, before.lower):
        return scene
    upper, lower = (
        dataclasses.replace(slab, face=slab.face.moved(slab.epsilon / old.epsilon, slab.round_trip / old.round_trip))
        for slab, old in ((scene.upper, before.upper), (scene.lower, before.lower))
    )
    return dataclasses.replace(scene, upper=upper, lower=lower)


def thickened(scene: Scene, factor: float) -> Scene:
    """The scene with both slabs `factor` times as thick, of the same material, held by the same faces."""
    return held(scaled(scene, round_trip=factor), scene)


def scaling(scene: Scene) -> Scene:
    """The scene with faces that keep their ratios to the slabs, whatever they were given in."""
    return _both(scene, lambda slab: dataclasses.replace(slab, face=dataclasses.replace(slab.face, own=frozenset())))


def _both(scene: Scene, change: Callable[[Slab], Slab]) -> Scene:
    return dataclasses.replace(scene, upper=change(scene.upper), lower=change(scene.lower))


def _law(name: str) -> Callable[[Scene, float], Scene]:
    def change(scene: Scene, value: float) -> Scene:
        """Raises SceneError for a user's law without that parameter."""
        if name not in scene.law._fields:
            own = ", ".join(f"interface.{key}" for key in scene.law._fields)
            raise SceneError(f"interface.{name} = {value:g}: the law of scene {scene.name!r} has none; must be one of {own}")
        return dataclasses.replace(scene, law=scene.law._replace(**{name: value}))

    return change


def _face(name: str) -> Callable[[Scene, float], Scene]:
    def change(slab: Slab, value: float) -> Slab:
        """The slab with this field of its face changed, if its kind of face has that field."""
        face: Any = slab.face
        if name not in vars(face):
            return slab
        return dataclasses.replace(slab, face=dataclasses.replace(face, own=face.own - {name}, **{name: value}))

    def change_both(scene: Scene, value: float) -> Scene:
        """Raises SceneError if no face has that field: a coefficient of 1 is a rigid face."""
        if not any(name in vars(slab.face) for _, slab in scene.named_slabs):
            whole = f"of a scene whose slab.face.kind has it the whole key, slab.face.{name}, can be varied"
            raise SceneError(f"slab.face.{name} = {value:g}: no outer face of scene {scene.name!r} has one; {whole}")
        return _both(scene, lambda slab: change(slab, value))

    return change_both


def _lower(name: str) -> Callable[[Scene, float], Scene]:
    """Sets a quantity of the lower slab by its ratio to that of the upper slab."""
    return lambda scene, value: dataclasses.replace(
        scene, lower=dataclasses.replace(scene.lower, **{name: value * getattr(scene.upper, name)})
    )


def _logarithmic(setter: Callable[[Scene, float], Scene]) -> Callable[[Scene, float], Scene]:
    return lambda scene, value: setter(scene, 10.0**value)


_POSITIVE: dict[str, Callable[[Scene, float], Scene]] = {
    "r": lambda scene, value: scaled(scene, round_trip=value / scene.upper.round_trip),
    "epsilon": lambda scene, value: scaled(scene, epsilon=value / scene.upper.epsilon),
    "V": lambda scene, value: scaled(scene, velocity=value),
    "grip_impedance": _face("impedance"),
    "grip_stiffness": _face("stiffness"),
    "machine_mass": _face("mass"),
}
PARAMETERS: dict[str, Callable[[Scene, float], Scene]] = {
    **_POSITIVE,
    **{f"log10_{name}": _logarithmic(setter) for name, setter in _POSITIVE.items()},
    "a": _law("a"),
    "b": _law("b"),
    "reflection": _face("coefficient"),
    "ratio_r": _lower("round_trip"),
    "ratio_epsilon": _lower("epsilon"),
}
"""name -> (scene, value) -> the scene with that parameter changed. r and epsilon are the upper slab's, their ratios kept."""

LABELS = {
    "ratio_r": "round trip, lower over upper slab",
    "ratio_epsilon": "impedance, lower over upper slab",
    "grip_impedance": "impedance of the face's dashpot / ε",
    "grip_stiffness": "stiffness of the face's spring / (ε/r)",
    "machine_mass": "mass on the face / (ε r)",
    "reflection": "reflection coefficient of the outer face",
}
"""Axis labels of the parameters that are no keys of a scene."""


def with_parameter(scene: Scene, name: str, value: float) -> Scene:
    """`scene` with parameter `name` set to `value`. Raises SceneError for an unknown name, naming the nearest known one."""
    if name not in PARAMETERS:
        near = get_close_matches(name, PARAMETERS, 1, 0.0)[0]
        raise SceneError(f"parameter {name!r} is not known, did you mean {near!r}? Known: {', '.join(PARAMETERS)}")
    return PARAMETERS[name](scene, value)
