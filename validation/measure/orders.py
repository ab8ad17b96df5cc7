"""Observed orders of the full-wave families: climb a ladder of grids, fit every output's error. For the tests and the report.

Orders in space are those of full waves without error in time against the delay system (`climb_of`).

Errors are relative root mean squares. For an output the mean is over all complete cycles after the first quarter of the run (the
same on every grid), for the final state over 256 moments of the last transits (ln v, psi and mu, each relative to its range
there). A single error may change sign as it goes to zero; a mean square cannot.

A fixed rule selects the grids of a fit. The first is the coarsest from which on all errors are below 3^-order, that is, at least
three times finer than a grid whose error is 100 %. The last is the last one whose error is above the reference's own. Of these,
`validation.measure.order_fit.fit_dense` drops coarse ones where the errors do not follow a power law yet.

All outputs together must show the promised order within a confidence interval. A single output scatters more; its fitted order
may lie below the promised one by no more than the run's `slack`.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any, TypeAlias

import numpy as np

from reduced.delay.alike import Delay
from slipwave.errors import NumericsError, SceneError
from slipwave.observe import EventObserver, HistoryObserver
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from slipwave.solve import Solver, follow
from validation.measure.cycle import SYMBOLS
from validation.measure.grid_ladders import GridLadder, LadderRun, in_space, ladder_of
from validation.measure.order_fit import TREND, Fit, asked, fit_dense
from validation.models.build import build
from validation.models.by_name import explicit_time, grid_of

OUTPUTS = {name: symbol for name, symbol in SYMBOLS.items() if name != "v_min"}
"""The outputs of every cycle whose order is fitted, and their symbols."""

QUANTITIES = {**OUTPUTS, "state": "state"}
"""The quantities whose order is fitted: the outputs and the final state."""

_MOMENTS = 256
_FIRST_QUARTER = 0.25  # of the run: events still grow there, and one of a tenth of the largest counts on some grids only
ALMOST = 0.05  # a narrow interval may miss the promised order by this much: the curvature that is left
KNOWN = 0.5  # how far below the promised order the interval of all outputs may begin
RESOLVED = 3.0
_SMALL = 1e-9
_RESOLUTION, _STEPS = 1e-13, 32
"""Of the marches without error in time, and least steps of the delay system per transit: no quantity differs by more than 9e-13
from `dg:14` with 8 cells."""

Measured: TypeAlias = dict[str, Array]
"""Quantity -> one entry per complete cycle; for the state (256, 3): z, psi, mu."""
Maker: TypeAlias = Callable[..., Solver]
"""As `validation.models.build.build`."""


def measure(solver: Solver, run: LadderRun) -> Measured:
    """Run `solver` over the `run`."""
    events = EventObserver(solver.scene, solver.nodes)
    last = np.linspace(run.until - run.window, run.until, _MOMENTS, endpoint=False)
    history = HistoryObserver(solver.scene.law, solver.nodes, last[0], last[-1])
    follow(solver, run.until, [events, history])
    cycles = events.events(_FIRST_QUARTER * run.until)
    return {name: getattr(cycles, name) for name in OUTPUTS} | {"state": history.at(last)[1:4].T}


def errors(ours: Measured, reference: Measured) -> dict[str, float]:
    """Relative root-mean-square error of every quantity; infinite for outputs of a run with another number of cycles."""
    distances = {}
    for name in OUTPUTS:
        alike = ours[name].shape == reference[name].shape
        distances[name] = _mean_square(ours[name] / reference[name] - 1.0) if alike else np.inf
    distances["state"] = _mean_square((ours["state"] - reference["state"]) / np.ptp(reference["state"], axis=0))
    return distances


def _mean_square(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


@dataclass(frozen=True)
class Climb:
    """Result of a climb: cells, and errors by quantity, one entry per grid."""

    ladder: GridLadder
    cells: Array
    errors: dict[str, Array]

    @cached_property
    def fits(self) -> dict[str, Fit]:
        """The order of each quantity, and "together" that of the geometric mean of all errors, over the levels where each is
        above the floor; it scatters least. ValueError where fewer than four levels can be used."""
        every, floor = np.array([*self.errors.values()]), self.ladder.run.floor
        coarse = np.nonzero(~(every.max(axis=0) < RESOLVED**-self.ladder.declared))[0]
        first = int(coarse[-1]) + 1 if coarse.size else 0
        every = every[:, : int(np.cumprod((every > floor).all(axis=0)).sum())]
        together = fit_dense(self.cells, np.exp(np.log(every).mean(axis=0)), first)
        return {name: fit_dense(self.cells, errors, first, floor) for name, errors in self.errors.items()} | {
            "together": together
        }

    @property
    def lost(self) -> str:
        """Why no order can be fitted; empty if one can."""
        try:
            return "" if self.fits else "no quantity"
        except ValueError as error:
            return str(error)

    @property
    def at_rounding(self) -> bool:
        """Whether every error of the finest grid is small enough, whatever the order."""
        return bool(self.cells.size) and max(float(values[-1]) for values in self.errors.values()) < _SMALL

    def shortfall(self) -> list[str]:
        """The reasons against the promised order, one per quantity; empty if there are none. Schemes of order 2 must not be
        better either. The finest error of every quantity must lie below the ladder's bound."""
        if self.lost:
            return [f"together: {self.lost}"]
        slack = self.ladder.run.slack
        complaints = {name: self._misses(fit, 0.0, slack) for name, fit in self.fits.items()}
        together = self.fits["together"]
        complaints["together"] = self._misses(together, together.half_width, ALMOST) or self._unknown(together)
        return [f"{name}: {complaint}" for name, complaint in complaints.items() if complaint]

    @property
    def against_promise(self) -> tuple[str, float, float]:
        """(text of the required order of all outputs together, distance from it, allowed distance); for a scheme whose local
        orders rise to the promised one, of the order to which they lead."""
        fit = self.fits["together"]
        order, allowed = fit.order, max(fit.half_width, ALMOST)
        if order + allowed < self._promised and fit.leads_to(self._promised):
            order, allowed = fit.limit, TREND
        return *asked(order, self._promised, allowed, not self._exact), allowed

    def _misses(self, fit: Fit, half_width: float, slack: float) -> str:
        """Whether the order within +- `half_width` misses the promised one by more than `slack`, or the errors are large."""
        allowed = max(half_width, slack)
        short = fit.order + allowed < self._promised and not fit.leads_to(self._promised)
        if short or (self._exact and fit.order - allowed > self._promised):
            return f"promised {self._promised:g}, observed {fit}"
        if fit.finest_error > self.ladder.finest:
            return f"finest error {fit.finest_error:.1e}, not below {self.ladder.finest:.0e}"
        return ""

    def _unknown(self, fit: Fit) -> str:
        low, high = fit.order - fit.half_width, fit.order + fit.half_width
        vague = low < self._promised - KNOWN or (self._exact and high > self._promised + KNOWN)
        return f"interval too wide to tell: {fit}" if vague else ""

    @property
    def _exact(self) -> bool:
        return self.ladder.declared == 2.0

    @property
    def _promised(self) -> float:
        return 2.0 if self._exact else self.ladder.promised


def climb(ladder: GridLadder, reference: Measured, make: Maker) -> Climb:
    """Run every grid of the `ladder` up to the first whose state is at the floor; grids too coarse to run are left out."""
    rows = dict[int, dict[str, float]]()
    for cells in ladder.levels():
        try:
            solver = make(ladder.model, ladder.run.scene, cells=cells, cfl=ladder.cfl)
            rows[cells] = errors(measure(solver, ladder.run), reference)
        except (NumericsError, SceneError):
            continue
        if rows[cells]["state"] < ladder.run.floor:
            break
    by_quantity = {name: np.array([row[name] for row in rows.values()]) for name in QUANTITIES}
    return Climb(ladder, np.array([*rows], dtype=float), by_quantity)


def climb_of(model: str) -> Climb:
    """Errors of the family without error in time (except for the leapfrog)."""
    ladder = in_space(ladder_of(*grid_of(model)))
    return climb(ladder, delay_reference(ladder.run), without_error_in_time)


@cache
def delay_reference(run: LadderRun) -> Measured:
    """The outputs of the delay system over the `run`."""
    return measure(Delay(run.scene, steps=_STEPS, tolerance=_RESOLUTION), run)


def without_error_in_time(model: str, scene: Scene, cells: int, resolution: float = _RESOLUTION, **options: Any) -> Solver:
    """The full wave `model` with its exact march, in steps that resolve friction to `resolution`. At order 2 as `build` makes it
    with `options`: grids are large, and explicit steps of order 4 leave 3 % of the error in space on 48 cells, less on finer."""
    family, number = grid_of(model)
    if family.order_interface(number) <= 2:
        return build(model, scene, cells=cells, **options, time=explicit_time(model))
    solver: Solver = family.maker()(scene, number, cells=cells, time="exact", resolution=resolution)
    return solver
