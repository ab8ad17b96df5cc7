"""Order of convergence fitted to errors on a ladder of grids, with a confidence interval and stated exclusions.

With four or five levels the interval measures scatter, not bias: a clean second-order scheme gives 2.001 +- 0.0005. A verdict
(`shortfall`) therefore has two conditions: the declared order lies in the interval or within a small tolerance of
the fitted one, and the interval is narrow enough to decide.
"""

import math
from dataclasses import dataclass

import numpy as np

from slipwave.observe.pieces import Array

_ROUND_OFF = 100.0 * np.finfo(float).eps
_ASYMPTOTIC = 0.15
FEWEST = 4
FEWEST_DENSE = 6
_NEAR, _MOST, TREND = 0.5, 0.5, 0.1
"""Most by which the fit may lie below the order to which its trend leads; least share of that which is closed; its accuracy."""
WITHIN = 0.1  # of the declared order
WIDEST = 0.5  # half-width beyond which a fit proves nothing


@dataclass(frozen=True)
class Fit:
    """error ~ constant / cells^order by least squares in the logarithms over the levels `used` (a slice of the ladder).

    `half_width` is that of the 95 % confidence interval of the order (Student, n - 2 degrees of freedom), `finest_error` the
    smallest error used. `limit` is the order at h = 0 to which the trend of the local orders leads, from error ~ constant h^order
    e^(b h) with h = 1/cells; its interval is infinite with fewer than four levels.
    """

    order: float
    half_width: float
    finest_error: float
    used: slice
    limit: float
    limit_half_width: float

    def __str__(self) -> str:
        return f"order {self.order:.3f} +- {self.half_width:.3f} (95 %), levels {self.used.start + 1} to {self.used.stop}"

    def leads_to(self, declared: float) -> bool:
        """Whether the local orders rise to `declared` with finer grids, although grids too fine to run would be needed to reach
        it: most of the deficit must be closed by the trend, which must be known accurately."""
        closed = self.limit - self.order > _MOST * (declared - self.order)
        return self.order > declared - _NEAR and closed and self.limit_half_width < TREND and abs(self.limit - declared) < TREND

    @property
    def rounded(self) -> str:
        """The order with its 95 % interval, rounded up, for a table."""
        return f"{self.order:.2f}\u00a0±\u00a0{math.ceil(100 * self.half_width) / 100:.2f}"


def fit_order(cells: Array, errors: Array, scale: float = 1.0) -> Fit:
    """Fit the order of `errors` (positive) on grids of `cells` (increasing).

    Excluded by rule: levels at rounding (error below 100 machine epsilons of `scale`, and all finer ones), then coarse levels
    whose local order differs by more than 0.15 from the finest one, as long as four levels remain. Raises ValueError with fewer
    than four usable levels.
    """
    x, y = _usable(cells, errors, 0, _ROUND_OFF * scale)
    local = -np.diff(y) / np.diff(x)
    start = 0
    while y.size - start > FEWEST and abs(local[start] - local[-1]) > _ASYMPTOTIC:
        start += 1
    return _regress(x, y, start)


def fit_dense(cells: Array, errors: Array, start: int = 0, floor: float = 0.0) -> Fit:
    """As `fit`, for a ladder of many close grids. Their errors scatter, so that local orders mean little.

    The levels used begin with number `start` and end before the first error at or below `floor` (or rounding). The coarsest of
    them are dropped, as long as six remain, while a parabola through the logarithms is significantly curved (95 %). A straight
    line through them would hide the curvature in its interval, or be wrong by more than its interval. Raises ValueError with
    fewer than four usable levels.
    """
    x, y = _usable(cells, errors, start, max(floor, _ROUND_OFF))
    while y.size - start > FEWEST_DENSE and _curved(x[start:], y[start:]):
        start += 1
    return _regress(x, y, start)


def _usable(cells: Array, errors: Array, start: int, floor: float) -> tuple[Array, Array]:
    """Logarithms of cells and errors before the first error, from level `start` on, at or below `floor`."""
    errors = np.asarray(errors, dtype=float)
    spent = np.nonzero(~(errors[start:] > floor))[0]
    end = start + int(spent[0]) if spent.size else errors.size
    if end - start < FEWEST:
        raise ValueError(f"{end - start} usable levels; an order needs {FEWEST}")
    return np.log(np.asarray(cells, dtype=float)[:end]), np.log(errors[:end])


def _curved(x: Array, y: Array) -> bool:
    """Whether the 95 % interval of the quadratic coefficient of y over x excludes zero."""
    from scipy.special import stdtrit

    powers = np.vander((x - x.mean()) / np.ptp(x), 3)
    coefficients = np.linalg.lstsq(powers, y, rcond=None)[0]
    residual = y - powers @ coefficients
    variance = residual @ residual / (x.size - 3) * np.linalg.inv(powers.T @ powers)[0, 0]
    return bool(abs(coefficients[0]) > stdtrit(x.size - 3, 0.975) * np.sqrt(variance))


def _regress(x: Array, y: Array, start: int) -> Fit:
    """The straight line through the logarithms from level `start` on."""
    from scipy.special import stdtrit

    used = slice(start, y.size)
    x, y = x[used], y[used]

    def line(*terms: Array) -> tuple[float, float]:
        """The coefficient of the second of these terms, rows, in y, and the half-width of its 95 % interval."""
        matrix = np.stack(terms, axis=1)
        coefficients = np.linalg.lstsq(matrix, y, rcond=None)[0]
        residual, free = y - matrix @ coefficients, x.size - len(terms)
        if free < 1:
            return float(coefficients[1]), math.inf
        variance = residual @ residual / free * np.linalg.inv(matrix.T @ matrix)[1, 1]
        return float(coefficients[1]), float(stdtrit(free, 0.975) * np.sqrt(variance))

    slope, half_width = line(np.ones_like(x), x)
    limit, limit_half_width = line(np.ones_like(x), x, np.exp(x[0] - x))
    return Fit(-slope, half_width, float(np.exp(y.min())), used, -limit, limit_half_width)


def shortfall(result: Fit, declared: float, tolerance: float = WITHIN, at_least: bool = False, widest: float = WIDEST) -> str:
    """Why `result` does not support the `declared` order; empty if it does: the interval is no wider than `widest`, and the
    declared order lies in it or within `tolerance` of the fitted one. With `at_least` a higher order passes too, and so does an
    interval of any width that lies above the declared order (an interval narrower than `tolerance` counts as that wide)."""
    if at_least and result.order - max(tolerance, result.half_width) >= declared:
        return ""
    if result.half_width > widest:
        return f"confidence interval too wide to tell: {result}"
    allowed = max(tolerance, result.half_width)
    if result.order < declared - allowed or (not at_least and result.order > declared + allowed):
        return f"declared {declared:g} +- {allowed:.2g}, observed {result}"
    return ""


def asked(order: float, declared: float, allowed: float, above: bool) -> tuple[str, float]:
    """(text of the required order; distance from it); an order `above` the declared one has distance 0."""
    if above:
        return f"{math.floor(100.0 * (declared - allowed)) / 100.0:.2f} or more", max(0.0, declared - order)
    return f"{declared:g} ± {allowed:.2f}", abs(order - declared)
