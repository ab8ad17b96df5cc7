"""Do the cycles of a motion still change in one direction?  Cycles that repeat, or wander for ever, do not.

Figures of cycles are compared as logarithms, cycle k with cycle k + n (every n-th, n = 1 ... 8), so that the approach to a period
of n events is seen as well. Two signs are looked for:

* the differences become smaller (or larger) exponentially: the line through their logarithms changes by ln 2 or more in all,
  and by five times its standard error, and goes on in the later half, so that the ups and downs of chaos are none;
* a parabola in k leaves at most a tenth of the variance, in most figures: a slow drift, whose end is not in sight. For n > 1 a
  straight line must do that, because half a turn of a torus near a period of n is a parabola too.
"""

import numpy as np

from slipwave.observe.pieces import Array

LAGS = 8
_LEFT = 0.1  # of the variance, beside a parabola
_ERRORS = 5.0
_LATE = 0.2  # of the change, in the later half
_NONE = 1e-13  # rounding of a logarithm, and more than the sum of squares of many
_LONGEST = 0.99  # of the change between two thirds, the largest share that the next third is taken to repeat


def logarithms(figures: Array) -> Array:
    """Figures (cycles, 5) as logarithms; over their mean size where they change sign."""
    sizes = np.abs(figures).mean(axis=0)
    positive = (figures > 0.0).all(axis=0)
    return np.where(positive, np.log(np.where(positive, figures, 1.0)), figures / np.where(sizes > 0.0, sizes, 1.0))


def still_changes(figures: Array) -> bool:
    """Whether the cycles with these `figures` (cycles, 5) approach or leave something, or drift."""
    values = logarithms(figures)
    steps = np.diff(values, axis=0)
    one_way = ((steps > 0.0).all(axis=0) | (steps < 0.0).all(axis=0)).all()
    lags = range(1, min(LAGS, len(values) // 4) + 1)
    return bool(one_way) or any(_shrinks(values, lag) or _drifts(values, lag) for lag in lags)


def goes_on(periods: Array, within: float) -> bool:
    """Whether means over successive periods (periods, 5), relative to their size, move on to a value further off than `within`:
    the sum of the geometric series that the changes between their thirds begin."""
    if len(periods) < 3:
        return False
    early, late = between_thirds(periods)
    scatter = np.sqrt(np.mean(np.diff(periods, n=2, axis=0) ** 2, axis=0) / 3.0) if len(periods) > 3 else 0.0
    onwards = (early * late > 0.0) & (np.abs(late) > 3.0 * scatter)
    share = np.minimum(np.abs(late) / np.where(early == 0.0, 1.0, np.abs(early)), _LONGEST)
    return bool((onwards & (np.abs(late) * share / (1.0 - share) > within)).any())


def between_thirds(values: Array) -> Array:
    """The changes between the means of the thirds of `values` (n, ...), of which up to two at the beginning are left out."""
    third = len(values) // 3
    return np.diff(values[-3 * third :].reshape(3, third, *values.shape[1:]).mean(axis=1), axis=0)


def straight_line(values: Array) -> tuple[float, float, float]:
    """The straight line through `values` (n,), by least squares: its change from the first to the last, the standard error of
    that change, and the share of the variance that it explains."""
    n = values.size
    place = np.linspace(-0.5, 0.5, n)
    change = float(place @ values / (place @ place))
    left = values - values.mean() - change * place
    error = float(np.sqrt(left @ left / max(n - 2, 1) / (place @ place)))
    variance = float(np.sum((values - values.mean()) ** 2))
    return change, error, 1.0 - float(left @ left) / variance if variance > 0.0 else 0.0


def _shrinks(values: Array, lag: int) -> bool:
    """Whether the cycles `lag` apart come closer, or part, exponentially."""
    apart = np.log(np.maximum(np.abs(values[lag:] - values[:-lag]).max(axis=1), _NONE))
    if apart.size < 4:
        return bool(apart.size > 1 and apart[-1] < apart[0] - np.log(2.0) and (np.diff(apart) < 0.0).all())
    change, error, _ = straight_line(apart)
    late, later, _ = straight_line(apart[apart.size // 2 :])
    lasts = late * change > 0.0 and abs(late) >= max(_LATE * abs(change), later)
    return lasts and abs(change) >= max(np.log(2.0), _ERRORS * error)


def _drifts(values: Array, lag: int) -> bool:
    """Whether the sequences of every `lag`-th cycle are straight (parabolas for a lag of 1), in most of the figures."""
    if len(values) < max(8, 6 * lag):
        return False
    before, after = np.zeros(values.shape[1]), np.zeros(values.shape[1])
    for k in range(lag):
        rows = values[k::lag]
        powers = np.vander(np.linspace(-1.0, 1.0, len(rows)), 3 if lag == 1 else 2)
        before += np.sum((rows - rows.mean(axis=0)) ** 2, axis=0)
        after += np.sum((rows - powers @ np.linalg.lstsq(powers, rows, rcond=None)[0]) ** 2, axis=0)
    return bool(2 * np.count_nonzero((before > _NONE) & (after <= _LEFT * before)) > values.shape[1])
