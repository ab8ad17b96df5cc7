"""What every compiled march needs from a scene, for all kinds of slabs: the clock, steady sliding, and its disturbance.

The drive is passed separately (`Drive.compiled`)."""

from typing import NamedTuple


class Forcing(NamedTuple):
    """One `transit` on the friction clock L/V*, `stiffness` of both slabs per transit, stress and slip rate V_0 (in V*) of steady
    sliding, and the size of the `nudge`."""

    transit: float
    stiffness: float
    steady_stress: float
    velocity: float
    nudge: float
