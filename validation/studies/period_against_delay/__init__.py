"""The period of stick-slip over the delay r, the paper's Fig 8, from the onset to log10 r = -2.3."""

from validation.studies.period_against_delay.law import MASSES, period_of
from validation.studies.period_against_delay.runs import Periods, orbit, periods_at, settled_period
from validation.studies.period_against_delay.shown import mean_table, period_table, periods_over_r
from validation.studies.period_against_delay.verdicts import at_onset, known, order, printed, settled, thick
from validation.study import Budget, Figure, Number, StudyResult
from validation.study.over_r import FAR, branch_of, scene_at

NAME = "period-against-delay"
QUESTION = "How does the period of stick-slip depend on the delay, in the exact system, the paper’s ODE and the blocks?"
SCENES = ("paper",)
SECONDS = (5.0, 18.0)

_ENDS = {True: {"kelvin-voigt": (-2.64, FAR), "delay": (-2.3, 74.6)}, False: {"kelvin-voigt": (-2.3, FAR), "delay": (-2.3, 80.0)}}
"""By quick or full report and model: log10 r and the period (transits) at which its branch ends."""

_GRID = {
    True: (-2.69, -2.68, -2.65, -2.5, -2.3),
    False: (-2.695, -2.69, -2.68, -2.67, -2.66, -2.65, -2.64, -2.62, -2.6, -2.575, -2.55, -2.5, -2.45, -2.4, -2.35, -2.3),
}
_UNTIL = {True: 6000.0, False: 20000.0}
_THICK = (-2.5, -2.3, -2.0, -1.5, -1.0, -0.5, 0.0)
_RUN = (
    ("delay", -2.69),
    ("delay", -2.68),
    ("kelvin-voigt", -2.69),
    ("kelvin-voigt", -2.65),
    ("block8", -2.5),
    ("block12", -2.3),
)


def run(budget: Budget) -> StudyResult:
    """Follow both branches, find the blocks' orbits, and run where no orbit is stable."""
    quick = budget.quick
    branches = {model: branch_of(model, *_ENDS[quick][model]) for model in budget.each(_ENDS[quick], end=0.7)}
    listed = [periods_at(log10_r, branches, _UNTIL[quick]) for log10_r in _GRID[quick]]
    budget.report(0.9)
    ratios = {model: {x: orbit(model, x).cycle.period / period_of(scene_at(x), model) for x in _THICK} for model in MASSES}
    runs = {place: settled_period(*place) for place in _RUN}
    return StudyResult(
        answer=_answer(listed),
        figures=(Figure("over-r", _CAPTION, lambda: periods_over_r(branches, listed, ratios)),),
        tables=(period_table(listed), mean_table(listed)),
        verdicts=(order(listed), printed(listed), known(listed), settled(listed, runs), at_onset(branches), thick(ratios)),
        notes=(_ENERGY,),
        numbers=_numbers(listed),
    )


def _answer(listed: list[Periods]) -> str:
    first = listed[0]
    apart = first.range_of("block12")[1] / first.range_of("kelvin-voigt")[0] - 1.0
    return (
        f"It grows with r, fastest near the onset, where the models agree: within {100 * apart:.0f} % at log_{{10}} r = "
        f"{first.log10_r:g}. Further on the ODE’s period hardly grows and the blocks’ grows too much; the exact system’s lies "
        "between them."
    ).replace("= -", "= −")


def _numbers(listed: list[Periods]) -> dict[str, Number]:
    return {f"{model} T at {one.log10_r:g}": Number(found[0], 1e-8) for one in listed for model, found in one.orbits.items()}


_CAPTION = (
    "Period of stick-slip over the delay r, the paper’s Fig 8. Left: orbits of the delay system and of the ODE by continuation "
    "from the Hopf point, stable ones thick and solid, unstable ones thin and dotted; means over the cycles of runs, with two "
    "standard errors, where no orbit is stable; the blocks, whose orbits are all stable; grey: the law for thick slabs. Right: "
    "the blocks’ periods over that law."
)
_ENERGY = (
    "The paper explains the order by the energy that fast oscillations take. The law for thick slabs says the same: a block "
    "loses nothing and swings through, so that the elastic drop is twice the fall of friction; slabs keep part of the energy in "
    "waves."
)
