"""What a scene leads to expect before it is run: whether steady sliding holds, how fast it is left or reached, and how long a
cycle takes.

The period is the longer of two. At the onset of stick-slip it is 2 pi/omega_c. Far beyond, it is the time D/(k V) in which the
drive restores, through the stiffness k, the stress D that an event releases. Friction falls by w = -V d mu_ss/dV for every e-fold
of the slip rate; the state heals during T = D/(k V), and the event slips at v = D/(2 Z), limited by radiation. Inertia doubles
the drop:

    D = 2 w ln(1 + T v),     solved by iteration.

It is right within a factor of two or so: it chooses how far to march before the first look at the motion.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

from slipwave.scene import Scene

_ROUNDS = 50


@dataclass(frozen=True)
class Outlook:
    """`rate`: at which a disturbance of steady sliding grows or (below 0) decays in the end, per transit; `period`: expected of
    a cycle, in transits. `stable` is None if it is unknown, because the rate is 0 within rounding or V ends at 0."""

    stable: bool | None
    rate: float
    period: float


@lru_cache(maxsize=32)
def outlook(scene: Scene, model: str) -> Outlook:
    """The outlook of `scene` at the velocity with which its drive ends; `model` is one with the one-port of the model that
    runs."""
    from reduced.stability import friction_slopes, scaled, spectrum

    velocity = scene.drive.velocities[-1]
    if velocity == 0.0:
        return Outlook(None, 0.0, math.inf)
    final = scaled(scene, velocity=velocity)
    slopes = friction_slopes(final.law, velocity)
    found = spectrum(final, model)
    onset = 2.0 * math.pi / (slopes.omega_c if slopes.weakening else slopes.healing)
    released = stress_released(final) if slopes.weakening else 0.0
    loading = final.stiffness * velocity
    return Outlook(
        stable=found.stable,
        rate=found.rate * scene.transit,
        period=max(onset / scene.transit, released / loading if loading else math.inf if released else 0.0),
    )


def stress_released(scene: Scene) -> float:
    """D, in normal stresses, of a scene with a constant drive and weakening friction; infinite if nothing loads it."""
    from reduced.stability import friction_slopes

    weakening = -scene.velocity * friction_slopes(scene.law, scene.velocity).steady
    loading = scene.stiffness * scene.velocity / scene.transit  # per L/V*
    if loading == 0.0:
        return math.inf
    drop = weakening
    for _ in range(_ROUNDS):
        if drop == 0.0:
            break
        slip = 2.0 * math.log(drop) - math.log(loading) - math.log(2.0 * scene.impedance)  # ln (T v), which may overflow
        drop = 2.0 * weakening * (slip + math.log1p(math.exp(-slip)) if slip > 0.0 else math.log1p(math.exp(slip)))
    return drop
