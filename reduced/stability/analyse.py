"""The results on the stability of steady sliding in one scene under one model."""

import math
from dataclasses import dataclass

import numpy as np

from reduced.impedance import is_exact
from reduced.stability.characteristic import characteristic
from reduced.stability.critical import critical_epsilon, critical_round_trip
from reduced.stability.essential import essential_abscissa
from reduced.stability.spectrum import leading_roots, unstable_count
from slipwave.scene import Scene

NEUTRAL = 1e-9
"""A root with |Re s| below this share of `FrictionSlopes.reach` is neutral: the certified count cannot decide its side."""


@dataclass(frozen=True)
class Stability:
    """Friction clock: frequencies and roots in 1/(L/V*); nan for values that do not exist.

    `velocity` of the analysed steady sliding; `stable` is None if the leading root is neutral and no other root grows.

    `omega_c` and `log10_r_c`: frequency and upper round trip at the first loss of stability as both round trips grow;
    `epsilon_c`: upper epsilon above which the scene's r is stable; `unstable_roots` is certified; `essential_abscissa` exists
    only for exact models (reductions have finitely many roots: nan).
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


def analyse(scene: Scene, model: str = "delay") -> Stability:
    """Stability of steady sliding at the scene's drive velocity (at t = 0 if it changes). `taylor` is allowed too; it is unstable
    for any friction.

    Raises SceneError if the model cannot compute the scene, NumericsError if a root cannot be located.
    """
    problem = characteristic(scene, model)
    unstable = unstable_count(problem, active=model == "taylor")
    leading = leading_roots(problem)
    neutral = int((np.abs(leading.real) <= NEUTRAL * problem.slopes.reach).sum())
    undecided = neutral > 0 and unstable <= neutral
    r_c, omega_c = critical_round_trip(scene, model) if model != "taylor" else (math.nan, math.nan)
    return Stability(
        model=model,
        velocity=scene.velocity,
        stable=None if undecided else unstable == 0,
        unstable_roots=0 if undecided else unstable,
        omega_c=omega_c,
        log10_r_c=math.log10(r_c) if r_c > 0.0 else math.nan,
        epsilon_c=critical_epsilon(scene, model) if model != "taylor" else math.nan,
        leading_roots=tuple(complex(root) for root in leading),
        essential_abscissa=essential_abscissa(scene) if is_exact(model) else math.nan,
    )
