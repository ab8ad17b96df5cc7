"""The final motion of a model in a scene: its regime in words, and the figures of its cycles, if any."""

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

from slipwave.errors import NumericsError
from slipwave.observe import EventObserver, Events
from slipwave.observe.pieces import Array
from slipwave.observe.statistics import Estimate, mean_of, median_of
from slipwave.scene import Scene
from validation.compute.build import build
from validation.compute.models import one_port_of
from validation.compute.run import reconsidered, simulate
from validation.compute.settle import estimate
from validation.measure.cycle import SYMBOLS
from validation.study import Number, stated
from validation.study.memo import LATE_TOLERANCE, TRANSIENT, kept, own_orbit

if TYPE_CHECKING:
    from xarray import Dataset

STEADY, AWAY, UNDECIDED, UNTRIED = "slides steadily", "runs away", "undecided", "–"
"""Regimes besides "periodic", "torus" and "irregular"; the last one: the model was not tried in the scene."""
UNKNOWN = {UNDECIDED, UNTRIED}
_WORDS = {"steady": STEADY, "decaying": STEADY, "settling": UNDECIDED, "growing": UNDECIDED, "too short": UNDECIDED}
"""Verdict on a run -> its name in tables of models, if different."""

FIGURES = {SYMBOLS[name]: name for name in ("period", "stress_drop", "v_max")}
"""Symbol of a figure of cycles, as in tables of models -> its name in `Orbit` and `Events`."""


class Regime(NamedTuple):
    """`words`: "periodic" (with its events, if several), "torus", "irregular", or one of the words above; `figures` of its
    cycles by symbol (transits, σ, V*), with the errors of an orbit's computation or the standard errors of means, empty if it has
    none; `cycles`: number of cycles of the means, 0 for a repeating motion; `ran`: figures of the run's last cycles where its
    `figures` are those of an orbit by Newton's method."""

    words: str
    figures: dict[str, Estimate] = {}  # noqa: RUF012
    cycles: int = 0
    ran: dict[str, Estimate] = {}  # noqa: RUF012

    def agrees(self, other: "Regime") -> bool:
        """Whether both are the same, as far as both are decided."""
        return self.words == other.words or not {self.words, other.words}.isdisjoint(UNKNOWN)


@kept
def regime_of(model: str, scene: Scene, until: float, cells: int | None = None, tolerance: float | None = None) -> Regime:
    """The regime of a run of `model` to `until` (transits). Figures are means over the cycles after the transient (of the largest
    slip rate, whose tail is heavy, the median); for a motion that repeats, those of the last cycles or, if a `tolerance` is
    given, of its stable orbit by Newton's method. A run whose numerics fail counts as running away: no step is short enough for
    unbounded rates."""
    solver = build(model, scene, tolerance=LATE_TOLERANCE) if cells is None else build(model, scene, cells=cells)
    watch = EventObserver(solver.scene, solver.nodes)
    run = reconsidered(simulate(solver, until, watch=watch), one_port_of(model))
    kind, events = run.kind, (run.verdict.multiplicity if run.verdict else None) or 1
    if run.failed or kind is None:
        return Regime(AWAY)
    orbit = _stable_orbit(model, scene, tolerance, cells) if tolerance and kind in ("periodic", "settling") else {}
    ran = _repeating(watch.events(0.5 * until), events) if kind == "periodic" else {}
    if orbit and events == 1:
        return Regime("periodic", orbit, 0, ran)
    if ran:
        return Regime("periodic" if events == 1 else f"periodic, {events} events", ran)
    if kind in ("torus", "irregular"):
        late = watch.events(TRANSIENT)
        return Regime(kind, _figures(late, mean_of) | {"v_{max}": median_of(late.v_max)}, late.period.size)
    return Regime(_WORDS.get(kind, kind))


def _figures(of: Any, measure: Callable[[Any], Estimate] = lambda value: value) -> dict[str, Estimate]:
    return {symbol: measure(getattr(of, name)) for symbol, name in FIGURES.items()}


def _repeating(cycles: Events, events: int) -> dict[str, Estimate]:
    """Figures of the last cycles: of one, or means over the last period of several `events`, with their change since the period
    before as error."""
    if events == 1:
        return _figures(estimate(cycles))
    last, before = (_figures(cycles, partial(_mean, past)) for past in (slice(-events, None), slice(-2 * events, -events)))
    return {symbol: Estimate(mean.value, abs(mean.value - before[symbol].value)) for symbol, mean in last.items()}


def _mean(past: slice, values: Array) -> Estimate:
    return Estimate(float(values[past].mean()), 0.0)


def _stable_orbit(model: str, scene: Scene, tolerance: float, cells: int | None) -> dict[str, Estimate]:
    try:
        found = own_orbit(model, scene, tolerance, cells)
    except NumericsError:
        return {}
    return _figures(found.orbit) if found.multipliers.stable else {}


def regime_areas(differences: "Dataset", rows: Sequence[Mapping[str, Any]]) -> dict[str, Number]:
    """The share of a map's area in which a model has another regime, in per cent, from the `rows` of its differences. The
    name contains the lattice, because shares on different lattices are not compared; the error is one point of it."""
    sizes = [size for name, size in differences.sizes.items() if name != "model"]
    lattice = " x ".join(map(str, sizes))
    return {
        f"{row['model']} other regime, {lattice} points": stated(
            row["other_regime_percent"], 1e4 / (math.prod(sizes) * row["compared_percent"])
        )
        for row in rows
    }
