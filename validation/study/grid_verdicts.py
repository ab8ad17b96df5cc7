"""Verdicts on full waves that the report and `verify` share: orders in space and step limits."""

import math
from collections.abc import Mapping

from validation.compute.models import grid_of
from validation.measure.grids.limits import AROUND, BEYOND, GROWN, SHARPNESS, STEPS
from validation.measure.orders import OUTPUTS, Climb
from validation.study.text import plain
from validation.study.verdict import EXACT, WITNESS, Verdict, every, holding, in_range

SHARP = (1.0 - AROUND[0][0]) + (SHARPNESS - 1.0) + math.log(GROWN) / STEPS
"""How far a step limit may lie from the declared one: that is 1 per cent below the spectrum's, limits are found to 1 per cent,
and growth is seen if it exceeds so much a step."""
_REACH = {4: 2.785, 8: 6.394}
"""How far Runge-Kutta methods are stable on the negative real axis, by their order."""


Media = Mapping[str, Mapping[str, tuple[float, float]]]
"""Medium -> model -> growth of noise below and above the limit."""


def order_verdict(climbed: Climb) -> Verdict:
    """Whether a family reaches its order in every output."""
    short, (low, high) = climbed.shortfall(), (0.0, 0.0) if climbed.lost else climbed.span
    symbols = {**OUTPUTS, "state": "the state", "together": "all together"}
    names = ", ".join(symbols[complaint.split(":")[0]] for complaint in short if not climbed.lost)
    remark = f"`{climbed.ladder.model}`" + (f": short in {names}" if names else _REMARKS.get(climbed.ladder.model, ""))
    title = "Every full-wave family reaches its order in space in every output, from the smooth start"
    if climbed.lost:
        return holding(title, WITNESS, f"order {climbed.ladder.promised:g}", f"no order: {climbed.lost}", False, remark)
    (expected, off, allowed), ours = climbed.against_promise, f"{climbed.fit_together().rounded}, outputs {low:.2f} to {high:.2f}"
    return holding(title, WITNESS, expected, ours, not short, remark).with_margin(off, allowed)


_REMARKS = {"fem:1": ": the same numbers as `sbp:2`, not an independent witness"}


def limit_verdict(shares_of: Mapping[str, Mapping[int, float]]) -> Verdict:
    """Verdict: whether the limit is independent of stiffness."""
    pairs = [(value, decade) for shares in shares_of.values() for decade, value in shares.items()]
    returning, (values, decades) = [value for value, decade in pairs if decade != 0], zip(*pairs, strict=True)
    where = (
        f"largest stable step over the declared one, {len(shares_of)} families, a/v from 10^{{{min(decades)}}} to "
        f"10^{{{max(decades)}}} times Z; where friction absorbs the waves (a/v = Z) up to {max(values):.2f}"
    )
    ends, title = (1.0 - SHARP, 1.0 + SHARP), "The step limit does not move with the stiffness of friction"
    return in_range(title, EXACT, ends, [*returning, min(values)], where, ".2f")


def medium_verdict(media: Media) -> Verdict:
    """Verdict: whether the limit separates decay from growth in every medium."""
    below, above = zip(*(pair for by_family in media.values() for pair in by_family.values()), strict=True)
    grown = f"at least {plain(min(above), '.0e')}" if math.isfinite(min(above)) else "all beyond any number"
    return holding(
        f"Noise stays at {AROUND[0][0]:g} of the limit and grows at {AROUND[1][0]:g}, for all slabs and faces",
        EXACT,
        f"below {GROWN:g}, above {GROWN:g}",
        f"at most {max(below):.1f}, {grown}",
        max(below) < GROWN < min(above),
        f"{len(media)} media by {len(next(iter(media.values())))} families, over the noise put in",
    ).with_margin(max(max(below) / GROWN, GROWN / min(above)), 1.0)


def state_verdict(reach: Mapping[str, float]) -> Verdict:
    """Verdict: whether the state's limit agrees with theory."""
    wanted = {model: _reach_of(model) for model in reach}
    ratios = [value / wanted[model] for model, value in reach.items() if math.isfinite(wanted[model])]
    sharp = SHARPNESS - 1.0
    unlimited = all(math.isinf(value) for model, value in reach.items() if math.isinf(wanted[model]))
    return holding(
        "Fast relaxation of ψ limits the step at the real stability limit of the time stepping",
        EXACT,
        f"1, ± {100 * sharp:.0f} %",
        f"{min(ratios):.3f} to {max(ratios):.3f}",
        all(abs(ratio - 1.0) <= sharp for ratio in ratios) and unlimited,
        f"Δt r V over {_REACH[4]:g} (Runge-Kutta of order 4) or {_REACH[8]:g} (order 8); the leapfrog takes ψ "
        "implicitly and has no such limit",
    ).with_margin(max(abs(ratio - 1.0) for ratio in ratios), sharp)


def _reach_of(model: str) -> float:
    family, number = grid_of(model)
    return math.inf if family.implicit_state else _REACH[family.order_in_time(number)]


def stop_verdict(stopped: Mapping[str, bool]) -> Verdict:
    """Whether steps that are too long end with a message."""
    silent, total = [model for model, stops in stopped.items() if not stops], len(stopped)
    remark = f"steps {BEYOND:g} times the limit, paper’s scene{'; silent: ' + ', '.join(silent) if silent else ''}"
    return every("A step past the limit ends the run with a message", EXACT, total - len(silent), total, remark)
