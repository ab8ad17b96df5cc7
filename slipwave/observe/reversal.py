"""What the event detector reads from the polynomials of the rate unknown, also where v changes its sign.

For laws that allow v <= 0 the unknown of a piece is replaced there by one that is as smooth as the stress (`OfStep`).
"""

from slipwave.compiled import njit
from slipwave.compiled.dispatch import by_class
from slipwave.friction import Law, OfStep, rate_of, to_own, to_step, unknown_of
from slipwave.observe.extrema import evaluate, find_root, raise_record
from slipwave.observe.pieces import Array, Basis

_SLOPES, _VALUES, _EXTREMES = 1, 2, 3  # rows of the detector's scratch
SCRATCH = 4
"""Rows of scratch; the first is not used here."""


@by_class()
def raise_rate(
    law: Law, own: Law, basis: Basis, z: Array, scratch: Array, memory: Array, slot: int, begin: float, end: float
) -> None:
    """`raise_record` of the unknown `z` of the law `own` in a piece; `law`: its `law_of_step` there."""
    raise_record(basis, z, scratch[_SLOPES], memory, slot, begin, end)


@raise_rate.register(OfStep)
def _raise_smoothly(law, own, basis, z, scratch, memory, slot, begin, end):  # type: ignore[no-untyped-def]
    values, extremes = scratch[_VALUES], scratch[_EXTREMES]
    for j in range(z.size):
        values[j] = z[j]
    to_step(law, own, values)
    extremes[0], extremes[1] = memory[slot], -memory[slot + 1]
    to_step(law, own, extremes[:2])
    extremes[1] = -extremes[1]
    high, low = extremes[0], extremes[1]
    raise_record(basis, values, scratch[_SLOPES], extremes, 0, begin, end)
    raised, lowered = extremes[0] > high, extremes[1] > low
    extremes[1] = -extremes[1]
    to_own(law, extremes[:2])
    if raised:
        memory[slot] = extremes[0]
    if lowered:
        memory[slot + 1] = -extremes[1]


@by_class()
def passage(law: Law, basis: Basis, z: Array, lowest: float, level: float, node: int, scratch: Array) -> float:
    """Point of a piece with unknowns `z`, of which `lowest` is the least, at which z last passed `level` upwards before `node`; 1
    if it did in a jump at the end of the piece, -1 if z was above `level` all the time."""
    return _passage(basis, z, lowest, level, node)


@passage.register(OfStep)
def _pass_smoothly(law, basis, z, lowest, level, node, scratch):  # type: ignore[no-untyped-def]
    values, own, rate = scratch[_VALUES], law.law, rate_of(law.law, level)
    if rate <= 0.0 or lowest > unknown_of(own, 0.0):
        return _passage(basis, z, lowest, level, node)
    for j in range(z.size):
        values[j] = z[j]
    here, extremes = OfStep(own, 0.5 * rate), scratch[_EXTREMES]  # as smooth as v below the level
    extremes[0], extremes[1] = lowest, level
    to_step(here, own, values)
    to_step(here, own, extremes[:2])
    return _passage(basis, values, extremes[0], extremes[1], node)


@njit
def _passage(basis: Basis, z: Array, lowest: float, level: float, node: int) -> float:
    if node == z.size and z[node - 1] < level:
        return 1.0
    if lowest < level:
        for j in range(min(node, z.size - 1) - 1, -1, -1):
            if z[j] < level:
                return find_root(basis, z, level, basis.nodes[j], basis.nodes[j + 1])
    return find_root(basis, z, level, 0.0, basis.nodes[0]) if evaluate(basis, z, 0.0) < level <= z[0] else -1.0
