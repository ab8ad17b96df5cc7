"""The final motion of a model in a scene: its regime in words, and the figures of its cycles, if any."""

import math
from typing import TYPE_CHECKING, NamedTuple

from slipwave.errors import NumericsError
from slipwave.observe import EventObserver, Events
from slipwave.observe.statistics import Estimate, Orbit, mean_of
from slipwave.scene import Scene
from validation.compute.build import build
from validation.compute.models import one_port_of
from validation.compute.run import reconsidered, simulate
from validation.compute.settle import estimate
from validation.study import Number, stated
from validation.study.memo import LATE_TOLERANCE, TRANSIENT, kept, own_orbit

if TYPE_CHECKING:
    from xarray import Dataset

STEADY, AWAY, UNDECIDED = "slides steadily", "runs away", "undecided"
_WORDS = {"steady": STEADY, "decaying": STEADY, "settling": UNDECIDED, "growing": UNDECIDED, "too short": UNDECIDED}
"""Verdict on a run -> its name in tables of models, if different."""


class CycleFigures(NamedTuple):
    """Period (transits), stress drop (σ) and largest slip rate (V*) with their errors: of an orbit those of its computation, of
    a mean its standard error."""

    period: Estimate
    drop: Estimate
    v_max: Estimate

    @classmethod
    def of(cls, orbit: Orbit) -> "CycleFigures":
        """The figures of an orbit."""
        return cls(orbit.period, orbit.stress_drop, orbit.v_max)


class Regime(NamedTuple):
    """`words`: "periodic" (with its events, if several), "torus", "irregular", or one of the words above; `figures` of its
    cycles, None if it has none; `cycles`: number of cycles of the means, 0 for a repeating motion."""

    words: str
    figures: CycleFigures | None = None
    cycles: int = 0

    def agrees(self, other: "Regime") -> bool:
        """Whether both are the same, as far as both are decided."""
        return self.words == other.words or UNDECIDED in (self.words, other.words)


@kept
def regime_of(model: str, scene: Scene, until: float, cells: int | None = None, tolerance: float | None = None) -> Regime:
    """The regime of a run of `model` to `until` (transits). Figures are means over the cycles after the transient; for a motion
    that repeats, those of the last cycles or, if a `tolerance` is given, of its stable orbit by Newton's method. A run whose
    numerics fail counts as running away: no step is short enough for unbounded rates."""
    solver = build(model, scene, tolerance=LATE_TOLERANCE) if cells is None else build(model, scene, cells=cells)
    watch = EventObserver(solver.scene, solver.nodes)
    run = reconsidered(simulate(solver, until, watch=watch), one_port_of(model))
    kind, events = run.kind, (run.verdict.multiplicity if run.verdict else None) or 1
    if run.failed or kind is None:
        return Regime(AWAY)
    orbit = _stable_orbit(model, scene, tolerance, cells) if tolerance and kind in ("periodic", "settling") else None
    if orbit and events == 1:
        return Regime("periodic", orbit)
    if kind == "periodic":
        return Regime("periodic" if events == 1 else f"periodic, {events} events", _repeating(watch.events(0.5 * until), events))
    if kind in ("torus", "irregular"):
        late = watch.events(TRANSIENT)
        return Regime(kind, CycleFigures(*map(mean_of, (late.period, late.stress_drop, late.v_max))), late.period.size)
    return Regime(_WORDS.get(kind, kind))


def _repeating(cycles: Events, events: int) -> CycleFigures:
    """Figures of the last cycles: of one, or means over the last period of several `events`, with their change since the period
    before as error."""
    if events == 1:
        return CycleFigures.of(estimate(cycles))
    columns = (cycles.period, cycles.stress_drop, cycles.v_max)
    means = [(float(one[-events:].mean()), float(one[-2 * events : -events].mean())) for one in columns]
    return CycleFigures(*(Estimate(last, abs(last - before)) for last, before in means))


def _stable_orbit(model: str, scene: Scene, tolerance: float, cells: int | None) -> CycleFigures | None:
    try:
        found = own_orbit(model, scene, tolerance, cells)
    except NumericsError:
        return None
    return CycleFigures.of(found.orbit) if found.multipliers.stable else None


def regime_areas(differences: "Dataset") -> dict[str, Number]:
    """The share of a map's area in which a model has another regime, in per cent. The name contains the lattice, because shares
    on different lattices are not compared; the error is one point of it."""
    sizes = [size for name, size in differences.sizes.items() if name != "model"]
    lattice = " x ".join(map(str, sizes))
    return {
        f"{row['model']} other regime, {lattice} points": stated(
            row["other_regime_percent"], 1e4 / (math.prod(sizes) * row["compared_percent"])
        )
        for row in differences.attrs["differences"]
    }
