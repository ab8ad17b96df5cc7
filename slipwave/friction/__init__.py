"""Rate-and-state friction laws as plain data and compiled pure functions; `LAWS` lists the registered ones by name."""

from slipwave.friction import ageing, regularised, slip
from slipwave.friction.law import LAWS, Law, rate_of, rates, register, respond, steady_state, unknown_of

register("ageing", ageing.Ageing, ageing.respond, ageing.steady_state)
register("slip", slip.Slip, slip.respond, slip.steady_state)
_SHARED = (regularised.steady_state, regularised.rate_of, regularised.unknown_of)
register("ageing-regularised", ageing.AgeingRegularised, ageing.respond_regularised, *_SHARED)
register("slip-regularised", slip.SlipRegularised, slip.respond_regularised, *_SHARED)

__all__ = ["LAWS", "Law", "rate_of", "rates", "register", "respond", "steady_state", "unknown_of"]
