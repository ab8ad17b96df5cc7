"""What the two orbits must show: P10, the closed bubble of doubled orbits (P9), agreement with AUTO-07p and with a run."""

from validation.references.published import half_digit, reference
from validation.studies.period_doubling.runs import AT, Bubble, Doubled, end
from validation.study import Evidence, Verdict, of_paper
from validation.study.bounds import bounded

_PERIOD = 3e-5  # transits; 2.6e-6 was measured, the digits of r in the reference
_RUN = 1e-10  # 2e-12 was measured
_PASSES = 0.03  # 5e-3 was measured
_ENDS = 3e-7  # of log10 r; 1.5e-8 was measured, the straight line's


def all_verdicts(found: Doubled) -> tuple[Verdict, ...]:
    """In the order of the page."""
    return published(found), as_run(found), p10(found), closes(found)


def published(found: Doubled) -> Verdict:
    """The period at the r that AUTO-07p gives."""
    return bounded(
        "The orbit of T = 79.09 lies where AUTO-07p finds it",
        Evidence.WITNESS,
        abs(found.single.orbit.period.value - reference()["paper"]["T_unstable_ode"]),
        _PERIOD,
        f"transits, at log_{{10}} r = {AT:.6f}".replace("= -", "= −"),
    )


def as_run(found: Doubled) -> Verdict:
    """The doubled orbit against a run that settles on it."""
    claim = "A direct run settles on the doubled orbit"
    remark = "relative difference of two cycles of a run from the doubled period by Newton’s method"
    return bounded(claim, Evidence.WITNESS, abs(found.last_two / found.double.orbit.period.value - 1.0), _RUN, remark)


def p10(found: Doubled) -> Verdict:
    """The paper's Fig 7."""
    known = reference()["paper"]["T_unstable_ode"]
    period, lead = found.single.orbit.period.value, float(found.single.multipliers.values[0].real)
    holds = abs(period - known) <= half_digit(known) and found.single.multipliers.stable is False and lead < -1.0
    return of_paper(
        "P10 At r = 10^{-2.59} the primary orbit with T = 79.09 is unstable, and a doubled orbit beside it is stable",
        f"T = {known}",
        f"T = {period:.6f}",
        holds and found.double.multipliers.stable is True,
        f"multiplier {lead:.5f} of the primary orbit; the doubled one has T = {found.double.orbit.period.value:.6f}, half of it "
        f"is {0.5 * found.double.orbit.period.value:.6f}".replace("-", "−"),
    )


def closes(found: Doubled) -> Verdict:
    """Both ends of the branch of doubled orbits against the period doublings of the single one."""
    doublings = sorted(one.point.parameter for one in found.special if one.kind == "PD")
    bubble = found.bubble
    ends = (end(bubble[1], bubble[0]), end(bubble[-2], bubble[-1]))
    off = max(abs(one - other) for one, other in zip(ends, doublings, strict=True)) if len(doublings) == 2 else float("nan")
    claim = "P9 The doubled orbits connect the two period doublings of the pair: their branch is a closed bubble"
    remark = "log_{10} r; where the doubled orbits’ multiplier reaches 1, against where the single orbit’s passes −1"
    return bounded(claim, Evidence.EXACT, off, _ENDS, remark)


def ends_simple(bubble: Bubble) -> Verdict:
    """The end of another bubble: the simple orbit that both halves become is at a period doubling of its own."""
    return bounded(
        "P9 The doubled orbits of the other pairs connect two period doublings: each of the three branches is a closed bubble",
        Evidence.EXACT,
        abs(bubble.multiplier + 1.0),
        _PASSES,
        f"distance of the simple orbit’s multiplier from −1 where the halves of the doubled one become the same, log_{{10}} r = "
        f"{bubble.ends:.6f}; born at {bubble.born:.7f}".replace("-", "−"),
    )
