"""The slab pair as a one-port: its exact impedance, its reductions, and their passivity (MODEL.md section 3)."""

from reduced.impedance.models import check_passivity, impedance, is_exact, ratio_of
from reduced.impedance.reduce import reduction_of
from reduced.impedance.transmission_line import Complex, Jet, Ratio, pair_ratio

__all__ = [
    "Complex",
    "Jet",
    "Ratio",
    "check_passivity",
    "impedance",
    "is_exact",
    "pair_ratio",
    "ratio_of",
    "reduction_of",
]
