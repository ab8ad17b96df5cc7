"""Observers: reduce a run to events, period, drops and extrema while it streams by, piece by piece."""

from scene.observe.events import EventObserver, Events
from scene.observe.follow import Final, Solver, final_state, follow
from scene.observe.history import HistoryObserver
from scene.observe.ledger import Energy
from scene.observe.pieces import Pieces
from scene.observe.statistics import RunStatistics, Spread, summarise
from scene.observe.verdict import Verdict, judge_motion, slides_at

__all__ = [
    "Energy",
    "EventObserver",
    "Events",
    "Final",
    "HistoryObserver",
    "Pieces",
    "RunStatistics",
    "Solver",
    "Spread",
    "Verdict",
    "final_state",
    "follow",
    "judge_motion",
    "slides_at",
    "summarise",
]
