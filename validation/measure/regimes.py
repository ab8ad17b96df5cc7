"""The final motion of a model in a scene: its regime in words, and the figures of its cycles, if any."""

import math
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cache

from slipwave.errors import NumericsError
from slipwave.observe.statistics import Estimate, Orbit
from slipwave.scene import Scene
from validation.measure.cycle import SYMBOLS
from validation.measure.memo import own_orbit
from validation.models.build import build
from validation.models.by_name import one_port_of
from validation.models.run import Run, reconsidered, simulate
from validation.models.settle import estimate

STEADY, AWAY, UNDECIDED, UNTRIED = "slides steadily", "runs away", "undecided", "–"
"""Regimes besides "periodic", "torus" and "irregular"; the last one: the model was not tried in the scene."""
UNKNOWN = {UNDECIDED, UNTRIED}
_WORDS = {"steady": STEADY, "decaying": STEADY, "settling": UNDECIDED, "growing": UNDECIDED, "too short": UNDECIDED}
"""Verdict on a run -> its name in tables of models, if different."""

TOLERANCE = 1e-7
"""Tolerance of runs."""
FIGURES = {SYMBOLS[name]: name for name in ("period", "stress_drop", "v_max")}
"""Symbol of a figure of cycles, as in tables of models -> its name in `Orbit` and `Events`."""


@dataclass(frozen=True)
class Regime:
    """`words`: "periodic" (with its events, if several), "torus", "irregular", or one of the words above; `figures` of its
    cycles by symbol (transits, σ, V*), with the errors of an orbit's computation or the standard errors of means, empty if it has
    none; `cycles`: number of cycles of the means, 0 for a repeating motion; `command` and options of `slipwave` that print them;
    `ran`: figures of the run's cycles where its `figures` are those of an orbit by Newton's method."""

    words: str
    figures: dict[str, Estimate] = field(default_factory=dict)
    cycles: int = 0
    command: str = ""
    ran: dict[str, Estimate] = field(default_factory=dict)

    def agrees(self, other: "Regime") -> bool:
        """Whether both are the same, as far as both are decided."""
        return self.words == other.words or not {self.words, other.words}.isdisjoint(UNKNOWN)


@cache
def regime_of(model: str, scene: Scene, until: float, cells: int | None = None, tolerance: float | None = None) -> Regime:
    """The regime of a run of `model` to `until` (transits). Figures are those of the cycles of its second half: means and, of
    the largest slip rate, whose tail is heavy, the median; if a `tolerance` is given and the motion repeats, those of its stable
    orbit by Newton's method. A run whose numerics fail counts as running away: no step is short enough for unbounded rates."""
    grid = f" --cells {cells}" if cells else ""
    command = f"run --until {until:g} --tol {TOLERANCE:g}{grid}"
    run = reconsidered(simulate(build(model, scene, tolerance=TOLERANCE, cells=cells), until), one_port_of(model))
    if run.failed or run.verdict is None:
        return Regime(AWAY, command=command)
    kind, events = run.verdict.kind, run.verdict.multiplicity or 1
    orbit = dict[str, Estimate]()
    if tolerance and kind in ("periodic", "settling"):
        with suppress(NumericsError):
            own = own_orbit(model, scene, tolerance, cells)
            if own.multipliers.stable is not False:  # a run cannot have come near an unstable one
                orbit = _figures(own.orbit)
    if orbit and events == 1:
        ran = _figures(estimate(run.events)) if kind == "periodic" else {}
        return Regime("periodic", orbit, 0, f"orbit --tol {tolerance:g}{grid}", ran)
    words = f"periodic, {events} events" if events > 1 else _WORDS.get(kind, kind)
    figures = _figures_of(run) if run.verdict.repeats else {}
    return Regime(words, figures, run.statistics.cycles if run.verdict.wanders else 0, command)


def _figures(of: Orbit) -> dict[str, Estimate]:
    return {symbol: getattr(of, name) for symbol, name in FIGURES.items()}


def _figures_of(run: Run) -> dict[str, Estimate]:
    """Figures of the second half of a run: of cycles that never repeat means and a median; of others, whose error is the change
    until the last period, means and the largest slip rate."""
    statistics, events = run.statistics, (run.verdict.multiplicity if run.verdict else None) or 1
    values, margins = [statistics.period.mean, statistics.stress_drop.mean, statistics.v_max], statistics.margins
    if not math.isnan(margins["period"]):
        errors = [0.5 * margins[name] for name in ("period", "stress_drop", "v_max_median")]
        return dict(zip(FIGURES, map(Estimate, [*values[:2], statistics.v_max_median], errors), strict=True))
    columns = [getattr(run.events, name)[-events:] for name in FIGURES.values()]
    last = [float(columns[0].mean()), float(columns[1].mean()), float(columns[2].max())]
    return {symbol: Estimate(value, abs(value - late)) for symbol, value, late in zip(FIGURES, values, last, strict=True)}
