"""Numerical check of a friction law supplied from outside: a wrong derivative is refused before it can bend a result."""

import itertools
import math
from typing import Any

from scene.errors import SceneError

_RATES = (1e-2, 0.7, 3.0, 40.0, 900.0)
_STATE_OFFSETS = (-0.8, 0.0, 0.6)
_STEP = 1e-5
_TOLERANCE = 1e-6
_ROLES = ("v", "F", "G")


def check_law(name: str, law: Any, parameters: tuple[float, ...] = (0.4, 0.02, 0.03)) -> None:
    """Compare v_z, F_z, F_psi, G_z, G_psi with central differences and G(v, psi_ss(v)) with 0 over a grid of rates and states.

    `law` is a `Registered`; it is tried with the parameter class's own defaults, else with `parameters` (a_star, a, b).
    Raises SceneError naming the law, the wrong derivative and both values.
    """
    try:
        sample = law.parameters()
    except TypeError:
        sample = law.parameters(*parameters)
    for rate, offset in itertools.product(_RATES, _STATE_OFFSETS):
        z = law.unknown_of(sample, rate)
        _require(name, "rate_of(unknown_of(v))", law.rate_of(sample, z), rate)
        steady = law.steady_state(sample, rate)
        _require(name, "state rate G at psi = steady_state(v)", law.respond(sample, z, steady)[5], 0.0, scale=rate)
        _check_derivatives(name, law, sample, z, steady + offset)


def _check_derivatives(name: str, law: Any, sample: Any, z: float, psi: float) -> None:
    answer = law.respond(sample, z, psi)
    if answer[3] <= 0.0:
        raise SceneError(f"friction law {name!r}: F_z = {answer[3]:.6g} at z = {z:.6g}: must be > 0 (the direct effect)")
    by_z = _difference(law, sample, (z + _STEP, psi), (z - _STEP, psi))
    by_psi = _difference(law, sample, (z, psi + _STEP), (z, psi - _STEP))
    rate, friction, state_rate = 0, 2, 5
    scale = max(abs(answer[rate]), abs(answer[friction]), abs(answer[state_rate]), 1.0)
    for label, given, measured in (
        ("v_z", answer[1], by_z[rate]),
        ("F_z", answer[3], by_z[friction]),
        ("F_psi", answer[4], by_psi[friction]),
        ("G_z", answer[6], by_z[state_rate]),
        ("G_psi", answer[7], by_psi[state_rate]),
    ):
        _require(name, f"{label} at z = {z:.6g}, psi = {psi:.6g}", given, measured, scale=1e-3 * scale)


def _difference(law: Any, sample: Any, ahead: tuple[float, float], behind: tuple[float, float]) -> list[float]:
    forward, backward = law.respond(sample, *ahead), law.respond(sample, *behind)
    return [(f - b) / (2 * _STEP) for f, b in zip(forward, backward, strict=True)]


def _require(name: str, what: str, given: float, wanted: float, scale: float = 0.0) -> None:
    allowed = _TOLERANCE * max(abs(wanted), scale, 1e-3)
    if not math.isfinite(given) or abs(given - wanted) > max(allowed, 10 * _TOLERANCE * scale):
        raise SceneError(f"friction law {name!r}: {what} = {given:.10g}, but finite differences give {wanted:.10g}")
