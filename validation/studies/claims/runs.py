"""The runs that the claims are compared with: orbits along the stable branch, long runs deep inside it, ripples."""

from typing import NamedTuple, TypeAlias

import numpy as np

import slipwave
from slipwave.observe import Events, HistoryObserver
from slipwave.observe.pieces import Array
from slipwave.observe.statistics import Orbit
from slipwave.scene import Scene
from slipwave.solve import follow
from validation.measure.cycle import Cycle, watch
from validation.measure.ripples import ripple_period
from validation.measure.settle import Settled, one_cycle, settle
from validation.references.onset import Onset, onset_of
from validation.registry.build import build
from validation.study import Budget

LOG10_R = {
    True: (-2.695, -2.69, -2.685, -2.68, -2.67, -2.665, -2.66),
    False: (
        -2.695, -2.6925, -2.69, -2.6875, -2.685, -2.6825, -2.68, -2.6775, -2.675, -2.6725, -2.67, -2.6675, -2.665, -2.6625, -2.66,
    ),
}  # fmt: skip
"""By quick or full report: from just beyond the onset to where the delay system's orbit loses stability (-2.6575)."""

MODELS = ("delay", "kelvin-voigt", "block8", "block12")
DEEP = -2.3
LARGE_NUDGE = 2.0
_RESTLESS = 1e-6  # an orbit whose cycles still differ by more, relative, is not compared
SHOWN = (1000.0, 1420.0)
"""Transits of a long run after its transient that are drawn."""
LONGEST = 12
"""Cycles of a periodic orbit that `recurrence` knows."""

Branch: TypeAlias = dict[float, dict[str, Orbit]]
"""By log10 r, where all models have settled: their orbits."""


class Deep(NamedTuple):
    """A long run at log10 r = -2.3: its cycles after the transient, and time and stress over a stretch of it."""

    events: Events
    time: Array
    stress: Array


class Loading(NamedTuple):
    """Where the time of a cycle goes, in transits: the period; the elastic drop over epsilon V; the time in which the elastic
    stress falls (v > V); and the slip while it rises, over V."""

    period: float
    drop: float
    falling: float
    slipped: float


class Ripples(NamedTuple):
    """A model's orbit at log10 r = -2.68: period of its ripples (transits), and where the time of the cycle goes."""

    period: float
    loading: Loading


def settle_branch(budget: Budget) -> Branch:
    """Every model's orbit, from the scene's own nudge, at every log10 r at which all of them settle."""
    branch: Branch = {}
    for log10_r in budget.each(LOG10_R[budget.quick], end=0.6):
        found = {model: _settled(model, {"slab.log10_r": log10_r}) for model in MODELS}
        orbits = {model: settled.orbit for model, settled in found.items() if settled.unrest < _RESTLESS}
        if len(orbits) == len(MODELS):
            branch[log10_r] = orbits
    return branch


def beside(log10_r: float) -> Orbit:
    """The delay system's orbit from a larger nudge."""
    return _settled("delay", {"slab.log10_r": log10_r, "start.size": LARGE_NUDGE}).orbit


def _settled(model: str, changes: dict[str, float]) -> Settled:
    return settle(build(model, slipwave.read("paper", changes), tolerance=1e-9), tolerance=1e-8)


def run_deep(model: str, until: float) -> Deep:
    """Run `model` at log10 r = -2.3 to `until` (transits)."""
    solver = build(model, slipwave.read("paper-2.3"), tolerance=1e-9)
    history = HistoryObserver(solver.scene.law, solver.nodes)
    observer = watch(solver, SHOWN[0])
    follow(solver, SHOWN[1], [observer, history])
    follow(solver, until, [observer])
    time, _, _, stress, _ = history.samples(per_piece=8)
    return Deep(observer.events(SHOWN[0]), time, stress)


def measure_ripples(model: str) -> Ripples:
    """One cycle of the model's orbit at log10 r = -2.68."""
    scene = slipwave.read("paper")
    settled = settle(build(model, scene, tolerance=1e-10), tolerance=1e-9)
    cycle = one_cycle(settled, per_piece=16)
    return Ripples(ripple_period(cycle), loading_of(settled.orbit, cycle, scene))


def loading_of(orbit: Orbit, cycle: Cycle, scene: Scene) -> Loading:
    """The parts of a period, from samples over one cycle: y' = eps (V - v), so that y rises by eps (V t_rise - s_rise)."""
    period = orbit.period.value
    since = np.mod(cycle.time - cycle.time[np.argmin(cycle.elastic_stress)], period)
    order = np.argsort(since)
    since, rate = since[order], cycle.slip_rate[order]
    rises = slice(0, int(np.argmax(cycle.elastic_stress[order])) + 1)
    slip = float(np.trapezoid(rate[rises], since[rises]))
    load = scene.upper.epsilon * scene.velocity
    return Loading(period, orbit.elastic_stress_drop.value / load, period - float(np.ptp(since[rises])), slip / scene.velocity)


def where(branch: Branch) -> str:
    """The range of r that the orbits cover."""
    grid = list(branch)
    return f"log_{{10}} r from {grid[0]:g} to {grid[-1]:g}".replace("-", "−")


def onset_at(velocity: float) -> Onset:
    """Closed forms of the paper's material at drive `velocity` (V*)."""
    scene = slipwave.read("paper")
    return onset_of(scene.law, scene.upper.epsilon, velocity)


def spread(values: Array) -> float:
    """Standard deviation over mean."""
    return float(np.std(values) / np.mean(values))


def recurrence(values: Array) -> float:
    """How far a sequence is from repeating itself: root mean square of x_(n + k) - x_n over sqrt(2) times the standard deviation,
    the least over k up to 12. 0 for every orbit of up to 12 cycles, about 1 for a sequence without memory."""
    if float(np.std(values)) < _RESTLESS * float(np.max(np.abs(values))):
        return 0.0
    steps = [float(np.sqrt(np.mean((values[k:] - values[:-k]) ** 2))) for k in range(1, LONGEST + 1)]
    return float(min(steps) / (np.std(values) * 2.0**0.5))
