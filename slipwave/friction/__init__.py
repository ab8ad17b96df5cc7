"""Rate-and-state friction laws as plain data and compiled pure functions; `LAWS` lists the registered ones by name."""

from slipwave.friction import ageing, ageing_regularised, regularised, slip, slip_regularised
from slipwave.friction.law import LAWS, Law, rate_of, register, respond, steady_state, unknown_of
from slipwave.friction.rates import rates

register("ageing", ageing.Ageing, ageing.respond, ageing.steady_state)
register("slip", slip.Slip, slip.respond, slip.steady_state)
_SHARED = (regularised.steady_state, regularised.rate_of, regularised.unknown_of)
register("ageing-regularised", ageing_regularised.AgeingRegularised, ageing_regularised.respond, *_SHARED)
register("slip-regularised", slip_regularised.SlipRegularised, slip_regularised.respond, *_SHARED)

__all__ = ["LAWS", "Law", "rate_of", "rates", "register", "respond", "steady_state", "unknown_of"]
