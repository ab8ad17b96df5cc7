"""Stability of steady sliding, from the impedance alone: spectrum, critical values and boundaries, for every scene and model."""

from reduced.parameters import scaled, with_parameter
from reduced.stability.analyse import Stability, analyse
from reduced.stability.boundary import Boundary, boundary
from reduced.stability.characteristic import characteristic
from reduced.stability.critical import critical_epsilon, critical_round_trip
from reduced.stability.error_laws import ErrorLaw, error_law
from reduced.stability.essential import essential_abscissa
from reduced.stability.spectrum import follow_root, leading_roots, spectrum, unstable_count
from slipwave.friction.law import FrictionSlopes, friction_slopes

__all__ = [
    "Boundary",
    "ErrorLaw",
    "FrictionSlopes",
    "Stability",
    "analyse",
    "boundary",
    "characteristic",
    "critical_epsilon",
    "critical_round_trip",
    "error_law",
    "essential_abscissa",
    "follow_root",
    "friction_slopes",
    "leading_roots",
    "scaled",
    "spectrum",
    "unstable_count",
    "with_parameter",
]
