"""The bifurcation diagrams that the paper could not draw: orbits of the delay system and of the ODE, stable or not, over r."""

from validation.studies.bifurcation.shown import diagram, special_table, structure_table, wave_table
from validation.studies.bifurcation.verdicts import (
    bubbles,
    index,
    mildly_subcritical,
    modes_converge,
    published,
    same_orbits,
    unlike,
)
from validation.studies.bifurcation.waves import WaveOrbit, wave_orbit
from validation.study import Budget, Figure, Number, Omission, StudyResult, Table, Verdict
from validation.study.over_r import FAR, Branch, branch_of

NAME = "bifurcation"
QUESTION = "How do the periodic orbits of the exact system and of the paper’s ODE depend on r, and where do they lose stability?"
SCENES = ("paper",)
SECONDS = (16.0, 87.0)

_OVERLAID = 1e-6
_ENDS: dict[bool, dict[str, tuple[float, float] | tuple[float, float, float]]] = {
    True: {"delay": (-2.3, 78.5), "kelvin-voigt": (-2.579, FAR)},
    False: {
        "delay": (-2.3, 85.0),
        "kelvin-voigt": (-2.3, FAR),
        "modal:1": (-2.3, 79.3),
        "modal:2": (-2.3, 78.4, _OVERLAID),
        "modal:4": (-2.3, 78.4, _OVERLAID),
        "modal:8": (-2.3, 78.4, _OVERLAID),
    },
}
"""By quick or full report and model: log10 r and the period (transits) at which its branch ends, and the tolerance if it is not
that of the others."""

_WAVES = {True: (-2.69, -2.68), False: (-2.69, -2.68, -2.67, -2.66)}


def run(budget: Budget) -> StudyResult:
    """Follow the branches from their Hopf points; find the full wave's own orbits."""
    ends = _ENDS[budget.quick]
    branches = {model: branch_of(model, *ends[model]) for model in budget.each(ends, end=len(ends) / (len(ends) + 1))}
    waves = [wave_orbit(branches["delay"], log10_r) for log10_r in _WAVES[budget.quick]]
    return StudyResult(
        answer=_answer(branches),
        figures=(Figure("branches", _CAPTION, lambda: diagram(branches.values(), waves)),),
        tables=_tables(branches, waves, budget.quick),
        verdicts=_verdicts(branches, waves, budget.quick),
        notes=(_HOW, *(() if budget.quick else (_FOLDS,))),
        numbers=_numbers(branches),
        omissions=(_P9,) if budget.quick else (),
    )


def _tables(branches: dict[str, Branch], waves: list[WaveOrbit], quick: bool) -> tuple[Table, ...]:
    special = [special_table(branch) for branch in branches.values()]
    delay, *others = branches.values()
    return (*special, *(() if quick else (structure_table(delay, others),)), wave_table(waves))


def _verdicts(branches: dict[str, Branch], waves: list[WaveOrbit], quick: bool) -> tuple[Verdict, ...]:
    delay, ode = branches["delay"], branches["kelvin-voigt"]
    return (
        published(delay),
        published(ode),
        index(branches.values()),
        same_orbits(waves),
        mildly_subcritical(branches.values()),
        *(() if quick else (*bubbles(ode), modes_converge(delay, [branches[f"modal:{n}"] for n in (1, 2, 4, 8)]))),
        unlike(delay, ode),
    )


def _answer(branches: dict[str, Branch]) -> str:
    torus, doubling = branches["delay"].of_kind("NS")[0].point, branches["kelvin-voigt"].of_kind("PD")[0].point
    return (
        "Both are born at a mildly subcritical Hopf point and become stable at a fold. From there on they differ: the orbit of "
        f"the exact system loses stability to a torus at log_{{10}} r = {torus.parameter:.7f} on a branch that folds back "
        f"and forth, that of the ODE by period doubling at {doubling.parameter:.7f}."
    ).replace("-2.", "−2.")


def _numbers(branches: dict[str, Branch]) -> dict[str, Number]:
    numbers: dict[str, Number] = {}
    for model, branch in branches.items():
        numbers[f"{model} HB"] = Number(branch.onset.parameter, 1e-11)
        for kind in ("LP", "PD", "NS"):
            for count, one in enumerate(branch.of_kind(kind), 1):
                numbers[f"{model} {kind} {count}"] = Number(one.point.parameter, 3e-9)
                numbers[f"{model} {kind} {count} T"] = Number(one.point.closed.cycle.period, 3e-6)
    return numbers


_CAPTION = (
    "Period T, stress drop Δμ and elastic stress drop Δy of the periodic orbits over r, the paper’s Fig 6, near the onset (left) "
    "and as far as the branches were followed (right). Stable orbits are thick and solid, unstable ones thin and dotted. "
    "Circles: orbits of the full wave."
)
_HOW = (
    "Orbits are found by Newton’s method on the motion over one period, whether they are stable or not, and followed by "
    "pseudo-arclength from the Hopf point. Multipliers are computed anew at every point. Special points are bracketed where the "
    "number of unstable multipliers or the direction of the branch changes."
)
_FOLDS = (
    "The branch of the delay system is cut where a new ripple has entered the cycle several times; it folds about once per "
    "transit of T, and pairs of folds go on. With one exact mode of the slabs (`modal:1`) the folds are there, and the torus "
    "points begin a ripple later; with two (`modal:2`) they begin where the delay system’s do; the paper’s ODE has other "
    "bifurcations altogether."
)
_P9 = Omission("P9, period doublings and torus of the ODE.", "The quick report ends its branch after two doublings.")
