"""Predicts how long a run will take, and refuses runs that would take days. The work is counted, not timed.

A solver states the cost of a piece (`seconds_per_piece`, measured on one machine and right within a factor of a few) and, if its
steps are fixed, the length of its pieces (`transits_per_piece`). If its steps adapt, the pieces of the run so far are counted.
"""

import math

from slipwave.errors import SceneError
from slipwave.observe.pieces import Pieces
from slipwave.solve.solver import Solver

DAY = 86400.0
_ENOUGH = 20_000  # pieces, some 0.1 s; from then on their number per transit is extrapolated to the rest of the run


def require_time(solver: Solver, until: float, most: float = DAY) -> None:
    """Raises SceneError if `solver` has fixed steps and needs more than `most` seconds to reach `until` (transits)."""
    length = solver.transits_per_piece
    if not math.isnan(length):
        _require(solver, until, (until - solver.time) / length if length > 0.0 else math.inf, most)


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
        """Predicted time of a run to `until` (transits) from where this one began, from the pieces so far; 0 before them."""
        return self._expected(until) * self._solver.seconds_per_piece if self._pieces else 0.0

    def _expected(self, until: float) -> float:
        return self._pieces * (until - self._began) / (self._reached - self._began)


def _require(solver: Solver, until: float, pieces: float, most: float) -> None:
    seconds = pieces * solver.seconds_per_piece
    if seconds > most:
        raise SceneError(
            f"model {solver.model}: {until:g} transits would take about {_in_words(seconds)} "
            f"({pieces * (solver.nodes.size - 1):.2g} samples of the interface): "
            f"run fewer transits, or use fewer cells or a larger cfl; --yes runs them anyway"
        )


def _in_words(seconds: float) -> str:
    if not seconds < 1e4 * 365 * DAY:
        return "more than ten thousand years"
    return f"{seconds / (365 * DAY):.2g} years" if seconds > 365 * DAY else f"{seconds / DAY:.3g} days"
