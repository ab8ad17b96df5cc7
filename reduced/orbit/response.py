"""The response of an orbit: derivatives of its figures by a parameter p of its scene, stable or not.

With u = (x_0, T), the equations of `reduced.orbit.closing`, R(u, p) = 0, have the derivative R_u du/dp + R_p = 0. R_u is the
bordered matrix, R_p a difference of marches from the same start. The figures follow from marches on the orbit's tangent:

    d g/dp = (g(u + h du/dp, p + h) - g(u - h du/dp, p - h))/(2 h)
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from reduced.orbit.closing import Closed, closed_between
from reduced.orbit.multipliers import floquet
from reduced.orbit.phase import PhaseResponse
from slipwave.errors import NumericsError, SceneError
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from slipwave.step.collocation import radau
from slipwave.step.flow import Push
from slipwave.threads import one_thread

_PUSHED = 1e-5  # of the period: the advance from which the second order is read
_LEFT, _MOST_PERIODS = 1e-3, 25  # part of a disturbance that may be left, and the most periods in which it has to decay
_ALIGNED = 1e-11  # of the period: error of an advance
_NEUTRAL = 1e-6  # distance from 1 of another multiplier, below which the orbit has no derivative: it turns in a fold


class Responding:
    """An orbit on the meshes on which its motion is a smooth function of parameters. Raises NumericsError where another
    multiplier is 1, so that the orbit has no derivative."""

    def __init__(self, closed: Closed) -> None:
        others, defect = floquet(closed.monodromy, closed.flow.idle)
        neutral = max(_NEUTRAL, 2.0 * defect)  # in a fold errors move both multipliers from 1 by the root of their size
        if np.abs(others - 1.0).min(initial=np.inf) < neutral:
            reason = f"another multiplier is 1 within {neutral:.1g}, as in a fold"
            raise NumericsError(f"{reason}: the orbit has no derivative by a parameter")
        self._meshes, self._slowest = [(closed, _inverse(closed))], float(np.abs(others).max(initial=0.0))

    def by(
        self, scenes: Sequence[Scene], weights: Mapping[float, float], figures: Callable[[Closed], Mapping[str, float]]
    ) -> dict[str, float]:
        """d figures/dp from `scenes` beside the orbit's, at p + offset: d f/dp is the sum of weight f over them, `weights` by the
        offset. Raises SceneError if they have states of another size, NumericsError if a march or, where travel times change,
        the orbit on another mesh fails."""
        closed, inverse = self._smooth_in(scenes)
        cycle, flows = closed.cycle, [closed.flow.of(scene) for scene in scenes]
        if any(flow.size != closed.flow.size for flow in flows):
            raise SceneError("at this value alone the state has fewer numbers than beside it")
        ends = np.array([flow.march(cycle.start, cycle.period).end for flow in flows])
        drift = np.array([*weights.values()]) @ ends
        slope = inverse[:, :-1] @ -drift
        total = dict[str, float]()
        for (offset, weight), flow in zip(weights.items(), flows, strict=True):
            moved = flow.march(cycle.start + offset * slope[:-1], cycle.period + offset * float(slope[-1]))
            for name, value in figures(replace(closed, flow=flow, cycle=moved)).items():
                total[name] = total.get(name, 0.0) + weight * value
        return total

    @cached_property
    def phase(self) -> PhaseResponse:
        """The phase response, by the last row of the inverse: the left eigenvector of the multiplier 1. NaN by the drive where a
        reduction's answer to a drive that changes is fitted only if it does."""
        closed, inverse = self._meshes[0]
        pulses = closed.flow.pulses(closed.cycle, inverse[-1, :-1])
        return PhaseResponse(pulses, closed.cycle.period, closed.flow.nodes)

    def first_order_up_to(self) -> Array:
        """The extra stress, and the extra velocity (V*) of the drive, (2,), up to which first order holds: for half a period from
        where that moves events most, it advances them by a term of second order that is a tenth of that of first order. From a
        small one, marched until the rest has decayed; NaN if the orbit is unstable or that lasts too long."""
        closed, inverse = self._meshes[0]
        flow, cycle, left, limits = closed.flow, closed.cycle, inverse[-1, :-1], np.full(2, np.nan)
        periods = math.log(_LEFT) / math.log(max(self._slowest, _LEFT)) if self._slowest < 1.0 else math.inf
        if periods > _MOST_PERIODS:
            return limits
        time, length = cycle.pieces.time[:-1], cycle.pieces.length[:-1, None]
        values = self.phase.at((time[:, None] + length * flow.nodes).ravel()).reshape(2, -1, flow.nodes.size)
        passed = np.cumsum((length * radau(flow.nodes.size).integral[-1] * values).sum(axis=2), axis=1)
        ends = np.searchsorted(time, time[time < time[-1] - 0.5 * cycle.period] + 0.5 * cycle.period)
        moved = passed[:, ends] - passed[:, : ends.size]
        for which in np.flatnonzero(np.isfinite(moved).all(axis=1)):
            begin = int(np.abs(moved[which]).argmax())
            first = float(moved[which, begin])
            size = _PUSHED * cycle.period / first
            push = Push(begin + 1, int(ends[begin]) + 1, *(size * np.eye(2)[which]))
            state, advance = flow.march(cycle.start, cycle.period, push).end, 0.0
            for _ in range(math.ceil(periods)):
                state = flow.march(state, cycle.period).end
            for _ in range(_MOST_PERIODS):
                gap = float(left @ (state - flow.march(cycle.start, cycle.period + advance).end))
                advance += gap
                if abs(gap) < _ALIGNED * cycle.period:
                    break
            limits[which] = 0.1 * abs(size * size * first / (advance - size * first))
        return limits

    def _smooth_in(self, scenes: Sequence[Scene]) -> tuple[Closed, Array]:
        """The orbit on its own mesh, or, where travel times change, on one of whose steps none is a whole number; and the inverse
        of its bordered matrix."""
        closed = self._meshes[0][0]
        if closed.flow.loosened(closed.cycle.start, scenes)[0] is closed.flow:
            return self._meshes[0]
        if len(self._meshes) == 1:
            loose = closed_between(closed, scenes)
            self._meshes.append((loose, _inverse(loose)))
        return self._meshes[1]


def _inverse(closed: Closed) -> Array:
    """The inverse of the bordered matrix."""
    velocity = closed.flow.velocity(closed.cycle)
    along, size = velocity / np.abs(velocity).max(), velocity.size
    matrix = np.block([[closed.monodromy - np.eye(size), velocity[:, None]], [along, np.zeros(1)]])
    with one_thread():
        return np.linalg.inv(matrix)
