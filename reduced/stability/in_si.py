"""Stability of steady sliding in SI: the thickness of the slabs and the normal stress at which it is lost.

A normal stress multiplied by s divides both epsilons by s. Round trips and the clock L/V* do not depend on it, and faces are
relative to the slabs, so the critical one is sigma epsilon/epsilon_c. Both thicknesses multiplied by s multiply both round trips
by s. A testing machine is unchanged: relative to thicker slabs its spring is stiffer and its mass smaller.
"""

import math
from dataclasses import dataclass, replace

from reduced.stability.analyse import Stability, value_or
from reduced.stability.crossing import critical_factor
from slipwave.friction.law import friction_slopes
from slipwave.scene import Scene
from slipwave.scene.slab import Slab


@dataclass(frozen=True)
class PhysicalStability:
    """NaN for values that do not exist or, with a line in `missing`, were not found.

    `thickness` (m) and `critical_thickness` (m) of the upper slab, both slabs scaled together; steady sliding is stable below.
    `critical_normal_stress` (Pa): stable below. The leading disturbance grows by a factor e in `growth_time` (s), or decays
    so in `decay_time` (s), and oscillates at `frequency` (Hz).
    """

    thickness: float
    critical_thickness: float
    critical_normal_stress: float
    growth_time: float
    decay_time: float
    frequency: float
    missing: tuple[str, ...] = ()


def stability_in_si(scene: Scene, stability: Stability) -> PhysicalStability | None:
    """Convert `stability`, the stability of `scene`, to SI; None for a scene without units."""
    units = scene.units
    if units is None:
        return None
    missing: list[str] = []
    factor = value_or(math.nan, "the critical thickness", lambda: _critical_factor(scene, stability), missing)
    time = units.time / abs(stability.rate) if stability.rate and stability.stable is not None else math.nan
    material = scene.upper.material
    thickness = 0.5 * scene.transit * units.time * material.wave_speed if material else math.nan
    return PhysicalStability(
        thickness=thickness,
        critical_thickness=thickness * factor,
        critical_normal_stress=units.normal_stress * scene.upper.epsilon / stability.epsilon_c,
        growth_time=time if stability.stable is False else math.nan,
        decay_time=time if stability.stable else math.nan,
        frequency=abs(stability.leading_roots[0].imag) / (2.0 * math.pi * units.time) if stability.leading_roots else math.nan,
        missing=tuple(missing),
    )


def thickened(scene: Scene, factor: float) -> Scene:
    """The scene with both slabs `factor` times as thick, of the same material, held by the same machines."""
    return replace(scene, upper=_thickened(scene.upper, factor), lower=_thickened(scene.lower, factor))


def _thickened(slab: Slab, factor: float) -> Slab:
    return replace(slab, round_trip=slab.round_trip * factor, face=slab.face.thickened(factor))


def _critical_factor(scene: Scene, stability: Stability) -> float:
    """Factor of both thicknesses at which steady sliding loses or regains stability."""
    if not any(slab.face.is_own for slab in scene.slabs):
        return float(10.0**stability.log10_r_c) / scene.transit
    if not friction_slopes(scene.law, scene.velocity).weakening:
        return math.nan
    return critical_factor(lambda factor: thickened(scene, factor), stability.model)[0]
