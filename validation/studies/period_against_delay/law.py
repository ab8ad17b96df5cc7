"""The period of spring and block for thick slabs, r >> epsilon/(b V): an asymptotic law with the ageing law's logarithms.

The stress of loading rises by epsilon V in a transit, so T = dy/(epsilon V), with the elastic drop dy of an event.

* Stick: slip is below L, so phi = T r (friction clock). Weakening by slip, b v, overtakes loading, epsilon V/r, at
  v = epsilon V/(r b): friction then is a_* + a ln(epsilon V/(r b)) + b ln(T r), and the event begins.
* Slip: phi = 1/v after a slip of w = ln(T r v_max) memory lengths, over which friction falls by
  D = a ln(epsilon V/(r b)) + b ln(T r) + (b - a) ln v_max.
* A block of mass rho h/M loses no energy to waves and swings through: over the slip S = r dy/epsilon of an event loading and
  friction do the same work, so dy = 2 D (1 - w/(2 S)). Its fastest rate is v_max = (sqrt(M)/2) dy/epsilon.
"""

import math

from slipwave.scene import Scene

MASSES = {"block8": 8.0, "block12": 12.0}
"""M of each block."""

_ITERATIONS = 200
_CONVERGED = 1e-12


def period_of(scene: Scene, model: str) -> float:
    """The period (transits) of the block called `model`, for alike plain slabs and the ageing law; NaN where the law has none."""
    a, b = float(scene.law.a), float(scene.law.b)
    velocity, r, epsilon = scene.velocity, scene.transit, scene.upper.epsilon
    drop = 1.0
    for _ in range(_ITERATIONS):
        healed = drop / (epsilon * velocity) * r
        fastest = 0.5 * math.sqrt(MASSES[model]) * drop / epsilon
        if not healed * fastest > 1.0:
            break
        fall = a * math.log(epsilon * velocity / (r * b)) + b * math.log(healed) + (b - a) * math.log(fastest)
        new = 2.0 * fall * (1.0 - 0.5 * math.log(healed * fastest) / (r * drop / epsilon))
        if abs(new - drop) < _CONVERGED:
            return new / (epsilon * velocity)
        drop = new
    return math.nan
