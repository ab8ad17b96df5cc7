"""Closes a motion: the state x after a period T equals that at the start. Equations for x, T and, if free, a parameter p:

    x(T; x_0, p) - x_0 = 0,     f . (x_0 - x_guess) = 0,     w . (u - u_guess) = 0,     u = (x_0, T, p), f = dx/dT at the guess.

The second fixes the start on the orbit; the third, with p free, the orbit in its family (`reduced.continuation`). The derivative
with respect to x_0 is the monodromy matrix. Those with respect to T and p are derivatives of the discrete motion, like the
residual. An error in the former displaces folds; an error of 1e-6 in the latter, a one-sided difference, does not slow Newton's
method. There the Jacobian is kept, with Broyden's (1965) updates, while the residual contracts; steps are shortened until they
reduce it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Generic, NamedTuple, TypeVar

import numpy as np

from slipwave.errors import NumericsError
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from slipwave.step.flow import Cycle, Flow
from slipwave.threads import one_thread

_MOST_ITERATIONS = 25
_MOST_HALVINGS = 6
_SERVES = 0.25  # reduction of the residual from which the corrected derivative serves again
_STALLED = 0.5  # reduction that counts as none
_ROUNDING = 1e-9  # residuals that no longer shrink are accepted below this

_SHORTER = 1.0, 1.25, 1.6, 2.0, 2.5, 3.0  # numbers of steps that are tried, relative

_Motion = TypeVar("_Motion")

CLOSES_TO = 1e-12
_NEAR = 1e-7  # a monodromy matrix taken this near to the orbit counts as the orbit's own
_BY_PARAMETER = 1e-7  # relative change in the difference
_SMALL = 1e-3  # parameter, or its unit if that is smaller, below which it is not relative: rounding errors stay small at zero


class Evaluated(NamedTuple, Generic[_Motion]):
    """The `residual` (m,) of the equations at `unknowns` u (m,), and the `motion` from which it follows."""

    unknowns: Array
    residual: Array
    motion: _Motion

    @property
    def size(self) -> float:
        """The largest residual."""
        return float(np.abs(self.residual).max())


def _solve_by_newton(
    evaluate: Callable[[Array], Evaluated[_Motion]],
    derivative: Callable[[Evaluated[_Motion]], Array],
    guess: Array,
    tolerance: float,
    near: float,
    first: Array | None = None,
) -> tuple[Evaluated[_Motion], Array, int]:
    """The equations at unknowns near `guess` at which the largest residual is below `tolerance` or no longer shrinks by rounding,
    a derivative (m, m) evaluated within a distance (largest change of an unknown) of `near`, and the number of iterations.
    `first`: a derivative to start with, from a nearby point.

    Raises NumericsError if there is no convergence, and the errors of `evaluate` at the guess.
    """

    def finished(iterations: int) -> tuple[Evaluated[_Motion], Array, int]:
        return now, derivative(now) if taken is None or away >= near else taken, iterations

    now, away, taken, matrix = evaluate(guess), np.inf, first, first
    for iteration in range(_MOST_ITERATIONS):
        if now.size <= tolerance:
            return finished(iteration)
        if matrix is None:
            taken = matrix = derivative(now)
            away = 0.0
        fresh = away == 0.0
        try:
            with one_thread():
                step = np.linalg.solve(matrix, -now.residual)
        except np.linalg.LinAlgError:
            step = np.full_like(now.residual, np.nan)
        if not np.isfinite(step).all():
            raise NumericsError("the linearised equations are singular")
        new = _shortened(evaluate, now, np.asarray(step), fresh)
        if not new.size < _STALLED * now.size and now.size < _ROUNDING:
            return finished(iteration)
        if new.size < _SERVES * now.size:  # Broyden: the nearest matrix that gives the change of the residual along the step
            along = new.unknowns - now.unknowns
            matrix = matrix + np.outer(new.residual - now.residual - matrix @ along, along / (along @ along))
        else:
            matrix = None
        if fresh or new.size < now.size:  # otherwise once more from here, with a derivative of its own
            away += float(np.abs(new.unknowns - now.unknowns).max())
            now = new
    raise NumericsError(f"no convergence in {_MOST_ITERATIONS} iterations: a residual of {now.size:.2g} is left")


def _shortened(
    evaluate: Callable[[Array], Evaluated[_Motion]], now: Evaluated[_Motion], step: Array, fresh: bool
) -> Evaluated[_Motion]:
    """The equations after `step` or, if that does not reduce the residual although the derivative is `fresh`, after the best of
    its halves, quarters ... Raises NumericsError if none of them can be evaluated."""
    best: Evaluated[_Motion] | None = None
    for halving in range(_MOST_HALVINGS):
        try:
            new = evaluate(now.unknowns + 0.5**halving * step)
        except NumericsError:
            continue
        best = new if best is None or new.size < best.size else best
        if not fresh or new.size < now.size or now.size < _ROUNDING:
            return best
    if best is None:
        raise NumericsError("no motion can be computed along Newton's step")
    return best


FlowAt = Callable[[float], Flow]
"""The flow at a value of the parameter."""


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


@dataclass(frozen=True)
class _Equations:
    """The equations above for `guess`, (x_0, T) if there are no `weights` w and else (x_0, T, p), with f = `along`, scaled.
    `unit`: a typical change of p."""

    flow_at: FlowAt
    guess: Array
    parameter: float
    weights: Array | None
    along: Array
    unit: float

    def evaluate(self, unknowns: Array) -> Evaluated[tuple[Flow, Cycle]]:
        """The residual of the equations, by a march over the period."""
        n = self.along.size
        start, time, period = unknowns[:n], float(unknowns[n]), self.guess[n]
        if not 0.5 * period < time < 2.0 * period:
            raise NumericsError(f"a period of {time:.6g} transits is far from {period:.6g}, where the search began")
        flow = self.flow_at(self.parameter if self.weights is None else float(unknowns[-1]))
        cycle = flow.march(start, time)
        border = [float(self.along @ (start - self.guess[:n]))]
        if self.weights is not None:
            border.append(float(self.weights @ (unknowns - self.guess)))
        residual = np.concatenate([cycle.end - start, border])
        if not np.isfinite(residual).all():
            raise NumericsError(f"the motion over {time:.6g} transits is not finite")
        return Evaluated(unknowns, residual, (flow, cycle))

    def derivative(self, at: Evaluated[tuple[Flow, Cycle]]) -> Array:
        """The derivative of the residual, after a march."""
        flow, cycle = at.motion
        drift = [] if self.weights is None else [by_parameter(self.flow_at, cycle, float(at.unknowns[-1]), self.unit)]
        return self.bordered(flow.tangent(cycle), flow.velocity(cycle), *drift)

    def bordered(self, monodromy: Array, *columns: Array) -> Array:
        """The derivative from the monodromy matrix and the columns of period and parameter."""
        border = np.append(self.along, np.zeros(len(columns)))
        rows = [np.column_stack([monodromy - np.eye(self.along.size), *columns]), border]
        return np.vstack(rows if self.weights is None else [*rows, self.weights])


def close(flow: Flow, state: Array, period: float, tolerance: float = CLOSES_TO) -> Closed:
    """The orbit of `flow` near `state` and `period`. Raises NumericsError if Newton's method does not converge to one."""
    return close_family(lambda _: flow, state, period, tolerance=tolerance)


def closed_between(orbit: Closed, scenes: Sequence[Scene]) -> Closed:
    """`orbit` if its motion is smooth between these `scenes`; else the same orbit on a mesh where it is, closed to rounding, with
    its own monodromy matrix. Raises NumericsError as `close`."""
    if orbit.flow.loosened(orbit.cycle.start, scenes)[0] is orbit.flow:
        return orbit
    failed: NumericsError | None = None
    for shorter in _SHORTER:  # no step ends on the front of a slip event any more, which may need shorter ones
        flow, start = orbit.flow.remeshed(orbit.cycle, shorter)
        try:
            closed = close(*flow.loosened(start, scenes), orbit.cycle.period, 0.0)
        except NumericsError as error:
            failed = failed or error
            continue
        return replace(closed, monodromy=closed.flow.tangent(closed.cycle))
    assert failed is not None
    raise failed


def close_family(
    flow_at: FlowAt,
    state: Array,
    period: float,
    parameter: float = 0.0,
    weights: Array | None = None,
    tolerance: float = CLOSES_TO,
    neighbour: Closed | None = None,
    unit: float = 1.0,
) -> Closed:
    """The orbit near `state`, `period` and `parameter` of the flows `flow_at(parameter)`; on the plane through this guess that is
    orthogonal to `weights` (n + 2,), or at the given parameter if there are none; `unit`: a typical change of the parameter. The
    derivatives of a `neighbour` with the same unknowns save time.

    Raises NumericsError if Newton's method does not converge to an orbit."""
    n, flow = state.size, flow_at(parameter)
    along = flow.velocity(flow.march(state, period)) if neighbour is None else neighbour.velocity
    guess = np.concatenate([state, [period] if weights is None else [period, parameter]])
    equations = _Equations(flow_at, guess, parameter, weights, along / max(float(np.abs(along).max()), 1e-300), unit)
    known = None if neighbour is None else equations.bordered(neighbour.monodromy, neighbour.velocity, neighbour.drift)
    try:
        at, matrix, iterations = _solve_by_newton(equations.evaluate, equations.derivative, guess, tolerance, _NEAR, known)
    except NumericsError as reason:
        raise NumericsError(
            f"{flow.model}: no periodic orbit found near a period of {period:.6g} transits: {reason} (scene {flow.scene.name!r}, "
            f"digest {flow.scene.digest})"
        ) from None
    flow, cycle = at.motion
    residual, drift = float(np.abs(at.residual[:n]).max()), np.ravel(matrix[:n, n + 1 :])
    parameter = parameter if weights is None else float(at.unknowns[-1])
    return Closed(flow, cycle, residual, matrix[:n, :n] + np.eye(n), matrix[:n, n], drift, parameter, iterations)


def by_parameter(flow_at: FlowAt, cycle: Cycle, parameter: float, unit: float = 1.0) -> Array:
    """d end/d parameter (n,), from the other side where there is no scene beyond `parameter`, whose typical change is `unit`."""
    change = _BY_PARAMETER * max(abs(parameter), min(unit, _SMALL))
    try:
        flow = flow_at(parameter + change)
    except NumericsError:
        change = -change
        flow = flow_at(parameter + change)
    return (flow.march(cycle.start, cycle.period).end - cycle.end) / change
