"""One elastic slab as data: what it is made of and what holds its outer face.

The interface sees only its one-port (MODEL.md section 3).

Impedances are in units of (normal stress)/V*, times in L/V*. `round_trip` is the travel time from the
interface to the outer face and back.
"""

import math
from dataclasses import dataclass, field
from typing import TypeAlias


@dataclass(frozen=True)
class RigidFace:
    """The drive moves the outer face itself: full reflection of velocity, no state."""


@dataclass(frozen=True)
class GripFace:
    """A spring and a dashpot in parallel between drive and outer face (MODEL.md section 3).

    `stiffness` K is relative to the slab's epsilon/round_trip, `impedance` Z_g to its epsilon; Z_g = 1 swallows every wave and
    keeps the load. If either is infinite the face cannot move against the drive: a slab held so has a `RigidFace`.
    """

    stiffness: float
    impedance: float


@dataclass(frozen=True)
class ReflectingFace:
    """A bare reflection coefficient R in [-1, 1] between drive and slab: R = 1 is rigid, R = 0 swallows waves *and* load."""

    coefficient: float


Face: TypeAlias = RigidFace | GripFace | ReflectingFace


@dataclass(frozen=True)
class KelvinVoigtViscosity:
    """sigma = G (gamma + time * gamma'), `time` in L/V*."""

    time: float


@dataclass(frozen=True)
class StandardLinearViscosity:
    """Zener solid: unrelaxed modulus G (so waves keep their speed at high frequency), relaxed modulus G / (1 + ratio),
    stress relaxation over `time` (in L/V*)."""

    time: float
    ratio: float


Viscosity: TypeAlias = KelvinVoigtViscosity | StandardLinearViscosity


@dataclass(frozen=True)
class Layer:
    """A sublayer: its share of the slab's round trip and its impedance relative to the slab's epsilon. Layers run from the
    interface outwards."""

    fraction: float
    impedance: float


@dataclass(frozen=True)
class Slab:
    """A slab of impedance `epsilon` and round trip `round_trip` (15), homogeneous and elastic unless told otherwise."""

    epsilon: float
    round_trip: float
    face: Face = field(default_factory=RigidFace)
    viscosity: Viscosity | None = None
    layers: tuple[Layer, ...] = (Layer(1.0, 1.0),)

    def __post_init__(self) -> None:
        if isinstance(self.face, GripFace) and math.inf in (self.face.stiffness, self.face.impedance):
            object.__setattr__(self, "face", RigidFace())

    @property
    def interface_impedance(self) -> float:
        """Impedance of the layer at the interface: what a fast change of velocity meets."""
        return self.epsilon * self.layers[0].impedance

    @property
    def compliance(self) -> float:
        """Quasi-static displacement per stress: layers, sum of round_trip fraction / (2 impedance), a standard linear solid
        relaxed, and the grip's spring."""
        softer = 1.0 + (self.viscosity.ratio if isinstance(self.viscosity, StandardLinearViscosity) else 0.0)
        layers = softer * sum(layer.fraction * self.round_trip / (2.0 * self.epsilon * layer.impedance) for layer in self.layers)
        grip = self.round_trip / (self.epsilon * self.face.stiffness) if isinstance(self.face, GripFace) else 0.0
        return layers + grip

    @property
    def is_plain(self) -> bool:
        """Homogeneous, elastic, driven through a rigid face."""
        return isinstance(self.face, RigidFace) and self.viscosity is None and len(self.layers) == 1
