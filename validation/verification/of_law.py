"""The rows of a friction law: derivatives, direct effect, steady state, evolution; growth of a small disturbance, and the delay
system against the leapfrog, both compiled for the law."""

import itertools
from typing import Any

import numpy as np
from numba.core.errors import NumbaError

from reduced.stability.analyse import analyse
from slipwave.errors import NumericsError
from slipwave.friction import LAWS
from slipwave.friction.check import LawError, derivative_error, sample_of
from slipwave.friction.law import steady_sliding
from slipwave.scene import Scene
from validation.measure.growth import measured_root, nudged
from validation.models.build import build
from validation.models.by_name import DELAY
from validation.report import EXACT, WITNESS, Verdict, Verdicts, claim, holding
from validation.verification.of_family import rows_on_scene

_RATES = np.logspace(-3.0, 4.0, 15)
_OFFSETS = (-2.0, -0.8, 0.0, 0.6, 2.0)
"""Rates (V*) and distances of psi from its steady value at which a law is tried."""
_SLOPES, _STEADY, _EVOLVED, _GROWTH = 1e-6, 1e-9, 1e-6, 1e-3
_STEP_OF_RATE, _TIMES = 10.0, 20.0  # a step of the rate, and how many relaxation times psi is given to follow it
_WITNESS = "fd"


def rows_of_law(name: str, scene: Scene) -> Verdicts:
    """The rows of the law `name`, on its own and in the `scene`, whose law it is."""
    law, sample = LAWS[name], scene.law
    yield from _rows_of_functions(name, law, sample_of(name, law))
    yield from _rows_of_functions(f"{name}, parameters of scene {scene.name}", law, sample)
    try:
        steady_sliding(sample, scene.velocity)
    except LawError as error:
        yield holding("It passes the check of registration at the scene’s V", EXACT, "no error", str(error), False, f"`{name}`")
        return
    refused = ""
    try:
        build("delay", scene).advance(0.1)
    except NumbaError as error:  # whose text holds the compiler's reason
        refused = next((line for line in str(error).splitlines() if "name" in line or "resolve" in line), type(error).__name__)
    yield holding("It compiles into the solvers", EXACT, "no error", refused or "no error", not refused, f"`{name}`")
    if refused:
        return
    yield _growth_row(name, scene)
    yield from rows_on_scene(_WITNESS, scene)


def _rows_of_functions(name: str, law: Any, sample: Any) -> Verdicts:
    """The functions alone, as plain Python."""
    points = [
        (law.unknown_of(sample, rate), law.steady_state(sample, rate) + off) for rate, off in itertools.product(_RATES, _OFFSETS)
    ]
    where = f"`{name}`, {len(points)} points, rates from {_RATES[0]:g} to {_RATES[-1]:g}"
    wrong = max(derivative_error(law, sample, z, psi) for z, psi in points)
    yield claim("Its derivatives are those of differences", EXACT, wrong, _SLOPES, f"{where}, relative")
    least = min(law.respond(sample, z, psi)[3] for z, psi in points)
    yield holding("Slip speeds up with the stress", EXACT, "F_z above 0", f"{least:.3g}", least > 0.0, where)
    still = max(abs(law.respond(sample, law.unknown_of(sample, v), law.steady_state(sample, v))[5]) / v for v in _RATES)
    yield claim("Nothing changes in steady sliding", EXACT, still, _STEADY, f"`{name}`, G over the rate")
    yield claim("The state follows a step of the rate to the new steady state", EXACT, _left_after_a_step(law, sample), _EVOLVED,
                f"`{name}`, psi {_TIMES:g} relaxation times after a tenfold step, by another integrator")  # fmt: skip


def _left_after_a_step(law: Any, sample: Any) -> float:
    """Distance of psi from its steady value long after tenfold steps of the rate, up and down, over the first distance."""
    from scipy.integrate import solve_ivp

    left = 0.0
    for before, after in ((1.0, _STEP_OF_RATE), (_STEP_OF_RATE, 1.0)):
        z, goal, start = law.unknown_of(sample, after), law.steady_state(sample, after), law.steady_state(sample, before)
        rate = abs(law.respond(sample, z, goal)[7])
        if not rate > 0.0:
            return np.inf
        solution = solve_ivp(_evolution, (0.0, _TIMES / rate), [start], args=(law, sample, z), rtol=1e-10, atol=1e-12)
        left = max(left, abs(float(solution.y[0, -1]) - goal) / (abs(start - goal) or 1.0))
    return left


def _evolution(_: float, psi: Any, law: Any, sample: Any, z: float) -> list[float]:
    """psi' at a held rate."""
    return [law.respond(sample, z, float(psi[0]))[5]]


def _growth_row(name: str, scene: Scene) -> Verdict:
    """Growth of a small disturbance of steady sliding in a run, compared with the root of the characteristic equation, which uses
    only the law's slopes."""
    title = "A small disturbance grows as the law’s slopes say"
    root = complex(analyse(scene, DELAY.name).leading_roots[0]) * scene.transit
    try:
        seen = measured_root(build("delay", nudged(scene, 1e-6), tolerance=1e-11))
    except (NumericsError, np.linalg.LinAlgError) as error:
        return holding(title, WITNESS, "a growth rate", str(error), False, f"`{name}`, scene {scene.name}")
    apart = abs(complex(seen.real, abs(seen.imag)) - complex(root.real, abs(root.imag))) / abs(root)
    return claim(
        title, WITNESS, apart, _GROWTH, f"`{name}`, scene {scene.name}; root {root:.4g} per transit, relative difference"
    )
