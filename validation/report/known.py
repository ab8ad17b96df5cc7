"""Claims of several studies and their limits: periods known from other programs, orders, the order of periods (P7), errors of
full waves; an orbit's period as a number."""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from reduced.orbit.closing import Closed, close
from reduced.orbit.periodic import FINER
from slipwave.observe.statistics import Estimate
from validation.measure.cycle import SYMBOLS
from validation.measure.order_fit import WIDEST, WITHIN, Fit, asked, shortfall
from validation.models.by_name import grid_of
from validation.references import others
from validation.references.published import half_digit, reference_orbit
from validation.report import (
    PAPER,
    PROGRAM,
    Answers,
    Evidence,
    Number,
    Omission,
    Verdict,
    Verdicts,
    claim,
    every,
    holding,
    minus,
    places,
    stated,
)

ERRORS = 4.0
"""Number of its stated errors by which a figure may deviate."""

OTHERS = 9e-11
"""How far periods of other programs may be off beyond half of the last digit that is known, relative: those of `block8` are."""

_EXTRAPOLATED = 2e-11
"""How far values of another program, printed to 15 digits and extrapolated, may be off."""

JUST_BELOW = 0.01
"""Largest relative distance below the onset of a fold that is "just below" it."""


def error_of(*figures: Estimate) -> float:
    """Allowed relative difference of figures: `ERRORS` times their stated errors."""
    return ERRORS * sum(figure.error / abs(figure.value) for figure in figures)


def rounding(operations: float) -> float:
    """How far the rounding errors of so many operations may add up, relative: they are as if drawn at random, so that their sum
    grows with the square root of their number (Higham and Mary, SIAM J. Sci. Comput. 41, 2019), each at most half of eps."""
    return ERRORS * 0.5 * float(np.finfo(float).eps) * math.sqrt(operations)


def declared_order(model: str) -> float:
    """The order at which a full wave's motion of the interface converges, as its family declares it."""
    family, number = grid_of(model)
    return family.order_interface(number)


def error_after(model: str, error: float, coarse: int, fine: int) -> float:
    """How far the orbit of a grid of `fine` cells may be off after that `error` on `coarse` ones: twice what the declared order
    leaves of it."""
    return float(2.0 * abs(error) * (coarse / fine) ** declared_order(model))


def as_known(title: str, model: str, log10_r: float, ours: Mapping[str, float], theirs: float = OTHERS) -> Verdicts:
    """Verdict, if anything is known, on figures (names of `Orbit`) of a model's orbit at one r: half of the last known digit is
    allowed, and what `theirs` or ours may be off by beyond it, relative; shown is the worst."""
    known = {name: value for name, value in reference_orbit(model, log10_r).items() if name in ours}
    off = {name: abs(ours[name] / value - 1.0) for name, value in known.items()}
    allowed = {name: half_digit(value) / abs(value) + theirs for name, value in known.items()}
    if known:
        worst = max(known, key=lambda name: off[name] / allowed[name])
        symbols = ", ".join(map(SYMBOLS.__getitem__, known))
        where = f"`{model}` at {places([log10_r])}: {symbols}" + (f"; shown: {SYMBOLS[worst]}" if len(known) > 1 else "")
        yield claim(title, PROGRAM, off[worst], allowed[worst], where)


OTHERS_AT = (8.0, 20.0, 40.0, 100.0)
"""Times (transits of the upper slab) at which psi of another program is known."""


NO_OTHERS = () if others.FILES else (Omission("Results of another program", "They lie in a checkout, not in a wheel."),)


def foreign_answer(witness: str, title: str, second: tuple[str, ...] = ()) -> Answers:
    """With what the exact solution agrees: the `witness`, by the claim that begins with `title`, and if a checkout has their
    results another program and, by claims that begin with `second`, the benchmark's second one."""
    also = ", its orbits and special points with the second program of the benchmark" if second else ""
    foreign = (f" and with {others.SEM2DPACK}{also}", ("Another program", *second)) if others.FILES else ("", ())
    return {f"The exact solution agrees with {witness}{foreign[0]}.": (title, *foreign[1])}


def as_foreign(title: str, psi: Mapping[str, Mapping[float, float]]) -> Verdict:
    """Verdict on psi at some times in some scenes, by their names in the file of another program, whose values are extrapolated;
    the worst is shown."""
    theirs = others.sem2dpack()
    off = max(abs(ours - theirs[f"{name}.psi.{t:g}"]) for name, by_time in psi.items() for t, ours in by_time.items())
    return claim(title, PROGRAM, off, _EXTRAPOLATED, f"{', '.join(f'`{name}`' for name in psi)}, at t = {places(OTHERS_AT)}")


def of_order(
    title: str,
    evidence: Evidence,
    fit: Fit,
    declared: float,
    remark: str = "",
    within: float = WITHIN,
    above: bool = False,
    widest: float = WIDEST,
) -> Verdict:
    """Verdict on an order of convergence, by `shortfall`: `within` this distance of the declared one, or its own interval; with
    `above` it may be larger."""
    allowed, holds = max(within, fit.half_width), not shortfall(fit, declared, within, above, widest)
    expected, off = asked(fit.order, declared, allowed, above)
    return holding(title, evidence, expected, fit.rounded, holds, remark).with_margin(off, allowed)


def range_of_r(grid: Sequence[float]) -> str:
    """The range of r in a claim's title."""
    return minus(f"log_{{10}} r from {grid[0]:g} to {grid[-1]:g}")


def order_of_periods(listed: Mapping[float, Mapping[str, Sequence[float]]], remark: str) -> Verdict:
    """Verdict on P7 at every r; by r and model, all its periods there."""
    held = sum(
        max(periods["kelvin-voigt"]) < min(periods["delay"])
        and max(periods["delay"]) < min(*periods["block8"], *periods["block12"])
        for periods in listed.values()
    )
    title = f"P7 T_{{ODE}} < T_{{delay}} < T_{{block}} for {range_of_r([*listed])}"
    return every(title, PAPER, held, len(listed), remark, "r")


def numbered_period(closed: Closed) -> Number:
    """The orbit's period on a finer mesh, solved to rounding errors; its error is the difference from that on the orbit's own
    mesh."""
    flow, state = closed.flow.remeshed(closed.cycle, FINER)
    period = close(flow, state, closed.cycle.period, 0.0).cycle.period
    return stated(period, abs(period - closed.cycle.period))
