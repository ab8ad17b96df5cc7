"""Simplified models of two plain slabs of any kind as one would write them by hand, left to scipy: a witness without our code.

Each slab i answers its own velocity w_i (deviation from steady sliding; v - V_0 = w_1 + w_2) with the stress q (deviation too)
that both have in common. With k_i = 2 eps_i/r_i, its quasi-static stiffness, W_i' = w_i, and the friction clock for all,

    quasidynamic   q = K (D - W) - Z (v - V),                 1/K = 1/k_1 + 1/k_2,   1/Z = 1/eps_1 + 1/eps_2
    block12, 8     q = K (D - W) - M v',   M/K^2 = sum of r_i^2/(N k_i), N = 12 or 8: both slabs' own masses in series, seen at
                   low frequency ((9) and (11) of the paper for alike slabs)
    kelvin-voigt   q + r_i^2 q''/24 = -k_i (W_i + r_i^2 W_i''/8) for either slab, W_i its shear                     (11), (14)

D' = V(t) - V_0 is the drive's, W = W_1 + W_2 (less D for kelvin-voigt, whose whole impedance answers v - V), and the ageing law
F = a_* + a ln v + b psi, psi' = e^-psi - v + nudge/r.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from slipwave.scene import Scene

DIVISOR_OF_MASS = {"block8": 8.0, "block12": 12.0}


def plain_pair(scene: Scene, model: str, times: list[float]) -> NDArray[np.float64]:
    """Rows ln v, psi, mu, y at `times` (transits of the upper slab), by LSODA from one kink of the drive to the next."""
    system = {"quasidynamic": _quasidynamic, "kelvin-voigt": _kelvin_voigt}.get(model, _block)
    pair = _Pair(scene)
    start, rates, read = system(pair, DIVISOR_OF_MASS.get(model, 0.0))
    knots = [t for t in scene.drive.times if 0.0 < t < times[-1]]
    state, now, rows = np.array(start), 0.0, {}
    for end in sorted({*knots, *times}):
        pair.enter(now)
        span = (now * scene.transit, end * scene.transit)
        run = solve_ivp(rates, span, state, method="LSODA", rtol=1e-11, atol=1e-13 * np.maximum(1.0, np.abs(state)))
        state, now = run.y[:, -1], end
        rows[end] = read(end * scene.transit, state)
    return np.array([rows[t] for t in times])


class _Pair:
    def __init__(self, scene: Scene) -> None:
        law, slabs = scene.law, (scene.upper, scene.lower)
        self.a_star, self.a, self.b = law.a_star, law.a, law.b
        self.epsilon = np.array([slab.epsilon for slab in slabs])
        self.r = np.array([slab.round_trip for slab in slabs])
        self.k = 2.0 * self.epsilon / self.r
        self.stiffness, self.radiation = 1.0 / np.sum(1.0 / self.k), 1.0 / np.sum(1.0 / self.epsilon)
        self.transit, self.nudge = self.r[0], scene.start.size
        self.knots, self.rates = np.array(scene.drive.times) * self.transit, np.array(scene.drive.velocities)
        self.v0 = self.rates[0]
        self.psi0 = -np.log(self.v0)
        self.mu0 = self.a_star + (self.a - self.b) * np.log(self.v0)

    def enter(self, time: float) -> None:
        """Take the drive's straight piece that begins at or before `time` (transits), so that no step meets a kink."""
        knots = np.append(self.knots, 2.0 * self.knots[-1] + 1.0)
        k = int(np.searchsorted(knots, time * self.transit * (1.0 + 1e-12), side="right")) - 1
        self.begin, self.level = knots[k], self.rates[k] - self.v0
        self.acceleration = (np.append(self.rates, self.rates[-1])[k + 1] - self.rates[k]) / (knots[k + 1] - knots[k])

    def drive(self, t: float) -> float:
        """V(t) - V_0."""
        return float(self.level + self.acceleration * (t - self.begin))

    def ln_v(self, q: float, psi: float) -> float:
        """ln v under the stress mu_0 + q."""
        return (self.mu0 + q - self.a_star - self.b * psi) / self.a

    def healing(self, t: float, psi: float, v: float) -> float:
        """psi'."""
        return np.exp(-psi) - v + self.nudge / self.transit * np.exp(-((t / self.transit - 6.0) ** 2))


def _quasidynamic(pair: _Pair, _: float) -> Any:
    def rate_of(t: float, load: float, psi: float) -> float:
        """ln v of  a ln v + Z v = load - b psi + ..., by Newton."""
        z = np.log(pair.v0)
        for _ in range(60):
            excess = (
                pair.a_star + pair.a * z + pair.b * psi - pair.mu0 - load + pair.radiation * (np.exp(z) - pair.v0 - pair.drive(t))
            )
            z -= excess / (pair.a + pair.radiation * np.exp(z))
        return z

    def rates(t: float, x: Any) -> list[float]:
        v = np.exp(rate_of(t, x[0], x[1]))
        return [pair.stiffness * (pair.v0 + pair.drive(t) - v), pair.healing(t, x[1], v)]

    def read(t: float, x: Any) -> list[float]:
        z = rate_of(t, x[0], x[1])
        return [z, x[1], pair.a_star + pair.a * z + pair.b * x[1], pair.mu0 + x[0]]

    return [0.0, pair.psi0], rates, read


def _block(pair: _Pair, n: float) -> Any:
    mass = pair.stiffness**2 * np.sum(pair.r**2 / (n * pair.k))

    def rates(t: float, x: Any) -> list[float]:
        load, z, psi = x
        q = pair.a_star + pair.a * z + pair.b * psi - pair.mu0
        v = np.exp(z)
        return [pair.stiffness * (pair.v0 + pair.drive(t) - v), (load - q) / (mass * v), pair.healing(t, psi, v)]

    def read(t: float, x: Any) -> list[float]:
        return [x[1], x[2], pair.a_star + pair.a * x[1] + pair.b * x[2], pair.mu0 + x[0]]

    return [0.0, np.log(pair.v0), pair.psi0], rates, read


def _kelvin_voigt(pair: _Pair, _: float) -> Any:
    """States W_1, W_2, w_1, q, r q' and psi. Adding both slabs' w_i' = -8 (q + r_i^2 q''/24)/(k_i r_i^2) - 8 W_i/r_i^2 to
    v' - V' with v' = v (q' - b psi')/a gives q''."""
    k, square = pair.k, pair.r**2 / 8.0

    def rates(t: float, x: Any) -> list[float]:
        one, two, w_one, q, q_rate, psi = x
        q_rate = q_rate / pair.transit
        v = np.exp(pair.ln_v(q, psi))
        psi_rate = pair.healing(t, psi, v)
        free = -(q / k + np.array([one, two])) / square
        apart = v * (q_rate - pair.b * psi_rate) / pair.a - pair.acceleration
        q_curve = 3.0 * pair.stiffness * (free.sum() - apart)
        bend = free[0] - q_curve / (3.0 * k[0])
        return [w_one, v - pair.v0 - pair.drive(t) - w_one, bend, q_rate, q_curve * pair.transit, psi_rate]

    def read(t: float, x: Any) -> list[float]:
        z = pair.ln_v(x[3], x[5])
        return [z, x[5], pair.mu0 + x[3], pair.mu0 - pair.stiffness * (x[0] + x[1])]

    return [0.0] * 5 + [pair.psi0], rates, read
