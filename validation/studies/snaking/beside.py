"""Direct runs beside the special points of a branch: each begins on an orbit on one side of the point, a little off it in the
direction of the multiplier that passes there, and shows that multiplier by how it departs or comes back."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from reduced.continuation.point import Point
from reduced.continuation.special import Special, critical
from reduced.orbit.closing import Closed
from slipwave.observe import HistoryObserver
from slipwave.observe.pieces import Array
from slipwave.solve import follow
from validation.registry.build import build
from validation.registry.orbit_start import BEGIN, state_on
from validation.study.over_r import Branch

_CYCLES = 4
_OFF = 1e-6  # largest component of the state by which a run is off its orbit
_SAMPLES = 300  # of a cycle
_REAL = 1e-9  # imaginary part below which a multiplier is real


class Side(NamedTuple):
    """An orbit beside a special point, at `log10_r`: the multiplier that passes there, of the `orbit` and as `seen` in runs."""

    log10_r: float
    orbit: complex
    seen: complex

    @property
    def apart(self) -> float:
        """Relative difference of both multipliers."""
        return abs(self.seen / self.orbit - 1.0)


def sides(branch: Branch, first: int = 0, every: int = 1) -> list[tuple[Special, Side, Side]]:
    """Special points of the delay branch, every so many from the `first` on, each with its two sides: the next points."""
    places = {id(point): n for n, point in enumerate(branch.points)}
    found = []
    for special in branch.special[first::every]:
        place = places[id(special.point)]
        before, beyond = (_side(branch.points[n], special.kind) for n in (place - 1, place + 1))
        found.append((special, before, beyond))
    return found


def _side(point: Point, kind: str) -> Side:
    closed = point.closed
    passing, direction = _passing(closed, kind)
    apart = _cycles(closed, _OFF * direction) - _cycles(closed, -_OFF * direction)
    return Side(point.parameter, passing, multiplier_seen(apart, abs(passing.imag) > _REAL))


def _passing(closed: Closed, kind: str) -> tuple[complex, Array]:
    """The multiplier that passes at a point of `kind`, and the real part of its eigenvector, with 1 as the largest component."""
    values, vectors = np.linalg.eig(closed.monodromy)
    others = np.delete(values, np.abs(values - 1.0).argmin())
    passing = critical(kind, others.astype(complex))
    vector = vectors[:, np.abs(values - passing).argmin()].real
    return passing, vector / np.abs(vector).max()


def _cycles(closed: Closed, change: Array) -> Array:
    """z and psi (cycles, 2 samples) in the cycles of a run that begins on the orbit, but for a `change` of its state."""
    cycle, period = closed.flow.march(closed.cycle.start + change, closed.cycle.period), closed.cycle.period
    solver = build("delay", closed.flow.scene, tolerance=1e-11)
    solver.restore(state_on(solver, replace(closed, cycle=cycle)))
    history = HistoryObserver(solver.scene.law, solver.nodes)
    times = BEGIN + 1.0 + np.linspace(0.0, period, _SAMPLES, endpoint=False)
    follow(solver, float(times[-1]) + _CYCLES * period, [history])
    return np.array([history.at(times + n * period)[1:3].ravel() for n in range(_CYCLES + 1)])


def multiplier_seen(apart: Array, turns: bool) -> complex:
    """The multiplier m with which the distance `apart` (cycles, values) of two runs changes from cycle to cycle: d_(n+1) = m d_n,
    or for a pair, if it `turns`, d_(n+2) = 2 Re(m) d_(n+1) - |m|^2 d_n."""
    first, second = apart[:-1].ravel(), apart[1:].ravel()
    if not turns:
        return complex(second @ first / (first @ first))
    before = np.column_stack([apart[1:-1].ravel(), -apart[:-2].ravel()])
    twice, square = np.linalg.lstsq(before, apart[2:].ravel(), rcond=None)[0]
    return complex(0.5 * twice, np.sqrt(max(square - 0.25 * twice**2, 0.0)))
