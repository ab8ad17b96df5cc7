"""What a scene asks of a model beyond two alike, plain slabs under a constant drive, in words for refusals."""

from scene.scene import Scene
from scene.slab import GripFace, KelvinVoigtViscosity, ReflectingFace, Slab, StandardLinearViscosity

FEATURES = {
    "unlike": "unlike slabs",
    "incommensurate": "round trips whose ratio is no small fraction",
    "grip": "a grip at the outer face",
    "reflection": "a bare reflection coefficient",
    "layers": "layers",
    "kelvin-voigt": "Kelvin-Voigt viscosity",
    "standard-linear": "standard-linear viscosity",
    "ramp": "a drive that changes",
}
"""Name of every feature, with the phrase that describes it."""

_LARGEST_DENOMINATOR = 8


def features_of(scene: Scene) -> frozenset[str]:
    """The features of `scene` (keys of FEATURES)."""
    found = {feature for slab in (scene.upper, scene.lower) for feature in _slab_features(slab)}
    if not scene.alike:
        found.add("unlike")
    if not _commensurate(scene.lower.round_trip / scene.upper.round_trip):
        found.add("incommensurate")
    if not scene.drive.is_constant:
        found.add("ramp")
    return frozenset(found)


def _slab_features(slab: Slab) -> set[str]:
    kinds = {
        "grip": isinstance(slab.face, GripFace),
        "reflection": isinstance(slab.face, ReflectingFace),
        "layers": len(slab.layers) > 1,
        "kelvin-voigt": isinstance(slab.viscosity, KelvinVoigtViscosity),
        "standard-linear": isinstance(slab.viscosity, StandardLinearViscosity),
    }
    return {kind for kind, present in kinds.items() if present}


def _commensurate(ratio: float) -> bool:
    """True if `ratio` is p/q to rounding with q no larger than 8."""
    multiples = [ratio * q for q in range(1, _LARGEST_DENOMINATOR + 1)]
    return any(abs(value - round(value)) < 1e-12 * max(value, 1.0) and round(value) > 0 for value in multiples)
