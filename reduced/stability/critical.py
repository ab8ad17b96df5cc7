"""The critical r and epsilon at which steady sliding loses stability, for any scene under any model.

"r" scales both round trips together, "epsilon" both impedances; ratios between the slabs and a grip's relative stiffness stay.
For slabs without viscosity Z depends only on theta = omega r, so a crossing requires, with zeta(theta) = Z at s = i theta/r,

    omega^2(theta) = -G_phi^2 (F_ss' + Re zeta)/(F_v + Re zeta),     Im H(i omega) + Im zeta = 0,

one scalar equation in theta; for lossless slabs omega = omega_c (20), (38). The times of viscous slabs do not scale with r; there
the first crossing is bracketed by counting unstable roots.
"""

import math
from bisect import bisect_left
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from reduced.impedance import Jet, Ratio
from reduced.parameters import scaled
from reduced.stability.characteristic import Characteristic, characteristic
from reduced.stability.crossing import FIRST_OCTAVE, critical_factor, is_lost
from reduced.stability.spectrum import unstable_count
from slipwave.friction.law import FrictionSlopes, friction_slopes
from slipwave.observe.pieces import Array
from slipwave.scene import Scene

_THETA = np.unique(np.concatenate([np.geomspace(1e-9, 1.0, 1200), np.linspace(1.0, 60.0, 6000)]))
_TRIED, _HALVINGS, _SMALL = 3, 60, 1e-6  # balances that may be the onset; bisections; relative residual of a zero


def critical_round_trip(scene: Scene, model: str = "delay") -> tuple[float, float]:
    """(r_c, omega): the upper slab's round trip at which steady sliding first loses stability as both round trips grow from 0,
    and the frequency there; (nan, nan) if it never does. Friction clock. No root grows just below, and one does just above.

    Raises NumericsError if it cannot be located.
    """
    if not friction_slopes(scene.law, scene.velocity).weakening:
        return math.nan, math.nan

    def at(factor: float) -> Scene:
        """The scene with both round trips multiplied."""
        return scaled(scene, round_trip=factor)

    if not (scene.upper.viscosity or scene.lower.viscosity):
        problem = characteristic(scene, model)

        def with_round_trip(r: float) -> Characteristic:
            """Z depends on s r alone."""
            factor = r / scene.transit
            return replace(problem, scene=at(factor), one_port=lambda s: problem.one_port(s * factor), transit=r)

        for crossing in _by_angle(problem):
            if is_lost(with_round_trip, crossing[0]):
                return crossing
    reduction = characteristic(scene, model).reduction
    is_fitted = reduction is not None and reduction.is_fitted
    start = critical_round_trip(scene)[0] / scene.transit if is_fitted else 2.0**FIRST_OCTAVE
    factor, omega = critical_factor(at, model, start) if math.isfinite(start) else (math.nan, math.nan)
    return scene.transit * factor, omega


def _by_angle(problem: Characteristic) -> list[tuple[float, float]]:
    """Every (r, omega), in the order of r, at which a root crosses the imaginary axis with a phase omega r up to 60."""
    slopes = problem.slopes

    def zeta(theta: Array) -> NDArray[np.complex128]:
        """Z at the phase theta = omega * transit."""
        p, q = problem.one_port(Jet.variable(1j * np.asarray(theta) / problem.transit))
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(q.value / p.value)

    def excess(theta: Array) -> Array:
        """Reactance of friction and slabs together: zero at a crossing."""
        z = zeta(theta)
        omega = _omega(slopes, z)
        of_friction = omega * slopes.healing * (slopes.direct - slopes.steady) / (omega**2 + slopes.healing**2)
        return of_friction + z.imag

    values = excess(_THETA)
    theta = _sign_changes(excess, _THETA, values)
    omega, error, scale = _omega(slopes, zeta(theta)), excess(theta), np.interp(theta, _THETA, np.abs(values))
    crossing = np.isfinite(omega) & (omega > 0.0) & (np.abs(error) <= _SMALL * scale)  # not where it is infinite
    theta, omega = theta[crossing], omega[crossing]
    return sorted(zip((theta / omega).tolist(), omega.tolist(), strict=True))


def _sign_changes(function: Callable[[Array], Array], grid: Array, values: Array) -> Array:
    """Zeros of `function`, with `values` on a rising `grid`, at its sign changes; all brackets are halved together."""
    first = np.flatnonzero(values[:-1] * values[1:] <= 0.0)
    low, high, sign = grid[first], grid[first + 1], np.sign(values[first])
    for _ in range(_HALVINGS if first.size else 0):
        middle = 0.5 * (low + high)
        same = np.sign(function(middle)) == sign
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return np.asarray(0.5 * (low + high))


def _omega(slopes: FrictionSlopes, zeta: NDArray[np.complex128]) -> Array:
    """Frequency at which Re H = -Re zeta; nan where the slab dissipates too much."""
    with np.errstate(invalid="ignore"):
        return np.asarray(slopes.healing * np.sqrt(-(slopes.steady + zeta.real) / (slopes.direct + zeta.real)))


def critical_epsilon(scene: Scene, model: str = "delay") -> float:
    """The upper slab's epsilon above which steady sliding is stable at the scene's r (40), (28); nan if there is none.

    Z is proportional to epsilon, so a crossing at i omega requires a real positive epsilon_c/epsilon = -H/Z; the result is the
    largest with growing roots just below and none just above. Roots can cross only at omega <= omega_c, because the slab is
    passive and so Re H <= 0; they cross at 0 only without a spring.
    """
    slopes = friction_slopes(scene.law, scene.velocity)
    if not slopes.weakening:
        return math.nan
    problem = characteristic(scene, model)

    def multiplied(factor: float) -> Characteristic:
        """With both epsilons multiplied."""

        def one_port(s: Jet) -> Ratio:
            p, q = problem.one_port(s)
            return p, q * factor

        return replace(problem, one_port=one_port)

    sizes = [size for size, omega in sorted(_balances(problem), reverse=True) if size > 0.0 and _enters(problem, size, omega)]
    below = [math.sqrt(size * lower) for size, lower in zip(sizes, [*sizes[1:], 0.25 * sizes[-1]], strict=True)] if sizes else []
    first = bisect_left(below, True, key=lambda size: unstable_count(multiplied(size)) > 0)
    largest = next((size for size in sizes[first : first + _TRIED] if is_lost(multiplied, size, rising=False)), math.nan)
    return scene.upper.epsilon * largest


def _enters(problem: Characteristic, size: float, omega: float) -> bool:
    """Whether i omega moves into the right half plane as a multiple of Z falls through `size`: from D + dD = 0."""
    s = Jet.variable(1j * omega)
    (p, q), (n, d) = problem.one_port(s), problem.friction(s)
    return bool((d.value * q.value / (n * p + d * q * size).slope).real >= 0.0)


def _balances(problem: Characteristic) -> list[tuple[float, float]]:
    """(-H/Z, omega) wherever that is real on the imaginary axis up to omega_c."""
    slopes = problem.slopes

    def balance(omega: float | Array) -> NDArray[np.complex128]:
        """Ratio of friction impedance to slab impedance."""
        p, q = problem.one_port(Jet.variable(1j * np.asarray(omega)))
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(-slopes.impedance_at(omega) * p.value / q.value)

    at_critical = complex(balance(slopes.omega_c))
    if abs(at_critical.imag) < 1e-9 * abs(at_critical):
        return [(at_critical.real, slopes.omega_c)]
    waves = int(min(slopes.omega_c * problem.longest, 1e4))
    grid = slopes.omega_c * np.concatenate([np.geomspace(1e-9, 1e-3, 1201)[:-1], np.linspace(1e-3, 1.0, 1001 + 20 * waves)])
    crossings = np.append(0.0, _sign_changes(lambda omega: balance(omega).imag, grid, balance(grid).imag))
    sizes = balance(crossings)
    real = np.abs(sizes.imag) < _SMALL * np.abs(sizes)  # not where it is infinite
    return list(zip(sizes.real[real].tolist(), crossings[real].tolist(), strict=True))
