"""A slab as data: its material, its layers and its outer face.

The interface depends only on its one-port (MODEL.md section 3).

Impedances are in units of (normal stress)/V*, times in L/V*. `round_trip` is the travel time from the
interface to the outer face and back.

Models read an outer face of any kind only as a `Termination`, and viscosity of any kind as a `Rheology`: three numbers each.

A spring and a dashpot in parallel connect the drive to a mass, which moves with the face. In deviations from steady sliding and
in the slab's own direction of drive, with the drive's velocity V, the face's velocity w and the slab's stress sigma there,

    mass w' = load + dashpot (V - w) - sigma,     load' = spring (V - w).

An infinite spring or dashpot is a rigid face, w = V. Without a spring, the stress of steady sliding acts on the face as a
constant dead load.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Self, TypeAlias

from slipwave.errors import SceneError


@dataclass(frozen=True)
class Termination:
    """`dashpot` in units of stress/V*, `spring` in stress/V* per unit of time, `mass` in stress/V* times a unit of time, where
    stress is the normal stress. The unit of time is L/V*, or one transit after `in_transits`.

    Raises SceneError for a negative number, for NaN, and for an infinite mass.
    """

    spring: float
    dashpot: float
    mass: float = 0.0

    def __post_init__(self) -> None:
        if not (self.spring >= 0.0 and self.dashpot >= 0.0 and 0.0 <= self.mass < math.inf):
            raise SceneError(
                f"outer face: spring = {self.spring:g}, dashpot = {self.dashpot:g}, mass = {self.mass:g}: must be 0 or more, "
                "the mass finite"
            )

    @property
    def is_rigid(self) -> bool:
        """Whether the face moves with the drive."""
        return math.inf in (self.spring, self.dashpot)

    @property
    def has_dead_load(self) -> bool:
        """Whether there is no spring, so that the stress of steady sliding acts on the face itself."""
        return self.spring == 0.0 and not self.is_rigid

    @property
    def spring_rate(self) -> float:
        """Angular frequency below which the spring gives more of the stress than the dashpot (K/Z_g) and the mass (sqrt(K/m)); 0
        without a spring, infinite with nothing beside it."""
        dashpot = self.spring / self.dashpot if self.dashpot > 0.0 else math.inf
        mass = math.sqrt(self.spring / self.mass) if self.mass > 0.0 else math.inf
        return min(dashpot, mass) if self.spring > 0.0 else 0.0

    def in_transits(self, transit: float) -> "Termination":
        """The same with time in transits, one transit being `transit` L/V*."""
        return Termination(self.spring * transit, self.dashpot, self.mass / transit)


def face_sizes(impedance: float, time: float) -> dict[str, float]:
    """Field of a face -> its unit (spring, dashpot, mass), from the slab's `impedance` and round trip `time`, or in SI from units
    of both."""
    return {"stiffness": impedance / time, "impedance": impedance, "mass": impedance * time}


@dataclass(frozen=True)
class Face:
    """A kind of outer face: data that can be expressed as a `Termination`. Its fields are its keys in scene files; those of
    `face_sizes` are relative to the slab."""

    is_own: ClassVar[bool] = False
    """Whether bare numbers of it, an apparatus, are in SI where the scene has units."""

    own: frozenset[str] = field(default=frozenset(), kw_only=True, compare=False, repr=False)
    """The fields that were given in SI: they stay as they are where the slab changes (`moved`)."""

    def termination(self, epsilon: float, round_trip: float, outermost: float) -> Termination:
        """The face as numbers (time in L/V*) on a slab of `epsilon` and `round_trip` with impedance `outermost` of the outermost
        layer: multiples of `face_sizes`, so that Z/epsilon depends on s r alone, which analyses and fits rely on."""
        raise NotImplementedError

    def moved(self, epsilon: float, round_trip: float) -> Self:
        """The same face on a slab of so many times the epsilon and the round trip."""
        sizes = face_sizes(epsilon, round_trip)
        return replace(self, **{name: getattr(self, name) / sizes[name] for name in self.own})


@dataclass(frozen=True)
class RigidFace(Face):
    """The drive moves the outer face itself: full reflection of velocity, no state."""

    def termination(self, epsilon: float, round_trip: float, outermost: float) -> Termination:
        """As `Face`."""
        return Termination(0.0, math.inf)


@dataclass(frozen=True)
class GripFace(Face):
    """A spring and a dashpot in parallel between drive and outer face (MODEL.md section 3).

    `stiffness` K is relative to the slab's epsilon/round_trip, `impedance` Z_g to its epsilon. Z_g = 1 absorbs every wave and
    keeps the load. If one of them is infinite, the face moves with the drive.
    """

    stiffness: float
    impedance: float

    def termination(self, epsilon: float, round_trip: float, outermost: float) -> Termination:
        """As `Face`."""
        return Termination(self.stiffness * epsilon / round_trip, self.impedance * epsilon)


@dataclass(frozen=True)
class MachineFace(Face):
    """A grip with a mass on the slab's face: `mass` is relative to epsilon * round_trip, twice the slab's own mass."""

    is_own = True
    stiffness: float
    impedance: float
    mass: float

    def termination(self, epsilon: float, round_trip: float, outermost: float) -> Termination:
        """As `Face`."""
        return Termination(self.stiffness * epsilon / round_trip, self.impedance * epsilon, self.mass * epsilon * round_trip)


@dataclass(frozen=True)
class ReflectingFace(Face):
    """A bare reflection coefficient R in [-1, 1] between drive and slab: R = 1 is rigid, R = 0 absorbs waves *and* load."""

    coefficient: float

    def termination(self, epsilon: float, round_trip: float, outermost: float) -> Termination:
        """As `Face`: a dashpot (1 + R)/(1 - R) times the impedance behind it."""
        lost = 1.0 - self.coefficient
        return Termination(0.0, outermost * (1.0 + self.coefficient) / lost if lost > 0.0 else math.inf)


FACES: dict[str, type[Face]] = {
    "rigid": RigidFace,
    "grip": GripFace,
    "machine": MachineFace,
    "reflection": ReflectingFace,
}
"""The kinds of face by their names in scene files; a kind's fields are its keys there."""


@dataclass(frozen=True)
class Rheology:
    """A solid as numbers: G(s)/G = (1 + retardation s)/((1 + relaxation s)(1 + ratio)) with the unrelaxed modulus G; times are in
    L/V*. All are 0 if it is elastic. `ratio`: the relaxing modulus over the lasting one. Raises SceneError for a negative number,
    and unless G(s) is that of a Kelvin-Voigt solid (relaxation and ratio 0) or tends to G for fast waves, as that of a standard
    linear solid: others have no full wave."""

    retardation: float = 0.0
    relaxation: float = 0.0
    ratio: float = 0.0

    def __post_init__(self) -> None:
        if not all(number >= 0.0 for number in vars(self).values()):
            raise SceneError(f"{self}: must be 0 or more")  # else the slab would feed its waves
        if self.relaxation == self.ratio == 0.0:
            return
        retarded = self.relaxation * (1.0 + self.ratio)
        if not (self.relaxation > 0.0 and math.isclose(self.retardation, retarded, rel_tol=1e-9)):
            raise SceneError(
                f"{self}: the retardation must be relaxation * (1 + ratio), or relaxation and ratio 0; with a ratio, the "
                "relaxation must be above 0"
            )

    @property
    def is_elastic(self) -> bool:
        """Whether the modulus is G at every frequency."""
        return self.ratio == 0.0 and self.retardation == self.relaxation

    @property
    def blocks_fast_waves(self) -> bool:
        """Whether the modulus grows without bound with the frequency."""
        return self.retardation > 0.0 and self.relaxation == 0.0

    @property
    def creep_rate(self) -> float:
        """Rate, in 1/(L/V*), at which strain relaxes under constant stress: minus a zero of the modulus; infinite if elastic."""
        time = self.retardation
        return 1.0 / time if time > 0.0 else math.inf

    def modulus(self, s: Any) -> Any:
        """G(s)/G; `s` in 1/(L/V*): a complex number, an array, or anything that adds and divides as these."""
        return (1.0 + s * self.retardation) / ((1.0 + s * self.relaxation) * (1.0 + self.ratio))


@dataclass(frozen=True)
class KelvinVoigtViscosity:
    """sigma = G (gamma + time * gamma'), `time` in L/V*."""

    time: float

    @property
    def rheology(self) -> Rheology:
        """The solid as numbers."""
        return Rheology(retardation=self.time)


@dataclass(frozen=True)
class StandardLinearViscosity:
    """Zener solid: unrelaxed modulus G (so waves keep their speed at high frequency), relaxed modulus G / (1 + ratio),
    stress relaxation over `time` (in L/V*)."""

    time: float
    ratio: float

    @property
    def rheology(self) -> Rheology:
        """The solid as numbers."""
        return Rheology(self.time * (1.0 + self.ratio), self.time, self.ratio)


Viscosity: TypeAlias = KelvinVoigtViscosity | StandardLinearViscosity

VISCOSITIES: dict[str, Callable[..., Viscosity]] = {
    "kelvin-voigt": KelvinVoigtViscosity,
    "standard-linear": StandardLinearViscosity,
}
"""The kinds of viscosity by their names in scene files; a kind's fields are its keys there."""


@dataclass(frozen=True)
class Material:
    """Density in kg/m3 and shear modulus in Pa of a slab; not used by solvers."""

    density: float
    shear_modulus: float

    @property
    def wave_speed(self) -> float:
        """Speed of shear waves in m/s, c = sqrt(G/rho)."""
        return math.sqrt(self.shear_modulus / self.density)


@dataclass(frozen=True)
class Layer:
    """A sublayer: its share of the slab's round trip and its impedance relative to the slab's epsilon. Layers run from the
    interface outwards."""

    fraction: float
    impedance: float


@dataclass(frozen=True)
class Slab:
    """A slab of impedance `epsilon` and round trip `round_trip` (15), homogeneous and elastic by default.

    `material`: set if the scene states it in SI; `epsilon` and `round_trip` follow from it.
    """

    epsilon: float
    round_trip: float
    face: Face = field(default_factory=RigidFace)
    viscosity: Viscosity | None = None
    layers: tuple[Layer, ...] = (Layer(1.0, 1.0),)
    material: Material | None = field(default=None, compare=False, repr=False)

    def __post_init__(self) -> None:
        # slabs that differ only in the kind of a rigid face, or in a viscosity of no effect, are alike, also those made by
        # `replace`: nothing else sees them all
        if self.rheology.is_elastic:
            object.__setattr__(self, "viscosity", None)
        if self.termination.is_rigid:
            object.__setattr__(self, "face", RigidFace())
            return
        unit = vars(self.face.termination(1.0, 1.0, self.layers[-1].impedance)).values()
        scaled = [number * size for number, size in zip(unit, face_sizes(self.epsilon, self.round_trip).values(), strict=True)]
        if not all(map(math.isclose, vars(self.termination).values(), scaled)):
            raise SceneError(
                f"{self.face}: its spring must be proportional to epsilon/round_trip, its dashpot to epsilon and its mass to "
                "epsilon * round_trip"
            )

    @property
    def termination(self) -> Termination:
        """The outer face as numbers, time in L/V*."""
        return self.face.termination(self.epsilon, self.round_trip, self.epsilon * self.layers[-1].impedance)

    @property
    def rheology(self) -> Rheology:
        """The material as numbers, times in L/V*."""
        return self.viscosity.rheology if self.viscosity else Rheology()

    @property
    def interface_impedance(self) -> float:
        """Impedance of the layer at the interface, which resists fast changes of velocity."""
        return self.epsilon * self.layers[0].impedance

    @property
    def compliance(self) -> float:
        """Quasi-static displacement per stress: the sum of round_trip fraction / (2 impedance) over the layers (a standard linear
        solid is relaxed), plus that of the spring at the outer face."""
        softer = 1.0 + self.rheology.ratio
        layers = softer * sum(layer.fraction * self.round_trip / (2.0 * self.epsilon * layer.impedance) for layer in self.layers)
        spring = self.termination.spring
        return layers + (1.0 / spring if spring > 0.0 else 0.0)

    def reflection(self, s: Any) -> Any:
        """R(s) = (Z_f - Z)/(Z_f + Z), by which the outer face sends back the velocity of a wave: 1 from a rigid face. Z_f is
        mass s + dashpot + spring/s, Z that of the outermost layer. `s` in 1/(L/V*), not 0: a complex number or an array."""
        held, behind = self.termination, self.epsilon * self.layers[-1].impedance * self.rheology.modulus(s) ** 0.5
        if held.is_rigid:
            return 1.0 + 0.0 * behind
        face = s * held.mass + held.dashpot + held.spring / s
        return (face - behind) / (face + behind)

    @property
    def fast_reflection(self) -> float:
        """R of waves of endless frequency: 1 from a mass; -1 without one if viscosity makes them endlessly stiff."""
        held, behind = self.termination, self.epsilon * self.layers[-1].impedance
        if held.is_rigid or held.mass > 0.0:
            return 1.0
        return -1.0 if self.rheology.blocks_fast_waves else (held.dashpot - behind) / (held.dashpot + behind)

    @property
    def is_plain(self) -> bool:
        """Whether it is homogeneous, elastic and driven through a rigid face."""
        return self.termination.is_rigid and self.viscosity is None and len(self.layers) == 1
