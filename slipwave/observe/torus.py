"""Decides whether a sequence of cycles lies on a torus: then every figure x_n of the n-th cycle is a smooth function of a phase
that advances by the same angle from cycle to cycle,

    x_n = sum over k of c_k exp(2 pi i k rho n),     c_-k = conj(c_k),

with the rotation number rho. Chaos has no such description, whatever the number of terms. A decay has one with a phase too slow
to complete a turn, or with amplitudes c_k that change: therefore the cycles must resolve the frequencies from each other and from
zero, and the amplitude must be constant.
"""

from typing import NamedTuple

import numpy as np

from slipwave.observe.pieces import Array

MANY = 16
"""Fewest cycles from which a motion that never repeats is classified."""

MOST_HARMONICS = 12
"""Most harmonics of the description."""

_CYCLES_PER_TERM = 4  # so that noise is not fitted: a term has an amplitude and a phase
_GRID = 16  # trial frequencies in the width of a peak
_NEAR = 1e-10
_ROUGH = 1e-2  # of the width of a peak, where the search begins anew with more terms
_TURNS = 1.0  # by which the phases of two terms must part over the cycles


class Rotation(NamedTuple):
    """`number`: rho in (0, 1/2], the share of a turn by which the phase advances in a cycle; `misfit`: root mean square residual
    of the figures over their standard deviation; `change`: relative change of the amplitude from the first cycle to the last, and
    its standard `error`; each of the worst figure. `terms`: number of harmonics that the cycles resolve, 0 if the phase completes
    no turn; `most`: the largest number for any frequency."""

    number: float
    misfit: float
    change: float
    error: float
    terms: int
    most: int


def rotation(figures: Array) -> Rotation | None:
    """Fit `figures` (cycles, n), or one figure (cycles,), by one phase, that of the strongest oscillation of one of them. None
    for fewer than 16 cycles or a constant figure."""
    columns = figures.reshape(len(figures), -1)
    if len(columns) < MANY or (np.ptp(columns, axis=0) == 0.0).any():
        return None
    count = len(columns)
    windows = np.hanning(count + 2)[1:-1] * (columns - columns.mean(axis=0)).T
    peaks = [np.argmax(np.abs(np.fft.rfft(window, _GRID * count)[1 : _GRID * count // 2])) for window in windows]
    starts = dict.fromkeys(float(1 + peak) / (_GRID * count) for peak in peaks)  # of the strongest oscillations, per cycle
    misfit, rho, resolved, most = min(_follow(columns, start) for start in starts)
    changes = [_change(column, rho, max(resolved, 1)) for column in columns.T]
    return Rotation(rho, misfit, *max(changes, key=lambda change: abs(change[0])), resolved, most)


def _follow(columns: Array, start: float) -> tuple[float, float, int, int]:
    """Fit by a phase whose frequency is near `start`: misfit, number, terms and most, as in `Rotation`."""
    from scipy.optimize import OptimizeResult, minimize_scalar

    count = len(columns)
    width, most = 1.0 / (_GRID * count), min(MOST_HARMONICS, count // _CYCLES_PER_TERM)

    def best(near: float, terms: int, within: float) -> OptimizeResult:
        bounds = (max(width, near - width), min(0.5, near + width))

        def misfit(rho: float) -> float:
            """Relative residual of the least-squares fit of a figure; the largest over the figures."""
            orthonormal, _ = np.linalg.qr(_basis(count, rho, terms))
            left = columns - orthonormal @ (orthonormal.T @ columns)
            return float(np.max(np.sqrt(np.mean(left**2, axis=0)) / np.std(columns, axis=0)))

        return minimize_scalar(misfit, bounds=bounds, method="bounded", options={"xatol": within})

    first = float(best(start, 1, _ROUGH * width).x)
    resolved = _terms(first, count, most)
    fit = best(first, max(resolved, 1), _NEAR)
    return float(fit.fun), float(fit.x), resolved, most


def _terms(rho: float, count: int, most: int) -> int:
    """Number of harmonics of the frequency `rho` that are resolved from each other, from their mirror images and from a
    constant."""
    for terms in range(1, most + 1):
        phases = np.sort(np.arange(-terms, terms + 1) * rho % 1.0)
        if np.diff(np.append(phases, phases[0] + 1.0)).min() < _TURNS / count:
            return terms - 1
    return most


def _basis(count: int, rho: float, terms: int) -> Array:
    angles = 2.0 * np.pi * rho * np.arange(count)[:, None] * np.arange(1, terms + 1)
    return np.column_stack([np.ones(count), np.cos(angles), np.sin(angles)])


def _change(figure: Array, rho: float, terms: int) -> tuple[float, float]:
    """Relative change of the amplitude over all cycles, fitted as linear together with linear changes of the phase and of the
    mean; and its standard error."""
    ramp, basis = np.linspace(-0.5, 0.5, figure.size), _basis(figure.size, rho, terms)
    coefficients = np.linalg.lstsq(basis, figure, rcond=None)[0]
    order = np.arange(1, terms + 1)
    ahead = np.concatenate(([0.0], order * coefficients[1 + terms :], -order * coefficients[1 : 1 + terms]))
    whole = np.column_stack([ramp * (basis[:, 1:] @ coefficients[1:]), ramp * (basis @ ahead), ramp, basis])
    left = figure - whole @ np.linalg.lstsq(whole, figure, rcond=None)[0]
    variance = left @ left / max(figure.size - whole.shape[1], 1)
    spread = np.linalg.pinv(whole.T @ whole)
    return float(spread[0] @ (whole.T @ figure)), float(np.sqrt(variance * spread[0, 0]))
