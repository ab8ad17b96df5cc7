"""Verdicts on a full wave that the report and `verify` share: order in space, step limit, noise at the scale of the grid."""

import math
from collections.abc import Mapping
from dataclasses import replace

from validation.measure.limits import AROUND, BEYOND, GROWN, SHARPNESS, STEPS, noise_left
from validation.measure.orders import OUTPUTS, Climb
from validation.models.by_name import grid_of
from validation.report.text import plain
from validation.report.verdict import EXACT, WITNESS, Evidence, Outcome, Verdict, claim, every, holding, in_range

ORDER = "Every full-wave family reaches its order in space in every output, from the smooth start"
LIMIT = "The step limit does not move with the stiffness of friction"
CALM = f"Noise stays at {AROUND[0][0]:g} of the limit and grows at {AROUND[1][0]:g}, for all slabs and faces"
STAYS = f"Noise stays at {AROUND[0][0]:g} of the limit, for all slabs and faces"
STATE = "Fast relaxation of ψ limits the step at the real stability limit of the time stepping"
STOPS = "A step past the limit ends the run with a message"
NOISE = "Noise at the grid scale gains no energy in a locked slab, and a scheme that conserves energy loses none"

SHARP = (1.0 - AROUND[0][0]) + (SHARPNESS - 1.0) + math.log(GROWN) / STEPS
"""How far a step limit may lie from the declared one: that is 1 per cent below the spectrum's, limits are found to 1 per cent,
and growth is seen if it exceeds so much a step."""
_REACH = {4: 2.785, 8: 6.394}
"""How far Runge-Kutta methods are stable on the negative real axis, by their order."""


def order_verdict(climbed: Climb, evidence: Evidence = WITNESS) -> Verdict:
    """Whether a family reaches its order in every output; not decided if errors reach rounding on too few grids for an order."""
    ladder, short = climbed.ladder, climbed.shortfall()
    remark = f"`{ladder.model}`" + (f" at CFL {ladder.cfl:g}" if ladder.cfl else "")
    if climbed.lost:
        verdict = holding(ORDER, evidence, f"order {ladder.promised:g}", f"no order: {climbed.lost}", False, remark)
        return replace(verdict, outcome=Outcome.OPEN) if climbed.at_rounding else verdict
    symbols = {**OUTPUTS, "state": "the state", "together": "all together"}
    names = ", ".join(symbols[complaint.split(":")[0]] for complaint in short)
    (expected, off, allowed), (*orders, together) = climbed.against_promise, climbed.fits.values()
    low, high = (end(fit.order for fit in orders) for end in (min, max))
    ours = f"{together.rounded}, outputs {low:.2f} to {high:.2f}"
    remark += f": short in {names}" if names else ""
    return holding(ORDER, evidence, expected, ours, not short, remark).with_margin(off, allowed)


def limit_verdict(model: str, shares: Mapping[int, float]) -> Verdict:
    """Whether the largest stable step over the declared one (by power of ten of a/v over Z) is 1 however stiff friction is; where
    friction absorbs the waves (a/v = Z), it may be longer."""
    returning = [share for decade, share in shares.items() if decade != 0]
    remark = f"`{model}`, a/v from 10^{{{min(shares)}}} to 10^{{{max(shares)}}} times Z"
    return in_range(LIMIT, EXACT, (1.0 - SHARP, 1.0 + SHARP), [*returning, min(shares.values())], remark, ".2f")


def medium_verdict(medium: str, around: Mapping[str, tuple[float, float]]) -> Verdict:
    """Whether the limit of every model separates decay from growth; `around`: noise below and above it, over that put in."""
    below, above = zip(*around.values(), strict=True)
    grown = f"at least {plain(min(above), '.0e')}" if math.isfinite(min(above)) else "beyond any number"
    shown = f"at most {max(below):.1f}, {grown}"
    return holding(CALM, EXACT, f"below {GROWN:g}, above {GROWN:g}", shown, max(below) < GROWN < min(above), medium)


def calm_verdict(model: str, medium: str, grown: float) -> Verdict:
    """Whether noise stays below the limit, which may be shorter in a medium than it has to be."""
    remark = f"`{model}`, {medium}"
    return holding(STAYS, EXACT, f"below {GROWN:g} times", f"{plain(grown, '.2g')} times", grown < GROWN, remark)


def state_verdict(model: str, reach: float) -> Verdict:
    """Whether the longest stable step times the relaxation rate of psi is what theory says; a family that takes psi implicitly
    has no such limit."""
    family, number = grid_of(model)
    if family.implicit_state:
        shown = "no limit" if math.isinf(reach) else f"{reach:.3g}"
        return holding(STATE, EXACT, "no limit", shown, math.isinf(reach), f"`{model}`")
    wanted = _REACH[family.order_in_time(number)]
    return claim(STATE, EXACT, reach / wanted, SHARPNESS - 1.0, f"`{model}`, Δt r V over {wanted:g}", near=1.0)


def stop_verdict(stopped: Mapping[str, bool]) -> Verdict:
    """Whether steps that are too long end with a message."""
    silent, total = [model for model, stops in stopped.items() if not stops], len(stopped)
    remark = f"steps {BEYOND:g} times the limit, paper’s scene{'; silent: ' + ', '.join(silent) if silent else ''}"
    return every(STOPS, EXACT, total - len(silent), total, remark)


def noise_verdict(model: str, left: float, transits: float) -> Verdict:
    """Whether the energy of noise after so many `transits`, over that in the first ten, is what friction leaves, or less if the
    family does not conserve it."""
    remark = f"`{model}`, energy after {transits:g} transits over that in the first ten"
    if not grid_of(model)[0].conserves:
        return holding(NOISE, EXACT, "1 or less", f"{left:.3g}", left <= 1.0, remark)
    known = noise_left(transits)
    expected, off = f"{known.value:.10g}, what friction leaves", abs(left - known.value)
    return holding(NOISE, EXACT, expected, f"{left:.10g}", off < known.error, remark)
