"""The runs that the claims are held against: orbits along the stable branch, long runs deep inside it, ripples."""

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np

import scene
from scene.observe import EventObserver, Events, follow
from scene.observe.pieces import Array
from validation.closed_forms import Onset
from validation.models import build
from validation.orbits import DenseObserver, Orbit, one_cycle, settle
from validation.ripples import ripple_period

LOG10_R = (-2.69, -2.68, -2.67, -2.66)
MODELS = ("delay", "kelvin-voigt", "block8", "block12")
DEEP = -2.3
_SHOWN = (1000.0, 1420.0)

Branch: TypeAlias = dict[str, dict[float, Orbit]]
"""Stable orbits by model and log10 r."""


class Deep(NamedTuple):
    """A long run at log10 r = -2.3: its cycles after the start has worn off, and time and stress over a stretch of it."""

    events: Events
    time: Array
    stress: Array


def settle_branch(report: Callable[[float], None]) -> Branch:
    """Every model's orbit at every log10 r of LOG10_R."""
    branch: Branch = {model: {} for model in MODELS}
    for count, log10_r in enumerate(LOG10_R):
        what = scene.read("paper", {"slab.log10_r": log10_r})
        for model in MODELS:
            branch[model][log10_r] = settle(build(model, what, tolerance=1e-9), tolerance=1e-8).orbit
        report((count + 1) / len(LOG10_R))
    return branch


def run_deep(model: str, until: float) -> Deep:
    """Run `model` at log10 r = -2.3 to `until` (transits)."""
    solver = build(model, scene.read("paper-2.3"), tolerance=1e-9)
    observer, dense = EventObserver(solver.scene, solver.nodes), DenseObserver(solver.nodes, 8)
    follow(solver, _SHOWN[0], [observer])
    follow(solver, _SHOWN[1], [observer, dense])
    follow(solver, until, [observer])
    table = dense.table()
    late = observer.events.time > _SHOWN[0]
    return Deep(Events(*(column[late] for column in observer.events)), table[0], table[3])


def measure_ripple(model: str) -> float:
    """Period of the ripples on the model's orbit at log10 r = -2.68 (transits)."""
    settled = settle(build(model, scene.read("paper"), tolerance=1e-10), tolerance=1e-9)
    return ripple_period(one_cycle(settled, per_piece=16))


def onset_at(velocity: float) -> Onset:
    """Closed forms of the paper's material at drive `velocity` (V*)."""
    what = scene.read("paper")
    return Onset(what.law, what.upper.epsilon, velocity)


def spread(values: Array) -> float:
    """Standard deviation over mean."""
    return float(np.std(values) / np.mean(values))
