"""What is measured on one cycle: its curves on a settled orbit, the period of its ripples; symbols of its figures."""

from copy import deepcopy

import numpy as np

from slipwave.observe import Events as Events
from slipwave.observe import HistoryObserver
from slipwave.observe.statistics import Estimate as Estimate
from slipwave.observe.statistics import Orbit as Orbit
from slipwave.solve import follow
from validation.commands.run import RunResult
from validation.models.cycle import OneCycle as OneCycle
from validation.models.cycle import cut
from validation.models.settle import Settled
from validation.models.settle import estimate as estimate

SYMBOLS = {"period": "T", "stress_drop": "Δμ", "elastic_stress_drop": "Δy", "v_max": "v_{max}", "v_min": "v_{min}"}
"""The figures of an orbit, and their symbols."""

_RIPPLES = (25.0, 55.0)  # transits after the event's date in which the interface creeps and the stress ripples


def ripple_period(cycle: OneCycle) -> float:
    """Mean time (transits) between maxima of mu within _RIPPLES, located by parabolas through three samples.

    Raises ValueError if there are fewer than three maxima.
    """
    inside = (cycle.time >= _RIPPLES[0]) & (cycle.time <= _RIPPLES[1])
    time, stress = cycle.time[inside], cycle.stress[inside]
    ripple = stress - np.polynomial.Polynomial.fit(time, stress, 3)(time)
    peak = np.flatnonzero((ripple[1:-1] > ripple[:-2]) & (ripple[1:-1] >= ripple[2:]) & (ripple[1:-1] > 0.3 * ripple.max())) + 1
    if peak.size < 3:
        raise ValueError(f"{peak.size} ripples between {_RIPPLES[0]} and {_RIPPLES[1]} transits")
    maxima = np.array([_vertex(time[k - 1 : k + 2], ripple[k - 1 : k + 2]) for k in peak])
    return float((maxima[-1] - maxima[0]) / (maxima.size - 1))


def _vertex(x: np.ndarray, y: np.ndarray) -> float:
    """Abscissa of the vertex of the parabola through three points."""
    slope, bend = (y[1] - y[0]) / (x[1] - x[0]), (y[2] - y[1]) / (x[2] - x[1])
    curvature = (bend - slope) / (x[2] - x[0])
    return float(0.5 * (x[0] + x[1]) - 0.5 * slope / curvature)


def history_of(run: RunResult) -> dict[str, np.ndarray]:
    """What a run kept of the interface's history, by the names of `OneCycle`."""
    assert run.records.history
    parts = list(run.records.history.parts())
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def one_cycle(settled: Settled, before: float = 0.0, after: float = 0.0, per_piece: int = 8) -> OneCycle:
    """A cycle of the next two periods, from `before` transits ahead of its event to `after` transits past its end. The solver's
    state is restored."""
    solver, observer, period = settled.solver, deepcopy(settled.observer), settled.orbit.period.value
    begin, here = solver.time, solver.state()
    history = HistoryObserver(solver.scene.law, solver.nodes)
    follow(solver, begin + 2.02 * period + before + after, [history, observer])
    solver.restore(here)
    dates = observer.dates()
    date = float(dates[dates >= begin + before][0])
    return cut(solver.scene.law, history.samples(per_piece), date, period, before, after)
