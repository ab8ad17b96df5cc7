"""Observers that a scene records by name: `run.record = ["events", "NAME"]`."""

from importlib import import_module
from typing import Protocol

from slipwave.scene.recorded import OBSERVERS
from slipwave.solve.follow import Observer
from slipwave.solve.solver import Resumable, Solver


class NamedObserver(Observer, Resumable, Protocol):
    """An observer whose `figures` are among the results of a run, and which goes on from checkpoints."""

    def figures(self) -> dict[str, float]:
        """What was observed so far, by name."""


def named_observers(solver: Solver) -> dict[str, NamedObserver]:
    """A new observer for each name that the solver's scene records."""
    made: dict[str, NamedObserver] = {}
    for name in sorted(solver.scene.record & OBSERVERS.keys()):
        module, _, kind = OBSERVERS[name].partition(":")
        made[name] = getattr(import_module(module), kind)(solver.scene, solver.nodes)
    return made
