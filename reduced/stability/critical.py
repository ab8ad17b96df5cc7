"""The critical r, epsilon and V at which steady sliding loses stability, for any scene under any model.

"r" scales both round trips together, "epsilon" both impedances; ratios between the slabs and a grip's relative stiffness stay.
For slabs without viscosity Z depends only on theta = omega r, so a crossing requires, with zeta(theta) = Z at s = i theta/r,

    omega^2(theta) = -G_phi^2 (F_ss' + Re zeta)/(F_v + Re zeta),     Im H(i omega) + Im zeta = 0,

one scalar equation in theta; for lossless slabs omega = omega_c (20), (38). The times of viscous slabs do not scale with r; there
the first crossing is bracketed by counting unstable roots.
"""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from reduced.impedance import Jet, is_exact, ratio_of
from reduced.parameters import scaled
from reduced.stability.characteristic import Characteristic, characteristic
from reduced.stability.crossing import crossing
from reduced.stability.friction import FrictionSlopes, friction_slopes
from reduced.stability.spectrum import leading_roots, unstable_count
from slipwave.errors import NumericsError
from slipwave.scene import Scene

_THETA = np.unique(np.concatenate([np.geomspace(1e-9, 1.0, 1200), np.linspace(1.0, 60.0, 6000)]))
_FIRST_OCTAVE, _LAST_OCTAVE = -20, 10


def critical_round_trip(scene: Scene, model: str = "delay") -> tuple[float, float]:
    """(r_c, omega): the upper slab's round trip at which steady sliding first loses stability as both round trips grow from 0,
    and the frequency there; (nan, nan) if it never does. Friction clock."""
    slopes = friction_slopes(scene.law, scene.velocity)
    if not slopes.weakening:
        return math.nan, math.nan
    if scene.upper.viscosity or scene.lower.viscosity:
        factor, omega = critical_factor(lambda factor: scaled(scene, round_trip=factor), model)
        return scene.transit * factor, omega
    return _by_angle(scene, model, slopes)


def _by_angle(scene: Scene, model: str, slopes: FrictionSlopes) -> tuple[float, float]:
    from scipy.optimize import brentq

    one_port = ratio_of(scene, model)

    def zeta(theta: float | NDArray[np.float64]) -> NDArray[np.complex128]:
        """Z at the phase theta = omega * transit."""
        p, q = one_port(Jet.variable(1j * np.asarray(theta) / scene.transit))
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(q.value / p.value)

    def excess(theta: float | NDArray[np.float64]) -> NDArray[np.float64]:
        """Reactance of friction and slabs together: zero at a crossing."""
        z = zeta(theta)
        return _reactance(slopes, _omega(slopes, z)) + z.imag

    values = excess(_THETA)
    for i in np.flatnonzero((values[:-1] < 0.0) & (values[1:] >= 0.0)):
        theta = brentq(lambda x: float(excess(x)), _THETA[i], _THETA[i + 1], xtol=1e-300, rtol=4 * np.finfo(float).eps)
        omega = float(_omega(slopes, zeta(theta)))
        return theta / omega, omega
    return math.nan, math.nan


def _omega(slopes: FrictionSlopes, zeta: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Frequency at which Re H = -Re zeta; nan where the slab dissipates too much."""
    with np.errstate(invalid="ignore"):
        return np.asarray(slopes.healing * np.sqrt(-(slopes.steady + zeta.real) / (slopes.direct + zeta.real)))


def _reactance(slopes: FrictionSlopes, omega: NDArray[np.float64]) -> NDArray[np.float64]:
    """Im H(i omega)."""
    return omega * slopes.healing * (slopes.direct - slopes.steady) / (omega**2 + slopes.healing**2)


def critical_factor(at: Callable[[float], Scene], model: str) -> tuple[float, float]:
    """(factor, omega): the smallest factor at which steady sliding of the scene `at(factor)` loses stability, and the frequency
    there; (nan, nan) if there is none from 2^-20 to 2^10.

    Octaves are searched from small to large until a root is unstable, then bisected; the frequency is that of the crossing root.
    A reduction would need a new fit for every factor, so it starts from the result of the exact one-port instead.
    """

    def problem(exponent: float) -> Characteristic:
        """The characteristic function for the factor 2^exponent."""
        return characteristic(at(2.0**exponent), model)

    if not is_exact(model):
        exact, _ = critical_factor(at, "delay")
        return _refine(problem, math.log2(exact)) if exact > 0.0 else (math.nan, math.nan)

    def unstable(exponent: float) -> bool:
        """Whether a root lies in the right half plane for this exponent."""
        return unstable_count(problem(exponent)) > 0

    exponents = range(_FIRST_OCTAVE, _LAST_OCTAVE + 1)
    low = next((float(k - 1) for k in exponents if unstable(k)), math.nan)
    if math.isnan(low) or low < _FIRST_OCTAVE:
        return math.nan, math.nan
    low, high = _halved(unstable, low, low + 1.0, 1e-4)
    try:
        return _refine(problem, 0.5 * (low + high))
    except NumericsError:  # Newton's method fails at a shallow crossing, where counting still works
        _, high = _halved(unstable, low, high, 1e-12 * max(1.0, abs(low)))
        growing = leading_roots(problem(high), 1)
        return 2.0**high, abs(float(growing[0].imag))


def _halved(unstable: Callable[[float], bool], low: float, high: float, width: float) -> tuple[float, float]:
    """The bracket of a change to `unstable`, halved until it is no wider than `width`."""
    while high - low > width:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if unstable(middle) else (middle, high)
    return low, high


def _refine(problem: Callable[[float], Characteristic], start: float) -> tuple[float, float]:
    """Crossing (factor, omega) near exponent `start`: Newton on the imbalance, frequency guessed from a scan."""
    exponent, omega = crossing(problem, start)
    return 2.0**exponent, omega


def critical_epsilon(scene: Scene, model: str = "delay") -> float:
    """The upper slab's epsilon above which steady sliding is stable at the scene's r (40), (28); nan if there is none.

    Z is proportional to epsilon, so a crossing at i omega requires a real positive epsilon_c/epsilon = -H/Z; the largest one
    counts. Roots can cross only at omega <= omega_c, because the slab is passive and so Re H <= 0; they cross at 0 only without a
    spring.
    """
    slopes = friction_slopes(scene.law, scene.velocity)
    if not slopes.weakening:
        return math.nan
    from scipy.optimize import brentq

    one_port = ratio_of(scene, model)

    def balance(omega: float) -> complex:
        """Ratio of friction impedance to slab impedance."""
        p, q = one_port(Jet.variable(1j * omega))
        return complex(-slopes.impedance_at(omega) * p.value / q.value)

    at_critical = balance(slopes.omega_c)
    if abs(at_critical.imag) < 1e-9 * abs(at_critical):
        return scene.upper.epsilon * at_critical.real if at_critical.real > 0.0 else math.nan
    grid = slopes.omega_c * np.linspace(1e-3, 1.0, 1001)
    values = np.array([balance(omega) for omega in grid])
    change = np.flatnonzero(np.sign(values.imag[:-1]) != np.sign(values.imag[1:]))
    crossings = [brentq(lambda x: balance(x).imag, grid[i], grid[i + 1], rtol=1e-15) for i in change]
    sizes = [balance(omega).real for omega in (0.0, *crossings)]
    return scene.upper.epsilon * max((size for size in sizes if size > 0.0), default=math.nan)


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
