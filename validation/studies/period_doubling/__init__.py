"""The ODE's unstable orbit beside its doubled one (the paper's Fig 7), and the bubble of doubled orbits between two doublings."""

from validation.studies.period_doubling.runs import AT, NEAR, Doubled, bubble, doubled
from validation.studies.period_doubling.shown import bubble_table, orbit_table, planes
from validation.studies.period_doubling.verdicts import all_verdicts, ends_simple
from validation.study import Budget, Figure, Number, Omission, StudyResult

NAME = "period-doubling"
QUESTION = "What becomes of the paper’s ODE where its orbit loses stability by period doubling?"
SCENES = ("paper",)
SECONDS = (10.0, 24.0)

_PAIRS = ((-2.571, -2.535), (-2.5375, -2.47))
"""log10 r on both sides of the other pairs of period doublings."""


def run(budget: Budget) -> StudyResult:
    """Find both orbits, and follow both branches to the period doublings; then the other pairs."""
    found = doubled()
    budget.report(0.3)
    others = [] if budget.quick else [bubble(*ends) for ends in _PAIRS]
    return StudyResult(
        answer=_answer(found),
        figures=(Figure("planes", _CAPTION, lambda: planes(found, others)),),
        tables=(orbit_table(found), *([bubble_table(others)] if others else [])),
        verdicts=(*all_verdicts(found), *map(ends_simple, others)),
        notes=(_HOW,),
        numbers={
            "T": Number(found.single.orbit.period.value, 1e-9),
            "doubled T": Number(found.double.orbit.period.value, 1e-9),
            "multiplier": Number(float(found.single.multipliers.values[0].real), 1e-7),
            "doubled multiplier": Number(float(found.double.multipliers.values[0].real), 1e-6),
        },
        omissions=(_OTHERS,) if budget.quick else (),
    )


def _answer(found: Doubled) -> str:
    low, high = sorted(one.point.parameter for one in found.special)
    return (
        f"Its orbit is unstable from log_{{10}} r = {low:.7f} to {high:.7f}. A stable orbit of twice the period is born at "
        "one end and vanishes at the other."
    ).replace("-", "−")


_CAPTION = (
    f"The ODE’s orbits at log_{{10}} r = {AT:.6f}, the paper’s Fig 7: the unstable one of T = 79.09 transits (dotted) and the "
    "stable one of twice the period. Below: periods of the single orbits over r and, between the two period doublings, half the "
    "periods of the doubled ones; in the full report those of the other two pairs too."
).replace("= -", "= −")
_HOW = (
    "Both orbits come from Newton’s method on the motion over one or two cycles; it began from a run that passes the unstable "
    "orbit and settles on the doubled one. The branch of doubled orbits is followed in both directions until their largest "
    f"multiplier exceeds {NEAR:g}; a straight line takes it to 1."
)
_OTHERS = Omission("The other two pairs of period doublings.", "The quick report does not follow their doubled orbits.")
