"""The critical r, epsilon and V at which steady sliding loses stability, for any scene under any model.

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
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from reduced.impedance import Jet, Ratio
from reduced.parameters import scaled
from reduced.stability.characteristic import Characteristic, characteristic
from reduced.stability.crossing import between
from reduced.stability.friction import FrictionSlopes, friction_slopes
from reduced.stability.spectrum import leading_roots, unstable_count
from slipwave.errors import NumericsError
from slipwave.scene import Scene

Real: TypeAlias = NDArray[np.float64]
_THETA = np.unique(np.concatenate([np.geomspace(1e-9, 1.0, 1200), np.linspace(1.0, 60.0, 6000)]))
FIRST_OCTAVE, LAST_OCTAVE = -20, 10
"""Powers of two of the factors among which critical ones are sought."""

_FIRST_STEP = 0.125
_TRIED, _HALVINGS, _SMALL = 3, 60, 1e-6
_BESIDE = (1e-6, 1e-4, 1e-2)
"""Relative distances from a critical value at which roots are counted; a larger one if all of them are neutral at the smaller."""


def critical_round_trip(scene: Scene, model: str = "delay") -> tuple[float, float]:
    """(r_c, omega): the upper slab's round trip at which steady sliding first loses stability as both round trips grow from 0,
    and the frequency there; (nan, nan) if it never does. Friction clock. No root grows just below, and one does just above.

    Raises NumericsError if it is not found.
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

        for found in _by_angle(problem):
            if _is_lost(with_round_trip, found[0]):
                return found
    start = critical_round_trip(scene)[0] / scene.transit if model.startswith("fitted") else 2.0**FIRST_OCTAVE
    factor, omega = critical_factor(at, model, start) if math.isfinite(start) else (math.nan, math.nan)
    return scene.transit * factor, omega


def _is_lost(problem_at: Callable[[float], Characteristic], value: float, rising: bool = True) -> bool:
    """Whether roots begin to grow at this value of a parameter that rises, or falls: none does before it, by a count."""
    for aside in _BESIDE:
        before, after = (unstable_count(problem_at(value * (1.0 + (aside if rising else -aside) * way))) for way in (-1.0, 1.0))
        if before > 0 or after > 0:
            return before == 0
    return False


def _by_angle(problem: Characteristic) -> list[tuple[float, float]]:
    """Every (r, omega), in the order of r, at which a root crosses the imaginary axis with a phase omega r up to 60."""
    slopes = problem.slopes

    def zeta(theta: Real) -> NDArray[np.complex128]:
        """Z at the phase theta = omega * transit."""
        p, q = problem.one_port(Jet.variable(1j * np.asarray(theta) / problem.transit))
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(q.value / p.value)

    def excess(theta: Real) -> Real:
        """Reactance of friction and slabs together: zero at a crossing."""
        z = zeta(theta)
        return _reactance(slopes, _omega(slopes, z)) + z.imag

    values = excess(_THETA)
    theta = _sign_changes(excess, _THETA, values)
    omega, error, scale = _omega(slopes, zeta(theta)), excess(theta), np.interp(theta, _THETA, np.abs(values))
    crossing = np.isfinite(omega) & (np.abs(error) <= _SMALL * scale)  # not where it is infinite
    return sorted(zip((theta / omega)[crossing].tolist(), omega[crossing].tolist(), strict=True))


def _sign_changes(function: Callable[[Real], Real], grid: Real, values: Real) -> Real:
    """Where `function`, with these `values` on a rising `grid`, changes its sign: all brackets are halved together."""
    first = np.flatnonzero(values[:-1] * values[1:] <= 0.0)
    low, high, sign = grid[first], grid[first + 1], np.sign(values[first])
    for _ in range(_HALVINGS if first.size else 0):
        middle = 0.5 * (low + high)
        same = np.sign(function(middle)) == sign
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return np.asarray(0.5 * (low + high))


def _omega(slopes: FrictionSlopes, zeta: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Frequency at which Re H = -Re zeta; nan where the slab dissipates too much."""
    with np.errstate(invalid="ignore"):
        return np.asarray(slopes.healing * np.sqrt(-(slopes.steady + zeta.real) / (slopes.direct + zeta.real)))


def _reactance(slopes: FrictionSlopes, omega: NDArray[np.float64]) -> NDArray[np.float64]:
    """Im H(i omega)."""
    return omega * slopes.healing * (slopes.direct - slopes.steady) / (omega**2 + slopes.healing**2)


def critical_factor(at: Callable[[float], Scene], model: str, start: float = 1.0) -> tuple[float, float]:
    """(factor, omega): the factor next to `start` at which steady sliding of the scene `at(factor)` loses stability, and the
    frequency there: above `start` if it is stable there, below if not. (nan, nan) if there is none from 2^-20 to 2^10.

    Steps of an eighth to one octave are counted until the stability changes; the bracket is halved, and the root that crosses is
    followed through it. No root grows just below the result, and one does just above.
    """

    def problem(exponent: float) -> Characteristic:
        """The characteristic function for the factor 2^exponent."""
        return characteristic(at(2.0**exponent), model)

    def unstable(exponent: float) -> bool:
        """Whether a root lies in the right half plane for this exponent."""
        return unstable_count(problem(exponent)) > 0

    last, step = math.log2(start), _FIRST_STEP
    began = unstable(last)
    while True:
        here = last - step if began else last + step
        if not FIRST_OCTAVE <= here <= LAST_OCTAVE:
            return math.nan, math.nan
        if unstable(here) != began:
            break
        last, step = here, min(2.0 * step, 1.0)
    low, high = min(last, here), max(last, here)
    for width in (1.0, 1e-4):
        low, high = _halved(unstable, low, high, width)
        try:
            exponent, omega = between(problem, low, high)
        except NumericsError:  # no single root can be followed from one end to the other
            continue
        if _is_lost(lambda factor: problem(math.log2(factor)), 2.0**exponent):
            return 2.0**exponent, omega
    _, high = _halved(unstable, low, high, 1e-12 * max(1.0, abs(low)))
    return 2.0**high, abs(float(leading_roots(problem(high), 1)[0].imag))


def _halved(unstable: Callable[[float], bool], low: float, high: float, width: float) -> tuple[float, float]:
    """The bracket of a change to `unstable`, halved until it is no wider than `width`."""
    while high - low > width:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if unstable(middle) else (middle, high)
    return low, high


def critical_epsilon(scene: Scene, model: str = "delay") -> float:
    """The upper slab's epsilon above which steady sliding is stable at the scene's r (40), (28); nan if there is none.

    Z is proportional to epsilon, so a crossing at i omega requires a real positive epsilon_c/epsilon = -H/Z; the largest one
    counts that has growing roots just below and none just above. Roots can cross only at omega <= omega_c, because the slab is
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
    largest = next((size for size in sizes[first : first + _TRIED] if _is_lost(multiplied, size, rising=False)), math.nan)
    return scene.upper.epsilon * largest


def _enters(problem: Characteristic, size: float, omega: float) -> bool:
    """Whether i omega moves into the right half plane as a multiple of Z falls through `size`: from D + dD = 0."""
    s = Jet.variable(1j * omega)
    (p, q), (n, d) = problem.one_port(s), problem.slopes.ratio(s)
    return bool((d.value * q.value / (n * p + d * q * size).slope).real >= 0.0)


def _balances(problem: Characteristic) -> list[tuple[float, float]]:
    """(-H/Z, omega) wherever that is real on the imaginary axis up to omega_c."""
    slopes = problem.slopes

    def balance(omega: float | Real) -> NDArray[np.complex128]:
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


def critical_velocity(scene: Scene, model: str = "delay", decades: float = 6.0, per_decade: int = 4) -> float:
    """The velocity (V*), nearest to the scene's, at which the scene's round trip is critical; nan if none within `decades`."""
    from scipy.optimize import brentq

    def margin(exponent: float) -> float:
        """ln(r_c / r) at V = 10^exponent."""
        r_c, _ = critical_round_trip(scaled(scene, velocity=10.0**exponent), model)
        return math.log(r_c / scene.transit) if math.isfinite(r_c) else math.inf

    here = math.log10(scene.velocity)
    start = margin(here)
    critical = []
    for direction in (1.0, -1.0):
        last, last_margin = here, start
        for k in range(1, round(decades * per_decade) + 1):
            exponent = here + direction * k / per_decade
            value = margin(exponent)
            if math.isfinite(value) and math.isfinite(last_margin) and (value > 0.0) != (last_margin > 0.0):
                critical.append(brentq(margin, min(last, exponent), max(last, exponent), rtol=1e-14))
                break
            last, last_margin = exponent, value
    return 10.0 ** min(critical, key=lambda x: abs(x - here)) if critical else math.nan
