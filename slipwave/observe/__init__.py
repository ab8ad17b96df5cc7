"""Observers, which reduce a run piece by piece to its events, period, drops and extrema."""

from slipwave.observe.events import EventObserver, Events
from slipwave.observe.history import HistoryObserver
from slipwave.observe.pieces import Pieces
from slipwave.observe.statistics import RunStatistics, summarise
from slipwave.observe.verdict import MotionVerdict, judge_motion, slides_at

__all__ = ["EventObserver", "Events", "HistoryObserver", "MotionVerdict", "Pieces", "RunStatistics", "judge_motion"]
__all__ += ["slides_at", "summarise"]
