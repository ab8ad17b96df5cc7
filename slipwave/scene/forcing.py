"""What every compiled march needs of a scene, whatever its slabs: the clock, steady sliding, and what disturbs it.

The drive goes beside it (`Drive.compiled`): a tuple that holds arrays is counted in and out wherever it is handed on, which
costs a leapfrog a fifth of its speed.
"""

from typing import NamedTuple


class Forcing(NamedTuple):
    """One `transit` on the friction clock L/V*, `stiffness` of both slabs per transit, stress and slip rate V_0 (in V*) of steady
    sliding, and the size of the `nudge`."""

    transit: float
    stiffness: float
    steady_stress: float
    velocity: float
    nudge: float
