"""What a scene needs from a model beyond two alike, plain slabs, with phrases for refusals. Light to import."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from slipwave.scene import Scene
    from slipwave.scene.slab import Slab

FEATURES = {
    "unlike": "unlike slabs",
    "grip": "a grip at the outer face",
    "reflection": "an outer face without a spring (a reflection coefficient below 1, a stiffness of 0)",
    "mass": "a mass on the outer face",
    "layers": "layers",
    "kelvin-voigt": "Kelvin-Voigt viscosity",
    "standard-linear": "standard-linear viscosity",
}
"""Name of every feature, with the phrase that describes it."""


def features_of(scene: "Scene") -> frozenset[str]:
    """The features of `scene` (keys of FEATURES)."""
    unlike = set[str]() if scene.alike else {"unlike"}
    return frozenset(unlike.union(*map(_slab_features, scene.slabs)))


def in_words(features: frozenset[str]) -> str:
    """Phrases for `features`, joined; empty if there are none."""
    return " and ".join(phrase for feature, phrase in FEATURES.items() if feature in features)


def _slab_features(slab: "Slab") -> set[str]:
    from slipwave.scene.slab import KelvinVoigtViscosity, StandardLinearViscosity

    held = slab.termination
    kinds = {
        "grip": held.spring > 0.0,
        "reflection": held.has_dead_load,
        "mass": held.mass > 0.0,
        "layers": len(slab.layers) > 1,
        "kelvin-voigt": isinstance(slab.viscosity, KelvinVoigtViscosity),
        "standard-linear": isinstance(slab.viscosity, StandardLinearViscosity),
    }
    return {kind for kind, present in kinds.items() if present}
