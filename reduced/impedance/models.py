"""Z(s) and Y(s) of a scene, exact or reduced, by model name. s is on the friction clock, in 1/(L/V*)."""

from collections.abc import Callable

import numpy as np

from reduced.families import DELAY
from reduced.impedance.reduce import analysed
from reduced.impedance.reduction import Reduction
from reduced.impedance.transmission_line import Complex, Jet, Ratio, pair_ratio
from slipwave.scene import Scene

_HIGHEST = 200.0  # radians per transit


def is_exact(model: str) -> bool:
    """Whether the one-port of `model` is the exact one."""
    return model == DELAY.name


def ratio_of(scene: Scene, model: str | Reduction = "delay") -> Callable[[Jet], Ratio]:
    """Function s -> (p, q) with Y = p/q and Z = q/p of a scene's slab pair under a model.

    `model` is any reduction, or a name: `delay`, or one of `analysed`, which raises SceneError.
    """
    if isinstance(model, str) and is_exact(model):
        return lambda s: pair_ratio(scene, s)
    reduced = analysed(scene, model) if isinstance(model, str) else model
    return lambda s: reduced.ratio(scene.upper.epsilon, scene.transit, s)


def impedance(scene: Scene, s_friction_clock: object, model: str = "delay") -> Complex:
    """Z(s) of the slab pair, delta_mu = -Z delta_v; s complex (array), 1/(L/V*); Z in units of (normal stress)/V*."""
    p, q = ratio_of(scene, model)(Jet.variable(s_friction_clock))
    return q.value / p.value


def check_passivity(scene: Scene, model: str = "delay") -> tuple[bool, float, complex]:
    """Whether Z is positive real, the smallest Re Z/|Z| and its place (1/transit): Re Z >= 0 on the imaginary axis up to 200
    radians per transit and in the right half plane, poles in the closed left half plane, and positive residues of poles on the
    axis. A reduction is also checked wherever its Re Z may change sign (`Reduction.sign_frequencies`)."""
    axis = np.concatenate([np.geomspace(1e-4, 1.0, 200), np.linspace(1.0, _HIGHEST, 4001)])
    s = np.concatenate([shift + 1j * axis for shift in (0.0, 1e-3, 0.1, 1.0, 10.0, 100.0)])
    bad = False
    if not is_exact(model):  # that is a chain of passive sections
        reduced = analysed(scene, model)
        s = np.append(s, 1j * np.maximum(reduced.sign_frequencies(), 1e-6))
        bad = not reduced.is_passive
    p, q = (jet.value for jet in ratio_of(scene, model)(Jet.variable(s / scene.transit)))
    real = (q * p.conj()).real / (np.abs(q) * np.abs(p) + 1e-300)  # relative to |Z|
    lowest = int(np.argmin(real))
    return bool(real[lowest] >= -1e-9 and not bad), float(real[lowest]), complex(s[lowest])
