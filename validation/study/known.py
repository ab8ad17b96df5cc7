"""Claims of several studies: periods known from other programs, the order of periods (P7)."""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from slipwave.observe.statistics import Estimate
from validation.compute.models import grid_of
from validation.measure.order_fit import WIDEST, WITHIN, Fit, asked, shortfall
from validation.references.published import half_digit, reference_orbit
from validation.study import PAPER, WITNESS, Evidence, Verdict, claim, every, holding
from validation.study.text import minus, places

ERRORS = 4.0
"""Number of its stated errors by which a figure may deviate."""

OTHERS = 9e-11
"""How far periods of other programs may be off beyond half of the last digit that is known, relative: those of `block8` are."""

JUST_BELOW = 0.01
"""Largest relative distance below the onset of a fold that is "just below" it."""


def error_of(*figures: Estimate) -> float:
    """Allowed relative difference of figures: `ERRORS` times their stated errors."""
    return ERRORS * sum(figure.error / abs(figure.value) for figure in figures)


def rounding(operations: float) -> float:
    """How far the rounding errors of so many operations may add up, relative: they are as if drawn at random, so that their sum
    grows with the square root of their number (Higham and Mary, SIAM J. Sci. Comput. 41, 2019), each at most half of eps."""
    return ERRORS * 0.5 * float(np.finfo(float).eps) * math.sqrt(operations)


def error_after(model: str, error: float, coarse: int, fine: int) -> float:
    """How far the orbit of a grid of `fine` cells may be off after that `error` on `coarse` ones: twice what the declared order
    leaves of it."""
    family, number = grid_of(model)
    return 2.0 * abs(error) * (coarse / fine) ** family.order_interface(number)


def as_known(periods: Mapping[str, Estimate], log10_r: float, others: float = 0.0) -> Verdict:
    """Verdict on periods by model: half of the last known digit plus the period's own error, or that of the `others`, relative,
    is allowed; the worst is shown."""
    known = {model: value for model in periods if (value := reference_orbit(model, log10_r).get("period"))}
    off = {model: abs(periods[model].value / value - 1.0) for model, value in known.items()}
    allowed = {model: half_digit(value) / value + max(error_of(periods[model]), others) for model, value in known.items()}
    worst = max(known, key=lambda model: off[model] / allowed[model])
    where = f"{', '.join(f'`{model}`' for model in known)} at log_{{10}} r = {places([log10_r])}; shown: `{worst}`"
    return claim("Periods are those of other programs", WITNESS, off[worst], allowed[worst], where)


def as_printed(title: str, printed: float, ours: float) -> Verdict:
    """Verdict on a number of the paper: half of its last digit is allowed."""
    off, half = abs(ours - printed), half_digit(printed)
    return holding(title, PAPER, f"{printed:g} ± {half:g}", f"{ours:.5f}", off <= half).with_margin(off, half)


def of_order(
    title: str,
    evidence: Evidence,
    found: Fit,
    declared: float,
    remark: str = "",
    within: float = WITHIN,
    above: bool = False,
    widest: float = WIDEST,
) -> Verdict:
    """Verdict on an order of convergence, by `shortfall`: `within` this distance of the declared one, or its own interval; with
    `above` it may be larger."""
    allowed, holds = max(within, found.half_width), not shortfall(found, declared, within, above, widest)
    expected, off = asked(found.order, declared, allowed, above)
    return holding(title, evidence, expected, found.rounded, holds, remark).with_margin(off, allowed)


class PeriodRanges(NamedTuple):
    """Lowest and highest period of each model at one r."""

    log10_r: float
    kelvin_voigt: tuple[float, float]
    delay: tuple[float, float]
    blocks: tuple[float, float]

    @property
    def ordered(self) -> bool:
        """Whether P7 holds here."""
        return self.kelvin_voigt[1] < self.delay[0] and self.delay[1] < self.blocks[0]


def range_of_r(grid: Sequence[float]) -> str:
    """The range of r in a claim's title."""
    return minus(f"log_{{10}} r from {grid[0]:g} to {grid[-1]:g}")


def order_of_periods(listed: Sequence[PeriodRanges], remark: str) -> Verdict:
    """Verdict on P7 at every r."""
    held = sum(one.ordered for one in listed)
    title = f"P7 T_{{ODE}} < T_{{delay}} < T_{{block}} for {range_of_r([one.log10_r for one in listed])}"
    return every(title, PAPER, held, len(listed), remark, "r")
