"""The ripples of the slow phase: their period, read from the maxima of the stress after its slow rise is taken away."""

import numpy as np

from validation.measure.cycle import Cycle

WINDOW = (25.0, 55.0)
"""Transits after the event's date in which the interface creeps and the stress ripples about its slow rise."""


def ripple_period(cycle: Cycle) -> float:
    """Mean time (transits) between maxima of mu within WINDOW, the maxima placed by parabolas through three samples.

    Raises ValueError if there are fewer than three maxima.
    """
    inside = (cycle.time >= WINDOW[0]) & (cycle.time <= WINDOW[1])
    time, stress = cycle.time[inside], cycle.stress[inside]
    ripple = stress - np.polynomial.Polynomial.fit(time, stress, 3)(time)
    peak = np.flatnonzero((ripple[1:-1] > ripple[:-2]) & (ripple[1:-1] >= ripple[2:]) & (ripple[1:-1] > 0.3 * ripple.max())) + 1
    if peak.size < 3:
        raise ValueError(f"{peak.size} ripples between {WINDOW[0]} and {WINDOW[1]} transits")
    places = np.array([_vertex(time[k - 1 : k + 2], ripple[k - 1 : k + 2]) for k in peak])
    return float((places[-1] - places[0]) / (places.size - 1))


def _vertex(x: np.ndarray, y: np.ndarray) -> float:
    """Abscissa of the vertex of the parabola through three points."""
    slope, bend = (y[1] - y[0]) / (x[1] - x[0]), (y[2] - y[1]) / (x[2] - x[1])
    curvature = (bend - slope) / (x[2] - x[0])
    return float(0.5 * (x[0] + x[1]) - 0.5 * slope / curvature)
