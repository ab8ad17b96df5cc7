"""Is a sequence of cycles a walk on a torus?  Then every figure x_n of the n-th cycle is a smooth function of a phase that
advances by the same angle from cycle to cycle,

    x_n = sum over k of c_k exp(2 pi i k rho n),     c_-k = conj(c_k),

with the rotation number rho. Chaos has no such description, whatever the number of terms."""

from typing import NamedTuple

import numpy as np

from slipwave.observe.pieces import Array

_FEWEST = 16
_MOST_HARMONICS = 6
_CYCLES_PER_TERM = 4  # so that noise is not fitted: a term has an amplitude and a phase
_GRID = 16  # trial frequencies in the width of a peak
_NEAR = 1e-9


class Rotation(NamedTuple):
    """`number`: rho in (0, 1/2], the share of a turn by which the phase advances in a cycle; `misfit`: what the smooth function
    leaves of the figure, root mean square, relative to its deviation from the mean."""

    number: float
    misfit: float


def rotation(figure: Array) -> Rotation | None:
    """The best description of `figure` (cycles,) by one phase; None for fewer than 16 cycles or a constant figure."""
    count, deviation = figure.size, figure - figure.mean()
    if count < _FEWEST or not deviation.any():
        return None
    from scipy.optimize import minimize_scalar

    terms = min(_MOST_HARMONICS, count // _CYCLES_PER_TERM)
    trials = np.arange(1, _GRID * count // 2) / (_GRID * count)
    window = np.hanning(count + 2)[1:-1]
    strength = [abs(np.exp(-2j * np.pi * rho * np.arange(count)) @ (window * deviation)) for rho in trials]
    start, width = float(trials[int(np.argmax(strength))]), 1.0 / (_GRID * count)
    bounds = (max(width, start - width), min(0.5, start + width))
    best = minimize_scalar(lambda rho: _misfit(figure, rho, terms), bounds=bounds, method="bounded", options={"xatol": _NEAR})
    return Rotation(float(best.x), float(best.fun))


def _misfit(figure: Array, rho: float, terms: int) -> float:
    """What the best `terms` harmonics of the frequency `rho` leave of `figure`, relative."""
    angles = 2.0 * np.pi * rho * np.arange(figure.size)[:, None] * np.arange(1, terms + 1)
    basis = np.column_stack([np.ones(figure.size), np.cos(angles), np.sin(angles)])
    left = figure - basis @ np.linalg.lstsq(basis, figure, rcond=None)[0]
    return float(np.sqrt(np.mean(left**2)) / np.std(figure))
