"""`fitted:N`: a passive rational fit of any scene's impedance with about N oscillators and two relaxations.

If the modes are known (elastic slabs behind rigid faces), it is modal:N. Otherwise the poles come from vector fitting of exact
samples on the imaginary axis, and the coefficients from least squares under Re Z >= 0. The spring is not fitted; it is the exact
quasi-static one. Passivity is certified on the whole axis, not on a grid (`of_reduction`). A fit that is not passive, or not
accurate at low frequency, is refused.
"""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from reduced.impedance.of_reduction import dissipation, reduction_ratio, sign_frequencies
from reduced.impedance.reduction import Reduction
from reduced.impedance.transmission_line import Complex, Jet, drive_ratio, pair_ratio
from reduced.impedance.vector_fit import fit_poles, partial_fractions, passive_coefficients
from slipwave.errors import SceneError
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from slipwave.threads import one_thread

WORST_ALLOWED = 0.05
"""Largest allowed error of Z below half the first mode, relative to |Z| + epsilon; a worse fit is refused."""

_EMPHASIS = 4
_FLOOR = 1e-7
"""Re Z/epsilon is kept above this on the grid of constraints, so that it stays above zero between the points."""
_ROUNDS = 8


@lru_cache(maxsize=32)
def fit_scene(scene: Scene, name: str, count: int, spring: float) -> Reduction:
    """Passive reduction with about `count` oscillators, fitted on 0 < omega < 2 pi (count + 1/2) per longer round trip.

    Raises SceneError if count is 0, or if the best passive fit is too far from the exact impedance.
    """
    if count == 0:
        raise SceneError(f"model = {name!r}: a fit needs at least one oscillator; the model without one is quasidynamic")
    longest = max(scene.upper.round_trip, scene.lower.round_trip) / scene.transit
    axis = np.concatenate([np.geomspace(1e-3, 0.3, 60), np.linspace(0.3, 2.0 * np.pi * (count + 0.5), 30 * count + 40)])
    s = 1j * axis / longest
    target = _exact_impedance(scene, s)
    start = np.asarray((2.0 * np.pi * np.arange(1, count + 1)) * (1j - 0.05) / longest, dtype=np.complex128)
    with one_thread(), np.errstate(divide="ignore", invalid="ignore"):  # at an undamped pole
        pairs, reals = fit_poles(s, target - spring / s, _weight(s, target), start, np.array([-0.3, -3.0]) / longest)
        fit = _passive(name, s, target, spring, pairs, reals)
    _require_accuracy(scene, fit, longest)
    return fit if scene.drive.is_constant else replace(fit, transfer=_transfer(scene, fit, s, start))


def _transfer(scene: Scene, fit: Reduction, s: Complex, start: Complex) -> Reduction:
    """The stress that the drive alone causes, with poles of its own: least squares over the same band."""
    p, n = drive_ratio(scene, Jet.variable(s / scene.transit))
    target = np.asarray(n.value / (p.value * scene.upper.epsilon)) - fit.spring / s
    weight = np.asarray(1.0 / (1.0 + np.abs(s)))
    with one_thread(), np.errstate(divide="ignore", invalid="ignore"):
        pairs, reals = fit_poles(s, target, weight, start, np.array([-0.3, -3.0]))
    rows = partial_fractions(s, pairs, reals) * weight[:, None]
    matrix, data = np.concatenate([rows.real, rows.imag]), np.concatenate([(target * weight).real, (target * weight).imag])
    scale = np.linalg.norm(matrix, axis=0)
    coefficients = np.linalg.lstsq(matrix / scale, data, rcond=None)[0] / scale
    return _reduction(fit.name, np.concatenate([[0.0, 0.0], coefficients]), pairs, reals, fit.spring)


def _reduction(name: str, x: Array, pairs: Complex, reals: Array, spring: float) -> Reduction:
    """The reduction with the coefficients of `_columns`."""
    strengths, residues, offsets = np.split(x[2:], [reals.size, reals.size + pairs.size])
    return Reduction(
        name,
        mass=max(float(x[0]), 0.0),
        damping=float(x[1]),
        frequencies=tuple(np.abs(pairs).tolist()),
        residues=tuple(residues.tolist()),
        decays=tuple((-pairs.real).tolist()),
        offsets=tuple(offsets.tolist()),
        relaxations=tuple(zip(strengths.tolist(), (-reals).tolist(), strict=True)),
        spring=spring,
        is_fitted=True,
    )


def _exact_impedance(scene: Scene, s: Complex) -> Complex:
    """Z/epsilon of the upper slab, s in 1/transit."""
    p, q = pair_ratio(scene, Jet.variable(s / scene.transit))
    return np.asarray(q.value / (p.value * scene.upper.epsilon), dtype=np.complex128)


def _weight(s: Complex, target: Complex) -> Array:
    """Weights of the relative errors, larger at lower frequency, because modes above the band disturb the fit at its edge."""
    return 1.0 / ((1.0 + np.abs(target)) * (1.0 + np.abs(s) ** _EMPHASIS))


def _columns(s: Complex, pairs: Complex, reals: Array) -> Complex:
    return np.column_stack([s, np.ones_like(s), partial_fractions(s, pairs, reals)])


def _passive(name: str, s: Complex, target: Complex, spring: float, pairs: Complex, reals: Array) -> Reduction:
    """Least squares with Re Z >= 0 on a grid. Points of negative Re Z between them are added to the grid until there are none."""
    weight = _weight(s, target)
    rows, right = _columns(s, pairs, reals) * weight[:, None], (target - spring / s) * weight
    matrix, data = np.concatenate([rows.real, rows.imag]), np.concatenate([right.real, right.imag])
    dense = _watch(s, pairs)
    response = _columns(np.asarray(1j * dense, dtype=np.complex128), pairs, reals).real
    held = response[:: max(1, len(dense) // 400)]
    ends = np.eye(2, response.shape[1])
    for _ in range(_ROUNDS):
        floors = np.concatenate([np.full(len(held), _FLOOR), [0.0, _FLOOR]])
        try:
            x = passive_coefficients(matrix, data, np.vstack([held, ends]), floors)
        except ArithmeticError as error:
            raise SceneError(f"model = {name!r}: no passive fit with these poles ({error}); try another N") from None
        fit = _reduction(name, x, pairs, reals, spring)
        real, between = response @ x, sign_frequencies(fit)
        lost = dissipation(fit, between)
        if real.min() >= 0.0 and lost.min() >= 0.0:
            return fit
        dips = np.flatnonzero((real < 0.0) & (real <= np.roll(real, 1)) & (real <= np.roll(real, -1)))
        missed = _columns(np.asarray(1j * between[lost < 0.0], dtype=np.complex128), pairs, reals).real
        held = np.vstack([held, response[dips], missed])
    worst = between[np.argmin(lost)] if lost.min() < real.min() else dense[np.argmin(real)]
    raise SceneError(f"model = {name!r}: the fit is not passive at {worst:.3g} radians per transit; try another N")


def _watch(s: Complex, pairs: Complex) -> Array:
    """Frequencies at which Re Z is checked: in the band, far above it, and across the width of every resonance."""
    top = float(s.imag[-1])
    across = pairs.imag[:, None] - pairs.real[:, None] * np.linspace(-8.0, 8.0, 81)
    grid = np.concatenate(
        [[1e-6], s.imag, np.linspace(0.0, 1.5 * top, 2000), np.geomspace(top, 300.0 * top, 600), across.ravel()]
    )
    return np.unique(np.abs(grid))


def _require_accuracy(scene: Scene, fit: Reduction, longest: float) -> None:
    s = np.asarray(1j * np.geomspace(0.02, np.pi, 200) / longest, dtype=np.complex128)
    p, q = reduction_ratio(fit, scene.upper.epsilon, scene.transit, Jet.variable(s / scene.transit))
    exact = _exact_impedance(scene, s)
    error = np.abs(q.value / (p.value * scene.upper.epsilon) - exact) / (1.0 + np.abs(exact))
    worst = int(np.argmax(error))
    if error[worst] > WORST_ALLOWED:
        raise SceneError(
            f"model = {fit.name!r}: the best passive fit is {100 * error[worst]:.2g} % off at {s[worst].imag:.3g} radians per "
            f"transit (allowed {100 * WORST_ALLOWED:.0f} %); try a larger N, delay or a full-wave model"
        )
