"""Rate-and-state friction laws as plain data and compiled pure functions; `LAWS` lists the registered ones by name."""

from slipwave.friction import ageing, cutoff, regularised, slip, spinodal
from slipwave.friction.law import (
    LAWS,
    Law,
    OfStep,
    allows_rest,
    law_of_step,
    rate_of,
    rates,
    register,
    resampled,
    respond,
    said_of_edge,
    said_of_rest,
    smooth,
    steady_psi,
    steady_state,
    to_own,
    to_step,
    unknown_of,
    with_bend,
)
from slipwave.packages import load_from_packages

register("ageing", ageing.Ageing, ageing.respond_ageing)
register("slip", slip.Slip, slip.respond_slip)
_SINH = (regularised.sinh_rate, regularised.sinh_unknown)
register("ageing-regularised", ageing.AgeingRegularised, ageing.respond_ageing_regularised, steady_psi, *_SINH)
register("slip-regularised", slip.SlipRegularised, slip.respond_slip_regularised, steady_psi, *_SINH)
register("ageing-cutoff", cutoff.AgeingCutoff, cutoff.respond_ageing_cutoff)
register("slip-cutoff", cutoff.SlipCutoff, cutoff.respond_slip_cutoff)
register("spinodal", spinodal.Spinodal, spinodal.respond_spinodal, spinodal.steady_spinodal, *_SINH)

__all__ = [
    "LAWS", "Law", "OfStep", "allows_rest", "law_of_step", "rate_of", "rates", "register", "resampled", "respond", "said_of_edge",
    "said_of_rest", "smooth", "steady_state", "to_own", "to_step", "unknown_of", "with_bend",
]  # fmt: skip

load_from_packages("slipwave.laws", lambda loaded, label: None)  # a module that registers its laws when it is imported
