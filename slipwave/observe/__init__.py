"""Observers reduce a run to events, period, drops and extrema during the run, piece by piece."""

from slipwave.observe.events import EventObserver, Events
from slipwave.observe.history import HistoryObserver
from slipwave.observe.pieces import Pieces
from slipwave.observe.statistics import RunStatistics, Spread, summarise
from slipwave.observe.verdict import MotionVerdict, judge_motion, slides_at

__all__ = ["EventObserver", "Events", "HistoryObserver", "MotionVerdict", "Pieces", "RunStatistics", "Spread", "judge_motion"]
__all__ += ["slides_at", "summarise"]
