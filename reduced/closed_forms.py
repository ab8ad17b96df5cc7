"""The paper's closed forms for alike plain slabs and any friction law; they check the computed stability.

Friction clock L/V* throughout; `slopes` are F_v, G_phi, F_ss' of the law at V, `epsilon` and r those of (15).
"""

import math

import numpy as np

from slipwave.friction.law import FrictionSlopes
from slipwave.observe.pieces import Array


def quasistatic_r(slopes: FrictionSlopes, epsilon: float) -> float:
    """r_* = -epsilon/(G_phi F_ss') (22)."""
    return -epsilon / (slopes.healing * slopes.steady)


def kelvin_voigt_r(slopes: FrictionSlopes, epsilon: float) -> float:
    """Critical r of the Kelvin-Voigt system in closed form (27), with theta = pi/2 - asin(cos theta) so that nothing cancels as
    r omega_c -> 0, and cos theta = (1 + 8/(r_* omega_c)^2)^(-3/2)."""
    r_star = quasistatic_r(slopes, epsilon)
    root = math.sqrt(1.0 + 8.0 / (r_star * slopes.omega_c) ** 2)
    return r_star - 2.0 * r_star * math.sin(math.asin(root**-3) / 3.0) * root


def kelvin_voigt_cubic(slopes: FrictionSlopes, epsilon: float) -> Array:
    """Coefficients (highest first) in x = r/r_* of r^3 - 3 r_* r^2 - (24/omega_c^2) r + (24/omega_c^2) r_* = 0 (21)."""
    k = 24.0 / (quasistatic_r(slopes, epsilon) * slopes.omega_c) ** 2
    return np.array([1.0, -3.0, -k, k])


def kelvin_voigt_quartic(slopes: FrictionSlopes, epsilon: float, r: float) -> Array:
    """Coefficients (highest first, in s) of r s [1 + (rs)^2/24](F_v s + G_phi F_ss') + eps [1 + (rs)^2/8](s + G_phi) = 0 (18)."""
    f_v, g, f_ss = slopes.direct, slopes.healing, slopes.steady
    return np.array(
        [
            r**3 * f_v / 24.0,
            r**3 * g * f_ss / 24.0 + epsilon * r**2 / 8.0,
            r * f_v + epsilon * g * r**2 / 8.0,
            r * g * f_ss + epsilon,
            epsilon * g,
        ]
    )


def kelvin_voigt_epsilon(slopes: FrictionSlopes, r: float) -> float:
    """Boundary eps_c(r) of the Kelvin-Voigt system (28); negative for sqrt 8 < r omega_c < sqrt 24, where there is none. Beyond
    sqrt 24 the second pair of roots crosses the imaginary axis."""
    square = slopes.omega_c**-2
    return -slopes.healing * slopes.steady * r * (r**2 - 24.0 * square) / (3.0 * (r**2 - 8.0 * square))


def delay_r(slopes: FrictionSlopes, epsilon: float) -> float:
    """Critical r of the delay system (39)."""
    omega = slopes.omega_c
    return 2.0 / omega * math.atan(0.5 * quasistatic_r(slopes, epsilon) * omega)


def delay_epsilon(slopes: FrictionSlopes, r: float) -> float:
    """Boundary eps_c(r) of the delay system (40); negative between its branches."""
    omega = slopes.omega_c
    return -slopes.healing * slopes.steady * math.tan(0.5 * r * omega) / (0.5 * omega)
