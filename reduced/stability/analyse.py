"""Stability of steady sliding in one scene under one model, dimensionless."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

from reduced.impedance import is_exact
from reduced.stability.characteristic import characteristic
from reduced.stability.critical import critical_epsilon, critical_round_trip
from reduced.stability.essential import essential_abscissa
from reduced.stability.spectrum import spectrum
from slipwave.errors import NumericsError
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
        nothing if is_active else value_or(nothing, "the critical r", lambda: critical_round_trip(scene, model), missing)
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
        else value_or(math.nan, "the critical epsilon", lambda: critical_epsilon(scene, model), missing),
        leading_roots=roots.leading,
        essential_abscissa=value_or(math.nan, "the limit of the fast roots", lambda: essential_abscissa(scene), missing)
        if is_exact(model)
        else math.nan,
        missing=tuple(missing),
    )


def value_or(otherwise: Value, name: str, find: Callable[[], Value], missing: list[str]) -> Value:
    """Result of `find`; `otherwise`, with a line about `name` in `missing`, if it raises NumericsError."""
    try:
        return find()
    except NumericsError as error:
        missing.append(f"{name} was not found: {str(error).removeprefix('stability: ')}")
        return otherwise
