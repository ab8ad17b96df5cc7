"""`fitted:N`: a passive rational fit of any scene's impedance with about N oscillators and two relaxations.

If the modes are known (elastic slabs behind rigid faces), it is modal:N. Otherwise the poles come from vector fitting of exact
samples on the imaginary axis, and the coefficients from least squares under Re Z >= 0. The spring is not fitted; it is the exact
quasi-static one. Passivity is certified on the whole axis, not on a grid (`Reduction.sign_frequencies`). A fit that is not
passive, or not accurate at low frequency, is refused.

Poles: the relocation of Gustavsen and Semlyen (1999), f(s) ~ sum c_k/(s - a_k) + d + h s, in real arithmetic; unstable poles are
reflected.
Residues: for fixed poles Re Z(i omega) is linear in the coefficients, so least squares under Re Z >= 0 on a grid is a quadratic
programme. It is solved as Lawson and Hanson's least distance problem by non-negative least squares.
"""

from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from reduced.impedance.reduction import Reduction
from reduced.impedance.transmission_line import Complex, Jet, drive_ratio, pair_ratio
from slipwave.errors import SceneError
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from slipwave.threads import one_thread

_REAL_POLE = 1e-9
_AT_REST = 1e-6
_RELOCATIONS = 12

WORST_ALLOWED = 0.05
"""Largest allowed error of Z below half the first mode, relative to |Z| + epsilon; a worse fit is refused."""

_EMPHASIS = 4
_FLOOR = 1e-7
"""Re Z/epsilon is kept above this on the grid of constraints, so that it stays above zero between the points."""

_ON_A_POLE = 1e12  # value of a response: a pole lies on a frequency, within rounding
_ROUNDS = 8
_LOSSLESS = "nothing damps waves here, and no N helps: give an outer face an impedance, or take fitted:0, delay or a full wave"


def _partial_fractions(s: Complex, pairs: Complex, reals: Array) -> Complex:
    """Columns 1/(s - a) for real poles, then (s, 1)/(s^2 + 2 g s + w^2) for every pair: real coefficients span all residues."""
    bottom = s[:, None] ** 2 - 2.0 * pairs.real * s[:, None] + np.abs(pairs) ** 2
    return np.column_stack([1.0 / (s[:, None] - reals), s[:, None] / bottom, 1.0 / bottom])


def _stack(rows: NDArray[Any]) -> Array:
    return np.concatenate([rows.real, rows.imag])


def _least_squares(rows: NDArray[Any], right: NDArray[Any]) -> Array:
    """Real x that minimises |rows x - right|, with columns scaled to the same size."""
    matrix = _stack(rows)
    scale = np.linalg.norm(matrix, axis=0)
    return np.asarray(np.linalg.lstsq(matrix / scale, _stack(right), rcond=None)[0] / scale)


def _companion(pairs: Complex, reals: Array, sigma: Array) -> Array:
    """A - b c~^T, whose eigenvalues are the zeros of sigma; a pair is the block [[2 g, -w^2], [1, 0]], with b = (1, 0)."""
    n, m = reals.size, pairs.size
    matrix = np.zeros((n + 2 * m, n + 2 * m))
    matrix[range(n), range(n)] = reals
    drive = np.zeros(n + 2 * m)
    drive[: n + m] = 1.0
    first, second = np.arange(n, n + m), np.arange(n + m, n + 2 * m)
    matrix[first, first] = 2.0 * pairs.real
    matrix[first, second] = -(np.abs(pairs) ** 2)
    matrix[second, first] = 1.0
    return matrix - np.outer(drive, sigma)


def _fit_poles(s: Complex, values: Complex, weight: Array, pairs: Complex, reals: Array) -> tuple[Complex, Array]:
    """One of each conjugate pair, and the real poles, after a few steps of vector fitting from the given start, until they no
    longer change. In a step the poles become the zeros of the fitted sigma(s) = 1 + sum c~_k/(s - a_k)."""
    for _ in range(_RELOCATIONS):
        before = np.sort_complex(np.concatenate([pairs, reals]))
        basis = _partial_fractions(s, pairs, reals)
        rows = np.column_stack([basis, np.ones_like(s), s, -values[:, None] * basis]) * weight[:, None]
        coefficients = _least_squares(rows, values * weight)
        new = np.linalg.eigvals(_companion(pairs, reals, coefficients[basis.shape[1] + 2 :]))
        poles = -np.abs(new.real) + 1j * new.imag
        real = np.abs(poles.imag) <= _REAL_POLE * np.abs(poles)
        pairs, reals = poles[(poles.imag > 0.0) & ~real], poles[real].real
        after = np.sort_complex(np.concatenate([pairs, reals]))
        if after.shape == before.shape and np.all(np.abs(after - before) < _AT_REST * np.abs(after)):
            break
    return pairs, reals


def _passive_coefficients(matrix: Array, right: Array, constraints: Array, floors: Array) -> Array:
    """x that minimises |matrix x - right| under constraints x >= floors.

    With matrix = Q R and z = R x - Q^T right this is the least distance problem min |z|, G z >= h. Its solution follows from the
    residual of non-negative least squares (Lawson and Hanson, chapter 23). Raises ArithmeticError, with advice as its
    second argument, if no x satisfies them, and for rows on a pole.
    """
    from scipy.linalg import solve_triangular
    from scipy.optimize import nnls

    if not (np.isfinite(matrix).all() and np.abs(constraints).max() < _ON_A_POLE):
        raise ArithmeticError("one is undamped, at a frequency that is fitted", _LOSSLESS)
    scale = np.linalg.norm(matrix, axis=0)
    q, r = np.linalg.qr(matrix / scale)
    free = q.T @ right
    g = solve_triangular(r, (constraints / scale).T, trans="T").T
    h = floors - g @ free
    size = np.maximum(np.linalg.norm(g, axis=1), 1e-300)
    g, h = g / size[:, None], h / size
    if np.all(h <= 0.0):
        return np.asarray(solve_triangular(r, free) / scale)
    stretch = np.abs(h).max()
    dual, _ = nnls(np.vstack([g.T, h / stretch]), np.append(np.zeros(g.shape[1]), 1.0), maxiter=100 * len(h))
    residual = np.vstack([g.T, h / stretch]) @ dual - np.append(np.zeros(g.shape[1]), 1.0)
    if abs(residual[-1]) < 1e-14:
        raise ArithmeticError("no coefficients satisfy the constraints", "try another N")
    z = -residual[:-1] / residual[-1] * stretch
    return np.asarray(solve_triangular(r, free + z) / scale)


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
        pairs, reals = _fit_poles(s, target - spring / s, _weight(s, target), start, np.array([-0.3, -3.0]) / longest)
        fit = _passive(name, s, target, spring, pairs, reals)
    _require_accuracy(scene, fit, longest)
    return fit if scene.drive.is_constant else replace(fit, transfer=_transfer(scene, fit, s, start))


def _transfer(scene: Scene, fit: Reduction, s: Complex, start: Complex) -> Reduction:
    """The stress that the drive alone causes, with poles of its own: least squares over the same band."""
    p, n = drive_ratio(scene, Jet.variable(s / scene.transit))
    target = np.asarray(n.value / (p.value * scene.upper.epsilon)) - fit.spring / s
    weight = np.asarray(1.0 / (1.0 + np.abs(s)))
    with one_thread(), np.errstate(divide="ignore", invalid="ignore"):
        pairs, reals = _fit_poles(s, target, weight, start, np.array([-0.3, -3.0]))
    coefficients = _least_squares(_partial_fractions(s, pairs, reals) * weight[:, None], target * weight)
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
    return np.column_stack([s, np.ones_like(s), _partial_fractions(s, pairs, reals)])


def _passive(name: str, s: Complex, target: Complex, spring: float, pairs: Complex, reals: Array) -> Reduction:
    """Least squares with Re Z >= 0 on a grid. Points of negative Re Z between them are added to the grid until there are none."""
    weight = _weight(s, target)
    rows, right = _columns(s, pairs, reals) * weight[:, None], (target - spring / s) * weight
    matrix, data = _stack(rows), _stack(right)
    dense = _watch(s, pairs)
    response = _columns(np.asarray(1j * dense, dtype=np.complex128), pairs, reals).real
    held = response[:: max(1, len(dense) // 400)]
    ends = np.eye(2, response.shape[1])
    for _ in range(_ROUNDS):
        floors = np.concatenate([np.full(len(held), _FLOOR), [0.0, _FLOOR]])
        try:
            x = _passive_coefficients(matrix, data, np.vstack([held, ends]), floors)
        except ArithmeticError as error:
            why, advice = error.args
            raise SceneError(f"model = {name!r}: no passive fit with these poles ({why}); {advice}") from None
        fit = _reduction(name, x, pairs, reals, spring)
        real, between = response @ x, fit.sign_frequencies()
        lost = fit.dissipation(between)
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
    p, q = fit.ratio(scene.upper.epsilon, scene.transit, Jet.variable(s / scene.transit))
    exact = _exact_impedance(scene, s)
    error = np.abs(q.value / (p.value * scene.upper.epsilon) - exact) / (1.0 + np.abs(exact))
    worst = int(np.argmax(error))
    if error[worst] > WORST_ALLOWED:
        raise SceneError(
            f"model = {fit.name!r}: the best passive fit is {100 * error[worst]:.2g} % off at {s[worst].imag:.3g} radians per "
            f"transit (allowed {100 * WORST_ALLOWED:.0f} %); try a larger N, delay or a full-wave model"
        )
