"""A motion that closes: its state x after a period T is that at the start. The equations for x, T and perhaps a parameter p:

    x(T; x_0, p) - x_0 = 0,     f . (x_0 - x_guess) = 0,     w . (u - u_guess) = 0,     u = (x_0, T, p), f = dx/dT at the guess.

The second is needed because every point of an orbit may be its start; the third, with p free, because orbits come in families
(`reduced.continuation`). The derivative with respect to x_0 is the monodromy matrix. Those with respect to T and p are
those of the discrete motion, so that they belong to the mesh as the residual does. The former enters the place of a fold; an
error of 1e-6 in the latter, a one-sided difference, costs Newton's method nothing.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from reduced.orbit.newton import solve
from slipwave.errors import NumericsError
from slipwave.observe.pieces import Array
from slipwave.step.flow import Cycle, Flow

TOLERANCE = 1e-12
_NEAR = 1e-7  # a monodromy matrix taken this near to the orbit counts as the orbit's own
_BY_PARAMETER = 1e-7  # relative change in the difference
_SMALL = 1e-3  # parameter below which the change is no longer relative, so that rounding errors stay small at zero


@dataclass(frozen=True)
class Closed:
    """A `cycle` of `flow` that closes to `residual` (largest component); its `monodromy` matrix (n, n); d end/d period,
    `velocity` (n,); d end/d parameter, `drift` (n,), empty if no parameter was free; the `parameter`; Newton's `iterations`."""

    flow: Flow
    cycle: Cycle
    residual: float
    monodromy: Array
    velocity: Array
    drift: Array
    parameter: float
    iterations: int

    @property
    def unknowns(self) -> Array:
        """u = (x_0, T, p)."""
        return np.concatenate([self.cycle.start, [self.cycle.period, self.parameter]])


class _At(NamedTuple):
    unknowns: Array
    residual: Array
    flow: Flow
    cycle: Cycle


def close(flow: Flow, state: Array, period: float, tolerance: float = TOLERANCE) -> Closed:
    """The orbit of `flow` near `state` and `period`. Raises NumericsError if Newton's method does not converge to one."""
    return close_family(lambda _: flow, state, period, tolerance=tolerance)


def close_family(
    flow_at: Callable[[float], Flow],
    state: Array,
    period: float,
    parameter: float = 0.0,
    weights: Array | None = None,
    tolerance: float = TOLERANCE,
    neighbour: Closed | None = None,
) -> Closed:
    """The orbit near `state`, `period` and `parameter` of the flows `flow_at(parameter)`; on the plane through this guess that is
    orthogonal to `weights` (n + 2,), or at the given parameter if there are none. The derivatives of a `neighbour` with the same
    unknowns save time.

    Raises NumericsError if Newton's method does not converge to an orbit."""
    free = weights is not None
    guess = np.concatenate([state, [period] if weights is None else [period, parameter]])
    along = neighbour.velocity if neighbour is not None else _motion(flow_at(parameter), state, period)
    scale = 1.0 / max(float(np.abs(along).max()), 1e-300)

    def evaluate(unknowns: Array) -> _At:
        """What is left of the equations, by a march over the period."""
        start, time = unknowns[: state.size], float(unknowns[state.size])
        if not 0.5 * period < time < 2.0 * period:
            raise NumericsError(f"a period of {time:.6g} transits is far from {period:.6g}, where the search began")
        flow = flow_at(float(unknowns[-1]) if free else parameter)
        cycle = flow.march(start, time)
        border = [scale * float(along @ (start - state))]
        if weights is not None:
            border.append(float(weights @ (unknowns - guess)))
        residual = np.concatenate([cycle.end - start, border])
        if not np.isfinite(residual).all():
            raise NumericsError(f"the motion over {time:.6g} transits is not finite")
        return _At(unknowns, residual, flow, cycle)

    def bordered(monodromy: Array, *columns: Array) -> Array:
        """The derivative of the equations, from the monodromy matrix and the columns of period and parameter."""
        border = np.zeros((1, guess.size))
        border[0, : state.size] = scale * along
        rows = [np.column_stack([monodromy - np.eye(state.size), *columns]), border]
        return np.vstack(rows if weights is None else [*rows, weights[None]])

    def derivative(at: _At) -> Array:
        """The derivative after a march."""
        columns = [at.flow.velocity(at.cycle)]
        if free:
            columns.append(by_parameter(flow_at, at.cycle, float(at.unknowns[-1])))
        return bordered(at.flow.tangent(at.cycle), *columns)

    known = bordered(neighbour.monodromy, neighbour.velocity, neighbour.drift) if neighbour is not None else None
    try:
        solved = solve(evaluate, derivative, guess, tolerance, _NEAR, known)
    except NumericsError as reason:
        flow = flow_at(parameter)
        raise NumericsError(
            f"{flow.model}: no periodic orbit found near a period of {period:.6g} transits: {reason} (scene {flow.scene.name!r}, "
            f"digest {flow.scene.digest})"
        ) from None
    n, matrix = state.size, solved.derivative
    return Closed(
        solved.at.flow,
        solved.at.cycle,
        float(np.abs(solved.at.residual[:n]).max()),
        matrix[:n, :n] + np.eye(n),
        matrix[:n, n],
        matrix[:n, n + 1] if free else np.empty(0),
        float(solved.at.unknowns[-1]) if free else parameter,
        solved.iterations,
    )


def by_parameter(flow_at: Callable[[float], Flow], cycle: Cycle, parameter: float) -> Array:
    """d end/d parameter (n,)."""
    change = _BY_PARAMETER * max(abs(parameter), _SMALL)
    return np.asarray((flow_at(parameter + change).march(cycle.start, cycle.period).end - cycle.end) / change)


def _motion(flow: Flow, state: Array, period: float) -> Array:
    return flow.velocity(flow.march(state, period))
