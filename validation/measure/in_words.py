"""Measurements of scenes that the words of a command give: a name and its settings, as in "paper --set slab.log10_r=-2.6"."""

from typing import Any

import slipwave as sw
from validation.measure.regimes import Regime, regime_of

_ORBITS = 1e-9
"""Relative errors of the figures of orbits."""


def command_words(name: str, settings: dict[str, Any]) -> str:
    """The words of a command that give a scene with these settings."""
    return " ".join([name, *(f"--set {key}={value}" for key, value in settings.items())])


def scene_of(words: str) -> sw.Scene:
    """The scene that the words give."""
    name, *settings = words.split(" --set ")
    return sw.read(name, settings)


def able(model: str, scene: sw.Scene) -> bool:
    """Whether a model can compute a scene."""
    return model.partition(":")[0] in (pattern.partition(":")[0] for pattern in sw.models(scene))


def state_at(words: str, until: float, model: str = "delay", **options: Any) -> float:
    """psi = ln phi of a model at `until` (transits), with `options` of `slipwave.run`."""
    return float(sw.run(scene_of(words), model, until=until, **options).final.psi)


def motion_at(model: str, words: str, until: float) -> Regime:
    """The final motion of a model, from a run to `until` (transits), and its orbit where that repeats once a cycle."""
    return regime_of(model, scene_of(words), until, None, _ORBITS)
