"""Extrema and roots of the polynomials that pieces are made of, compiled for the event detector."""

import math

import numpy as np

from slipwave.compiled import allocating, inlined, njit
from slipwave.observe.pieces import Array, Basis

_ROOT_ITERATIONS = 80


@njit
def evaluate(basis: Basis, values: Array, point: float) -> float:
    """Barycentric value at `point` of [0, 1] of the polynomial through `values` at the basis nodes."""
    top = 0.0
    bottom = 0.0
    for j in range(values.size):
        gap = point - basis.nodes[j]
        if gap == 0.0:
            return float(values[j])
        term = basis.weights[j] / gap
        top += term * values[j]
        bottom += term
    return top / bottom


@njit
def find_root(basis: Basis, values: Array, level: float, left: float, right: float) -> float:
    """Point of [left, right] where the polynomial equals `level`, which lies between its end values (Illinois false position)."""
    low = evaluate(basis, values, left) - level
    high = evaluate(basis, values, right) - level
    point = right
    for _ in range(_ROOT_ITERATIONS):
        if high == low:
            break
        point = right - high * (right - left) / (high - low)
        value = evaluate(basis, values, point) - level
        if value == 0.0 or abs(right - left) < 1e-15:
            break
        if value * high < 0.0:
            left, low = right, high
        else:
            low *= 0.5
        moved = abs(point - right)
        right, high = point, value
        if moved < 1e-15:
            break
    return point


@njit
def differentiate(basis: Basis, values: Array, slopes: Array) -> None:
    """slopes <- derivative of the polynomial at the nodes."""
    for i in range(values.size):
        slope = 0.0
        for j in range(values.size):
            slope += basis.derivative[i, j] * values[j]
        slopes[i] = slope  # stored once: what is stored may be what is read next


@njit
def _trusted(basis: Basis, values: Array, peak: float, sign: float, j: int) -> float:
    """`peak` of sign * polynomial before the node `j`, but at most what a smooth signal can have there: by more than `overshoot`
    above all nodes the polynomial oscillates at a steep front (in ln v by decades), and above the straight lines that continue
    the intervals on both sides it does behind a jump."""
    bottom, top = bounds(values)
    highest = float(top if sign > 0.0 else -bottom)
    if peak - highest > overshoot(top - bottom, values.size):
        return highest
    nodes, rise, fall = basis.nodes, math.inf, math.inf
    if j > 1:
        rise = sign * (values[j - 1] - values[j - 2]) / (nodes[j - 1] - nodes[j - 2])
    if 0 < j < values.size - 1:
        fall = sign * (values[j] - values[j + 1]) / (nodes[j + 1] - nodes[j])
    if min(rise, fall) <= 0.0:
        return highest
    if max(rise, fall) < math.inf:
        before, after, width = sign * values[j - 1], sign * values[j], nodes[j] - nodes[j - 1]
        crossing = float((before * fall + after * rise + rise * fall * width) / (rise + fall))
        return max(highest, min(peak, crossing))
    return peak


@njit
def bounds(values: Array) -> tuple[float, float]:
    """The smallest and the largest value; a loop, because loading numba's own min() and max() takes a fifth of a second."""
    bottom, top = values[0], values[0]
    for j in range(1, values.size):
        bottom, top = min(bottom, values[j]), max(top, values[j])
    return bottom, top


@inlined
def overshoot(spread: float, nodes: int) -> float:
    """The most by which a polynomial through `nodes` values that differ by `spread` is trusted to exceed them: more than the
    overshoot of a sine whose period is the piece's length."""
    return 4.0 * spread / ((nodes - 1.0) * (nodes - 1.0))


@allocating
def extrema(basis: Basis, rows: Array) -> tuple[float, float]:
    """Largest and smallest value of the consecutive polynomials with nodal values `rows` (m, n)."""
    memory, slopes = np.full(2, -np.inf), np.empty(rows.shape[1])
    for k in range(rows.shape[0]):
        raise_record(basis, rows[k], slopes, memory, 0, 0.0, 1.0)
    return memory[0], -memory[1]


@njit
def raise_record(basis: Basis, values: Array, slopes: Array, memory: Array, slot: int, begin: float, end: float) -> None:
    """memory[slot] <- the larger of itself and the maximum of the part [begin, end] of the piece; memory[slot + 1] likewise with
    -minimum; `slopes` is scratch. The value at 0 counts too: where the motion jumps it is not that at the end of the piece
    before."""
    bottom, top = bounds(values)
    reach = overshoot(top - bottom, values.size)
    if top + reach <= memory[slot] and reach - bottom <= memory[slot + 1]:
        return
    known = begin == 0.0 and end == basis.nodes[values.size - 1] and not math.isinf(memory[slot])
    differentiate(basis, values, slopes)
    for side in range(2):
        sign = 1.0 - 2.0 * side
        if known and (top if side == 0 else -bottom) + reach <= memory[slot + side]:
            continue
        peak = max(_peak(basis, values, slopes, sign, begin, end), sign * evaluate(basis, values, begin))
        memory[slot + side] = max(memory[slot + side], peak)


@njit
def _peak(basis: Basis, values: Array, slopes: Array, sign: float, begin: float, end: float) -> float:
    """Maximum of sign * polynomial at `end` and where it turns in [begin, end]; `slopes` are those at the nodes."""
    n = values.size
    best = sign * (values[n - 1] if end == basis.nodes[n - 1] else evaluate(basis, values, end))
    left, before = begin, 0.0
    for j in range(n + 1):
        right = min(basis.nodes[j], end) if j < n else end
        if right > left:
            slope = sign * (slopes[j] if j < n and right == basis.nodes[j] else evaluate(basis, slopes, right))
            if left == begin and slope <= 0.0:  # else the slope there decides nothing
                before = sign * evaluate(basis, slopes, begin)
            if before > 0.0 >= slope:
                peak = sign * float(evaluate(basis, values, find_root(basis, slopes, 0.0, left, right)))
                if peak > best:
                    best = max(best, _trusted(basis, values, peak, sign, j))
            left, before = right, slope
    return best
