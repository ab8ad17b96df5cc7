"""Stability of steady sliding in one scene under one model, dimensionless and in SI.

In SI it is the thickness of the slabs and the normal stress at which stability is lost. A normal stress multiplied by s divides
both epsilons by s. Round trips and the clock L/V* do not depend on it, and faces are relative to the slabs, so the critical one
is sigma epsilon/epsilon_c. Both thicknesses multiplied by s multiply both round trips by s. A face that is given in SI is
unchanged: relative to thicker slabs its spring is stiffer and its mass smaller.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

from reduced.impedance import is_exact
from reduced.parameters import thickened
from reduced.stability.characteristic import characteristic
from reduced.stability.critical import critical_epsilon, critical_round_trip
from reduced.stability.crossing import critical_factor
from reduced.stability.essential import essential_abscissa
from reduced.stability.spectrum import spectrum
from slipwave.errors import NumericsError, SceneError
from slipwave.friction.law import friction_slopes
from slipwave.scene import Scene

Value = TypeVar("Value")


@dataclass(frozen=True)
class Stability:
    """Friction clock: frequencies and roots in 1/(L/V*); nan for values that do not exist or, with a line in `missing`, were not
    found.

    `velocity` of the analysed steady sliding; `stable` is None if a root is neutral and none grows; `unstable_roots` certified.

    `omega_c` and `log10_r_c`: frequency and upper round trip at the first loss of stability as both round trips grow;
    `epsilon_c`: upper epsilon above which the scene's r is stable. `leading_roots`: those of `reduced.stability.leading_roots`,
    none if all decay faster than waves pass or a viscous slab creeps. `essential_abscissa` exists only for exact models.
    """

    model: str
    velocity: float
    stable: bool | None
    unstable_roots: int
    omega_c: float
    log10_r_c: float
    epsilon_c: float
    leading_roots: tuple[complex, ...]
    essential_abscissa: float
    missing: tuple[str, ...] = ()

    @property
    def rate(self) -> float:
        """Re s of the leading root, or that at which roots accumulate if none is listed; -inf without either."""
        if self.leading_roots:
            return self.leading_roots[0].real
        return -math.inf if math.isnan(self.essential_abscissa) else self.essential_abscissa

    @property
    def endless(self) -> bool:
        """Whether the roots that decay most slowly are infinitely many: those that accumulate at `essential_abscissa`, right of
        all `leading_roots`."""
        return self.essential_abscissa > max((root.real for root in self.leading_roots), default=-math.inf)


def analyse(scene: Scene, model: str = "delay") -> Stability:
    """Stability of steady sliding at the scene's drive velocity (at t = 0 if it changes). `taylor` is allowed too; it is unstable
    for any friction.

    Raises SceneError if the model cannot compute the scene, NumericsError if the roots that grow cannot be counted or located;
    other failures are listed in `missing`.
    """
    roots, is_active = spectrum(scene, model), characteristic(scene, model).is_active
    missing: list[str] = []
    nothing = math.nan, math.nan
    r_c, omega_c = (
        nothing if is_active else _value_or(nothing, "the critical r", lambda: critical_round_trip(scene, model), missing)
    )
    return Stability(
        model=model,
        velocity=scene.velocity,
        stable=roots.stable,
        unstable_roots=roots.growing,
        omega_c=omega_c,
        log10_r_c=math.log10(r_c) if r_c > 0.0 else math.nan,
        epsilon_c=math.nan
        if is_active
        else _value_or(math.nan, "the critical epsilon", lambda: critical_epsilon(scene, model), missing),
        leading_roots=roots.leading,
        essential_abscissa=_value_or(math.nan, "the limit of the fast roots", lambda: essential_abscissa(scene), missing)
        if is_exact(model)
        else math.nan,
        missing=tuple(missing),
    )


def _value_or(otherwise: Value, name: str, find: Callable[[], Value], missing: list[str]) -> Value:
    """Result of `find`; `otherwise`, with a line about `name` in `missing`, if it raises NumericsError, or SceneError for a scene
    on the way to it that the model cannot compute."""
    try:
        return find()
    except (NumericsError, SceneError) as error:
        missing.append(f"{name} was not found: {str(error).removeprefix('stability: ')}")
        return otherwise


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
    factor = _value_or(math.nan, "the critical thickness", lambda: _critical_factor(scene, stability), missing)
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


def _critical_factor(scene: Scene, stability: Stability) -> float:
    """Factor of both thicknesses at which steady sliding loses or regains stability."""
    if not (scene.upper.face.own or scene.lower.face.own):
        return float(10.0**stability.log10_r_c) / scene.transit
    if not friction_slopes(scene.law, scene.velocity).weakening:
        return math.nan
    return critical_factor(lambda factor: thickened(scene, factor), stability.model)[0]
