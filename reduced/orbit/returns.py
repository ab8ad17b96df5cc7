"""Where a motion that never repeats comes back near to itself: there unstable periodic orbits are close by."""

from typing import NamedTuple

import numpy as np

from slipwave.observe.pieces import Array, lagrange_basis, values_at
from slipwave.step.flow import Cycle, Flow

TRIED = 8
"""Closest returns from which an orbit is sought."""

_SAMPLES = 200
_SAME = 1e-6  # difference of ln v and psi


class Section(NamedTuple):
    """The `state` of `flow` halfway between two slip events, of which the earlier one has this `date` (transits)."""

    flow: Flow
    state: Array
    date: float


def closest_returns(sections: list[Section], cycles: int = 1, near: float | None = None) -> list[tuple[Section, float]]:
    """Sections to which the motion returns closest (largest difference of a component of the state) after so many `cycles`, the
    closest first, each with the time (transits) until then; with `near`, of the half whose time is nearest to it."""
    pairs = [(first, last.date - first.date, last) for first, last in zip(sections, sections[cycles:], strict=False)]
    if near is not None:
        pairs = sorted(pairs, key=lambda pair: abs(pair[1] - near))[: (len(pairs) + 1) // 2]
    pairs.sort(key=lambda pair: float(np.abs(pair[2].state - pair[0].state).max()))
    return [pair[:2] for pair in pairs[:TRIED]]


def difference_of_parts(cycle: Cycle, nodes: Array, parts: int) -> float:
    """Largest difference of z and psi between the first of so many equal `parts` of a closed cycle and the second; 0 if the
    motion repeats after one part."""
    basis, length = lagrange_basis(nodes), cycle.period / parts
    times = np.linspace(0.0, length, _SAMPLES, endpoint=False)[1:]
    first, second = (np.array(values_at(cycle.pieces, basis, times + shift)[:2]) for shift in (0.0, length))
    return float(np.abs(second - first).max())


def repeats_sooner(cycle: Cycle, nodes: Array, cycles: int) -> bool:
    """Whether a closed cycle of so many slip events is one of fewer, several times."""
    divisors = [parts for parts in range(2, cycles + 1) if cycles % parts == 0]
    return any(difference_of_parts(cycle, nodes, parts) < _SAME for parts in divisors)
