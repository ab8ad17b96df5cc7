"""A figure of several studies as a number of the record."""

from reduced.orbit.closing import Closed, close
from reduced.orbit.periodic import FINER
from validation.report import Number, stated


def numbered_period(closed: Closed) -> Number:
    """The orbit's period on a finer mesh, solved to rounding errors; its error is the difference from that on the orbit's own
    mesh."""
    flow, state = closed.flow.remeshed(closed.cycle, FINER)
    period = close(flow, state, closed.cycle.period, 0.0).cycle.period
    return stated(period, abs(period - closed.cycle.period))
