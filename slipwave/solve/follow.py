"""March any solver to the end of a run, pass its pieces to the observers, and stop at the marks.

The run time is predicted (`Foresight`); runs that would take days are refused. The work is counted, not timed.

A solver states the cost of a piece (`seconds_per_piece`, measured on one machine and right within a factor of a few) and, if its
steps are fixed, the length of its pieces (`transits_per_piece`). If its steps adapt, the pieces of the run so far are counted.

Observers that a scene records by name: `run.record = ["events", "NAME"]`.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Protocol, TypeGuard, cast, runtime_checkable

import numpy as np

from slipwave.errors import NumericsError, SceneError
from slipwave.friction import allows_rest, rate_of, said_of_edge, said_of_rest
from slipwave.observe.history import values_at
from slipwave.observe.pieces import Pieces, lagrange_basis, slack
from slipwave.scene.recorded import OBSERVERS
from slipwave.solve.solver import Cutting, FieldSolver, Leaping, Resumable, Solver


@dataclass(frozen=True)
class Final:
    """The interface at the end of a run: ln v (NaN if v <= 0), psi, mu, v (V*)."""

    ln_v: float
    psi: float
    mu: float
    v: float


class Observer(Protocol):
    """Reads the pieces of a run: of every transit, unless it is also `Spanning`, for which transits of slow motion may be left
    out, or their waves. In slow motion a piece may cover many transits."""

    def scan(self, pieces: Pieces) -> None:
        """Take the next pieces, in order."""


@runtime_checkable
class Spanning(Observer, Protocol):
    """An observer that allows gaps (transits of pure stick that are left out), at least for some time."""

    @property
    def whole_from(self) -> float:
        """The time (transits) from which on it needs every transit; asked again after each `scan`."""


class Mark(Protocol):
    """An action at certain times of a run."""

    @property
    def due(self) -> float:
        """The next time (transits); infinite if there is none."""

    def act(self) -> None:
        """Do it. The solver is at the end of its first piece that ends at or beyond `due`, or at the end of the run."""


def follow(
    solver: Solver,
    until: float,
    observers: Sequence[Observer] = (),
    progress: Callable[[float], None] | None = None,
    marks: Sequence[Mark] = (),
    leaps: bool = True,
) -> Final:
    """March `solver` to `until` (transits); returns the interface's state there, from the last piece's polynomial. When a mark is
    due, all observers have seen all earlier pieces; marks due together act in their order. If `leaps` are allowed, a `Leaping`
    solver leaps over slow motion, with gaps as long as every observer allows them.

    Raises NumericsError with the time, the model and the scene's digest if the numbers stop being finite or a solve does not
    converge; the observers have then seen the pieces before that.
    """
    pieces: Pieces | None = None
    law = solver.scene.law
    leaper = cast(Leaping, solver) if leaps and offers(solver, Leaping) else None
    spanning = [cast(Spanning, observer) for observer in observers if offers(observer, Spanning)]
    patient = len(spanning) == len(observers)
    _act(solver, marks)
    while solver.time < until - slack(until):
        stop = max(min([until, *(mark.due for mark in marks)]), solver.time + 2.0 * slack(solver.time))
        whole = min([until, *(observer.whole_from for observer in spanning)]) if patient else 0.0
        if leaper is None:
            pieces = solver.advance(stop)
        elif whole > solver.time + slack(solver.time):
            pieces = leaper.leap(min(stop, whole), whole, gaps=True)
        else:
            pieces = leaper.leap(stop, until, gaps=False)
        if offers(solver, Cutting):
            pieces = cast(Cutting, solver).cut(pieces, until)
        motion = pieces.z, pieces.psi, pieces.mu
        finite = all(np.isfinite(values).all() for values in motion)  # no BLAS: its threads wake for it
        if not finite or not (allows_rest(law) or np.abs(pieces.z).max() < _LARGEST):
            rest = said_of_rest(law, pieces.mu, float(pieces.z[0, 0]), float(pieces.psi[0, 0]))
            raise NumericsError(
                f"{solver.model}: the solution stopped being finite between t = {pieces.time[0]:.6g} and {solver.time:.6g} "
                f"transits{rest} (scene {solver.scene.name!r}, digest {solver.scene.digest})"
            )
        good, failed_at = pieces, solver.failed_at
        if solver.failures:
            failed_at = float(pieces.time[0]) if math.isnan(failed_at) else failed_at
            good = pieces.part(pieces.time + pieces.length < failed_at)
        for observer in observers if good.time.size else ():
            observer.scan(good)
        if solver.failures:
            first = min(good.time.size, pieces.time.size - 1), 0
            advice = said_of_edge(law, float(pieces.z[first]), float(pieces.psi[first]))
            raise NumericsError(
                f"{solver.model}: {solver.failures} solves of the interface or of a step did not converge by t = "
                f"{solver.time:.6g} transits, the first at t = {failed_at:.6g}: what follows is not the scene's motion; "
                f"{advice or 'use more cells or a smaller cfl'} (scene {solver.scene.name!r}, digest {solver.scene.digest})"
            )
        if progress is not None:
            progress(solver.time)
        _act(solver, marks)
    if pieces is None:
        raise NumericsError(f"{solver.model}: nothing to do: until = {until} is not after t = {solver.time}")
    return _final_state(solver, pieces, until)


def _act(solver: Solver, marks: Sequence[Mark]) -> None:
    for mark in marks:
        if mark.due <= solver.time + slack(solver.time):
            mark.act()


def _final_state(solver: Solver, pieces: Pieces, until: float) -> Final:
    """The interface at `until` (transits), evaluated from the solver's latest `pieces`, which must contain that time."""
    if solver.nodes[-1] == 1.0 and abs(until - pieces.time[-1] - pieces.length[-1]) < _AT_END:  # as a rule: nothing to evaluate
        z, psi, mu = (float(values[-1, -1]) for values in pieces[2:5])
    else:
        state = values_at(pieces, lagrange_basis(solver.nodes), np.array([until]), solver.scene.law)
        z, psi, mu, _ = (float(value[0]) for value in state)
    v = rate_of(solver.scene.law, z)
    return Final(math.log(v) if v > 0 else math.nan, psi, mu, v)


DAY = 86400.0
_AT_END = 1e-12  # transits
_LARGEST = 700.0  # |ln v|: little more is zero or infinite as a number
_ENOUGH = 20_000  # pieces, some 0.1 s; from then on their number per transit is extrapolated to the rest of the run


def require_time(solver: Solver, until: float, most: float = DAY) -> float:
    """Predicted run time (s) of `solver` to `until` (transits), NaN unless its steps are fixed. Raises SceneError if it is more
    than `most` seconds."""
    length = solver.transits_per_piece
    if math.isnan(length):
        return math.nan
    return _require(solver, until, (until - solver.time) / length if length > 0.0 else math.inf, most)


class Foresight:
    """Observer of a run to `until` (transits); raises SceneError when it predicts more than `most` seconds for the run."""

    whole_from = math.inf

    def __init__(self, solver: Solver, until: float, most: float = DAY) -> None:
        self.until, self._solver, self._most = until, solver, most
        self._pieces, self._next = 0, _ENOUGH
        self._began = self._reached = math.nan

    def scan(self, pieces: Pieces) -> None:
        """Count the next pieces of the run."""
        self._began = float(pieces.time[0]) if math.isnan(self._began) else self._began
        self._reached = float(pieces.time[-1] + pieces.length[-1])
        self._pieces += pieces.time.size
        if self._pieces >= self._next:
            self._next *= 2
            _require(self._solver, self.until, self._expected(self.until), self._most)

    def seconds(self, until: float) -> float:
        """Predicted run time (s) from the start of this run to `until` (transits), from its pieces so far; 0 before the first."""
        return self._expected(until) * self._solver.seconds_per_piece if self._pieces else 0.0

    def _expected(self, until: float) -> float:
        return self._pieces * (until - self._began) / (self._reached - self._began)


def in_days(seconds: float) -> str:
    """A run time in words, of days or longer."""
    some = f"{seconds / (365 * DAY):.2g} years" if seconds > 365 * DAY else f"{seconds / DAY:.3g} days"
    return some if seconds < 1e4 * 365 * DAY else "more than ten thousand years"


def _require(solver: Solver, until: float, pieces: float, most: float) -> float:
    """The predicted run time (s) of so many `pieces`, as `require_time`."""
    seconds = pieces * solver.seconds_per_piece
    if seconds > most:
        raise SceneError(
            f"model {solver.model}: {until:g} transits would take about {in_days(seconds)} "
            f"({pieces * (solver.nodes.size - 1):.2g} samples of the interface): "
            f"run fewer transits, or use fewer cells or a larger cfl; --yes runs them anyway"
        )
    return seconds


class NamedObserver(Observer, Resumable, Protocol):
    """An observer that adds `figures` to the results of a run and continues from checkpoints."""

    def figures(self) -> Mapping[str, float | None]:
        """Name -> value, of the run so far; None or NaN where there is none yet."""


def named_observers(solver: Solver) -> dict[str, NamedObserver]:
    """A new observer for each name that the solver's scene records."""
    made: dict[str, NamedObserver] = {}
    for name in sorted(solver.scene.record & OBSERVERS.keys()):
        module, _, kind = OBSERVERS[name].partition(":")
        made[name] = getattr(import_module(module), kind)(solver.scene, solver.nodes)
    return made


_known: dict[tuple[type, type], bool] = {}


def offers(candidate: object, protocol: type) -> bool:
    """Whether `candidate` is an instance of `protocol`; cached by class, because isinstance of a protocol takes 0.1 ms."""
    kind = (type(candidate), protocol)
    if kind not in _known:
        _known[kind] = isinstance(candidate, protocol)
    return _known[kind]


def has_fields(solver: Solver) -> TypeGuard[FieldSolver]:
    """Whether `solver` is a full wave."""
    return offers(solver, FieldSolver)
