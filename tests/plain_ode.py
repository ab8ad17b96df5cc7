"""The paper's Kelvin-Voigt system as one would write it without this package: ten lines of Python, integrated by scipy's LSODA.

A competitor in run time and an independent check of the numbers: it shares no code with the solvers (law, integrator, event
detection).
"""

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from slipwave.scene import Scene
from slipwave.scene.drive import NUDGE_CENTRE

_APART = 10.0  # transits; crossings of V closer than this belong to the same slip event


def plain_kelvin_voigt(scene: Scene, until: float, tolerance: float) -> tuple[float, int]:
    """Period of the last complete cycle before `until` (transits), by `solve_ivp(method="LSODA")` at rtol = atol = `tolerance`,
    and the number of evaluations of the right-hand side.

    System (41) on the transit clock in y, w = mu', ln v and psi; ageing law; nudge start on steady sliding.
    """
    from scipy.integrate import solve_ivp

    rates = right_hand_side(scene)
    ln_v = math.log(scene.velocity)

    def crossing(t: float, state: np.ndarray) -> float:
        """ln v - ln V, zero where a slip event starts."""
        return float(state[2]) - ln_v

    crossing.direction = 1.0  # type: ignore[attr-defined]
    start = steady_start(scene)
    solve: Any = partial(solve_ivp, rates, (0.0, until), start, method="LSODA", rtol=tolerance, atol=tolerance)
    run = solve(events=crossing, max_step=3.0)
    times = np.asarray(run.t_events)[0]
    events = times[np.diff(times, prepend=-math.inf) > _APART]
    return float(events[-1] - events[-2]), int(run.nfev)


def steady_start(scene: Scene) -> list[float]:
    """Steady sliding at V in y, w, ln v, psi."""
    law, ln_v = scene.law, math.log(scene.velocity)
    return [law.a_star + (law.a - law.b) * ln_v, 0.0, ln_v, -ln_v]


def right_hand_side(scene: Scene) -> Callable[[float, np.ndarray], list[float]]:
    """Time derivative (41) of y, w, ln v, psi on the transit clock, with the scene's nudge."""
    law, epsilon, r, velocity = scene.law, scene.upper.epsilon, scene.transit, scene.velocity
    size = scene.start.nudge_size

    def rates(t: float, state: np.ndarray) -> list[float]:
        """At time t (transits)."""
        y, w, ln_v, psi = state
        v = math.exp(ln_v)
        psi_rate = r * (math.exp(-psi) - v) + size * math.exp(-((t - NUDGE_CENTRE) ** 2))
        ln_v_rate = (w - law.b * psi_rate) / law.a
        stress = law.a_star + law.a * ln_v + law.b * psi
        return [epsilon * (velocity - v), 24.0 * (y - stress) - 3.0 * epsilon * v * ln_v_rate, ln_v_rate, psi_rate]

    return rates
