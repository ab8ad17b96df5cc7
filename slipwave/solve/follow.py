"""March any solver to the end of a run, pass its pieces to the observers, and stop at the marks."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol, cast, runtime_checkable

import numpy as np

from slipwave.errors import NumericsError
from slipwave.friction import rate_of
from slipwave.observe.pieces import SAME, Pieces, lagrange_basis, values_at
from slipwave.solve.solver import Leaping, Solver


@dataclass(frozen=True)
class Final:
    """The interface at the end of a run: ln v (NaN if v <= 0), psi, mu."""

    ln_v: float
    psi: float
    mu: float


class Observer(Protocol):
    """Reads the pieces of a run. It is given every transit, unless it is also `Spanning`: then transits in which nothing happens
    may be left out. Where nothing but slow motion happens pieces may be as long as that is smooth."""

    def scan(self, pieces: Pieces) -> None:
        """Take the next pieces, in order."""


@runtime_checkable
class Spanning(Observer, Protocol):
    """An observer that does without transits in which nothing but sticking happens, at least for some time."""

    @property
    def whole_from(self) -> float:
        """The time (transits) from which on it needs every transit, as far as it knows; read again after each `scan`."""


class Mark(Protocol):
    """An action at certain times of a run."""

    @property
    def due(self) -> float:
        """The next time (transits); infinite if there is none."""

    def act(self) -> None:
        """Act. The solver is at the end of its first piece that ends at or beyond `due`, or at the end of the run."""


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
    solver leaps over slow motion, until the first observer needs every transit also where its pieces would not show the waves.

    Raises NumericsError with the time, the model and the scene's digest if the numbers stop being finite or a solve does not
    converge; the observers have then seen the pieces before that.
    """
    pieces: Pieces | None = None
    leaper = cast(Leaping, solver) if leaps and _offers(solver, Leaping) else None
    spanning = [cast(Spanning, one) for one in observers if _offers(one, Spanning)]
    patient = len(spanning) == len(observers)
    _act(solver, marks)
    while solver.time < until - SAME:
        stop = max(min([until, *(mark.due for mark in marks)]), solver.time + 2.0 * SAME)
        whole = min([until, *(one.whole_from for one in spanning)]) if patient else 0.0
        if leaper is None:
            pieces = solver.advance(stop)
        elif whole > solver.time + SAME:
            pieces = leaper.leap(min(stop, whole), whole, gaps=True)
        else:
            pieces = leaper.leap(stop, until, gaps=False)
        _require_finite(solver, pieces)
        for observer in observers:
            observer.scan(_before_failure(solver, pieces))
        _require_solved(solver, pieces)
        if progress is not None:
            progress(solver.time)
        _act(solver, marks)
    if pieces is None:
        raise NumericsError(f"{solver.model}: nothing to do: until = {until} is not after t = {solver.time}")
    return final_state(solver, pieces, until)


_known: dict[tuple[type, type], bool] = {}


def _offers(one: object, protocol: type) -> bool:
    """Whether it is an instance of the `protocol`; asked once for a class, because the question takes 0.1 ms."""
    kind = (type(one), protocol)
    if kind not in _known:
        _known[kind] = isinstance(one, protocol)
    return _known[kind]


def _act(solver: Solver, marks: Sequence[Mark]) -> None:
    for mark in marks:
        if mark.due <= solver.time + SAME:
            mark.act()


def _require_finite(solver: Solver, pieces: Pieces) -> None:
    if not math.isfinite(float(pieces.z.sum() + pieces.psi.sum() + pieces.mu.sum())):
        raise NumericsError(
            f"{solver.model}: the solution stopped being finite between t = {pieces.time[0]:.6g} and {solver.time:.6g} transits "
            f"(scene {solver.scene.name!r}, digest {solver.scene.digest})"
        )


def _before_failure(solver: Solver, pieces: Pieces) -> Pieces:
    """The pieces that end before the first failed solve; all of them if none failed."""
    if not solver.failures:
        return pieces
    good = pieces.time + pieces.length < _failed_at(solver, pieces)
    return Pieces(*(array[good] for array in pieces))


def _require_solved(solver: Solver, pieces: Pieces) -> None:
    if solver.failures:
        raise NumericsError(
            f"{solver.model}: {solver.failures} solves of the interface or of a step did not converge by t = {solver.time:.6g} "
            f"transits, the first at t = {_failed_at(solver, pieces):.6g}: what follows is not the scene's motion; use more "
            f"cells or a smaller cfl (scene {solver.scene.name!r}, digest {solver.scene.digest})"
        )


def _failed_at(solver: Solver, pieces: Pieces) -> float:
    """Time of the first failed solve if the solver knows it, else the beginning of `pieces`."""
    return float(pieces.time[0]) if math.isnan(solver.failed_at) else solver.failed_at


def final_state(solver: Solver, pieces: Pieces, until: float) -> Final:
    """The interface at `until` (transits), evaluated from the solver's latest `pieces`, which must contain that time."""
    z, psi, mu, _ = (float(value[0]) for value in values_at(pieces, lagrange_basis(solver.nodes), np.array([until])))
    v = rate_of(solver.scene.law, z)
    return Final(math.log(v) if v > 0 else math.nan, psi, mu)
