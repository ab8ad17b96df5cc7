"""The neutral (essential) spectrum: the abscissa at which the infinitely many fast roots of the exact system accumulate.

At high frequency friction is the constant impedance F_v (the state is frozen), and every slab a set of echoes. Roots then satisfy
D(E_1, E_2, ...) = 0 with E_j = exp(-s T_j); D is affine in the echo of each layer. For alike plain slabs Re s = -(1/r) ln |(2 F_v
+ epsilon)/(2 F_v - epsilon)|. If all T_j are multiples of one time, the equation is a polynomial. Otherwise the phases of the
echoes are independent, and the abscissa is the largest over all phases.
"""

import itertools
import math
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from reduced.commensurate import common_divisor
from slipwave.errors import NumericsError
from slipwave.friction.law import friction_slopes
from slipwave.scene import Scene
from slipwave.scene.slab import Slab

Echo: TypeAlias = NDArray[Any]
_MOST_PARTS, _HIGHEST_DEGREE, _MOST_TIMES = 200, 800, 12


def essential_abscissa(scene: Scene) -> float:
    """Re s (1/(L/V*)) of the rightmost accumulation of fast roots of the exact system; -inf if there is none (every wave is
    absorbed).

    Incommensurate travel times give the supremum over all phases of the echoes: exact for up to two of them, and in general over
    all combinations of signs. Kelvin-Voigt solids transmit no fast waves; their roots accumulate at -1/time instead.

    Raises NumericsError for more than 12 layers with incommensurate travel times.
    """
    slabs = scene.slabs
    accumulation = -min(slab.rheology.creep_rate for slab in slabs)
    if any(slab.rheology.blocks_fast_waves for slab in slabs):
        return accumulation
    times = [layer.fraction * slab.round_trip for slab in slabs for layer in slab.layers]
    grid = _common_grid(times)
    echoes = _polynomial(scene, slabs, times, grid) if grid else _over_all_signs(scene, slabs, times)
    return max(echoes, accumulation)


def fast_pattern(scene: Scene) -> float:
    """Im s (1/(L/V*)) after which the fast roots of the exact system repeat, nearly; 0 if their travel times are incommensurate,
    or no fast wave is transmitted."""
    slabs = scene.slabs
    if any(slab.rheology.blocks_fast_waves for slab in slabs):
        return 0.0
    grid = _common_grid([layer.fraction * slab.round_trip for slab in slabs for layer in slab.layers])
    return 2.0 * math.pi / grid[0] if grid else 0.0


def _fast_balance(scene: Scene, slabs: tuple[Slab, ...], echoes: list[Echo]) -> Echo:
    """F_v p + q of the chain of layers at high frequency; `echoes`: the factor e^(-s T_j) of every layer, upper slab first."""
    direct = friction_slopes(scene.law, scene.velocity).direct
    remaining = list(echoes)
    ports = []
    for slab in slabs:
        own, remaining = remaining[: len(slab.layers)], remaining[len(slab.layers) :]
        ports.append(_fast_ratio(slab, own))
    if len(ports) == 1:
        p, q = 2.0 * ports[0][0], ports[0][1]
    else:
        (p1, q1), (p2, q2) = ports
        p, q = p1 * q2 + p2 * q1, q1 * q2
    return direct * p + q


def _fast_ratio(slab: Slab, echoes: list[Echo]) -> tuple[Echo, Echo]:
    """(p, q) of a slab: `transmission_line.slab_ratio` for s -> infinity at given echoes. The outer face's spring is then
    negligible, and its mass does not move."""
    ones, held, solid = np.ones_like(echoes[0]), slab.termination, slab.rheology
    if held.is_rigid or held.mass > 0.0:
        p, q = 0.0 * ones, ones
    else:
        p, q = ones / slab.epsilon, ones * held.dashpot / slab.epsilon
    for layer, echo in zip(reversed(slab.layers), reversed(echoes), strict=True):
        admittance = 1.0 / (slab.epsilon * layer.impedance)
        if solid.relaxation > 0.0:  # attenuates a fast wave to the far side of a layer and back
            loss = solid.ratio / (1.0 + solid.ratio)
            echo = echo * math.exp(-0.5 * slab.round_trip * layer.fraction * loss / solid.relaxation)
        p, q = p * (1.0 + echo) + admittance * q * (1.0 - echo), q * (1.0 + echo) + p * (1.0 - echo) / admittance
    return p, q


def _idle(slabs: tuple[Slab, ...], echoes: list[Echo]) -> NDArray[np.bool_]:
    """True at roots of idle modes (`Characteristic.idle`)."""
    if len(slabs) == 1:
        return np.zeros(echoes[0].shape, dtype=bool)
    split = len(slabs[0].layers)
    small = []
    for slab, own in zip(slabs, (echoes[:split], echoes[split:]), strict=True):
        p, q = _fast_ratio(slab, own)
        small.append(np.abs(q) < 1e-7 * np.abs(p) * slab.epsilon)
    return np.logical_and(*small)


def _common_grid(times: list[float]) -> tuple[float, list[int]] | None:
    """(T, n_j) with T_j = n_j T, or None if the degree of the polynomial in exp(-s T) would be too high."""
    unit = common_divisor(np.array(times), _MOST_PARTS)
    multiples = [round(time / unit) for time in times] if unit else []
    return (unit, multiples) if unit and sum(multiples) <= _HIGHEST_DEGREE else None


def _polynomial(scene: Scene, slabs: tuple[Slab, ...], times: list[float], grid: tuple[float, list[int]]) -> float:
    """The abscissa -ln|E|/T of the smallest root of the polynomial in E = exp(-s T), sampled on the unit circle."""
    unit, multiples = grid
    degree = sum(multiples)
    circle = np.exp(2j * np.pi * np.arange(degree + 1) / (degree + 1))
    coefficients = (np.fft.fft(_fast_balance(scene, slabs, [np.asarray(circle**n) for n in multiples])) / (degree + 1)).real
    coefficients[np.abs(coefficients) < 1e-14 * np.abs(coefficients).max()] = 0.0
    roots = np.roots(np.trim_zeros(coefficients[::-1], "f"))
    roots = roots[~_idle(slabs, [roots**n for n in multiples])]
    return -math.log(np.abs(roots).min()) / unit if roots.size else -math.inf


def _over_all_signs(scene: Scene, slabs: tuple[Slab, ...], times: list[float]) -> float:
    """Largest sigma with F_v p + q = 0 for echoes +-exp(-sigma T_j). The balance is affine in each echo with real coefficients,
    so over the phase of any one echo its modulus is smallest at one of the signs. The result is 0 for unlike slabs behind rigid
    faces: nearly idle modes have arbitrarily small damping."""
    if len(times) > _MOST_TIMES:
        raise NumericsError(
            f"the travel times of {len(times)} layers have no common measure: at most {_MOST_TIMES} can be combined"
        )
    best = -math.inf
    scale = 1.0 / max(times)
    sigma = np.linspace(-40.0, 0.004, 40005) * scale
    for signs in itertools.product((1.0, -1.0), repeat=len(times)):
        echoes = [sign * np.exp(-sigma * time) + 0j for sign, time in zip(signs, times, strict=True)]
        balance = _fast_balance(scene, slabs, echoes).real
        change = np.flatnonzero(np.diff(np.sign(balance)) != 0)
        if change.size:
            i = change[-1]
            best = max(best, float(sigma[i] - balance[i] * (sigma[i + 1] - sigma[i]) / (balance[i + 1] - balance[i])))
    return best
