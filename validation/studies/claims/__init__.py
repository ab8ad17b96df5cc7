"""The paper's claims that runs and closed forms can settle; those about whole branches are judged by `bifurcation`."""

from validation.studies.claims.runs import LARGE_NUDGE, Branch, Ripples, beside, measure_ripples, run_deep, settle_branch
from validation.studies.claims.shown import branch_table, deep_table, irregular, onset_table, returns
from validation.studies.claims.verdicts import all_verdicts
from validation.study import Budget, Figure, Number, Omission, Outcome, StudyResult, Verdict

NAME = "claims"
QUESTION = "Which of the paper’s claims hold?"
SCENES = ("paper", "paper-2.3")
SECONDS = (10.0, 20.0)


def run(budget: Budget) -> StudyResult:
    """Settle orbits along the stable branch, run deep inside it, evaluate the closed forms."""
    branch = settle_branch(budget)
    deep = {model: run_deep(model, 6000.0 if budget.quick else 16000.0) for model in ("delay", "kelvin-voigt", "quasidynamic")}
    ripples = {model: measure_ripples(model) for model in ("delay", "kelvin-voigt")}
    verdicts = all_verdicts(branch, deep, ripples)
    return StudyResult(
        answer=_answer(verdicts),
        figures=(Figure("irregular", _CAPTION, lambda: irregular(deep)), Figure("returns", _RETURNS, lambda: returns(deep))),
        tables=(branch_table(branch), onset_table(), deep_table(deep)),
        verdicts=verdicts,
        notes=(
            "P1, P2 ... number the claims of the paper in the order in which they appear there, from its section 2 to its Fig 9.",
            _two_orbits(branch),
        ),
        numbers=_numbers(branch, ripples),
        omissions=_OMISSIONS,
    )


def _two_orbits(branch: Branch) -> str:
    """Whether another start finds another orbit at the largest r."""
    largest = max(branch)
    usual, other = branch[largest]["delay"].period.value, beside(largest).period.value
    at = f"At log_{{10}} r = {largest:g}".replace("-", "−")
    if abs(other / usual - 1.0) < _SAME:
        return f"{at} a nudge of {LARGE_NUDGE:g} leads to the same orbit as the scene’s own start."
    return (
        f"{at} the delay system has two stable orbits: runs from the scene’s own start settle at T = {usual:.4f} transits, runs "
        f"from a nudge of {LARGE_NUDGE:g} at T = {other:.4f}. The verdicts above are about the first."
    )


def _answer(verdicts: tuple[Verdict, ...]) -> str:
    findings = [verdict for verdict in verdicts if verdict.outcome is Outcome.FINDING]
    held = sum(verdict.outcome is Outcome.PASS for verdict in verdicts)
    return (
        f"Of {len(verdicts)} checks {held} hold and {len(findings)} qualify a claim; those about branches are judged by the "
        "studies `bifurcation` and `period-doubling`."
    )


def _numbers(branch: Branch, ripples: dict[str, Ripples]) -> dict[str, Number]:
    numbers = {
        f"{model} T at {r}": Number(orbit.period.value, 1e-7) for r, orbits in branch.items() for model, orbit in orbits.items()
    }
    return numbers | {f"{model} ripple period": Number(measured.period, 1e-3) for model, measured in ripples.items()}


_SAME = 1e-4  # relative difference of periods of one orbit

_RETURNS = (
    "Return maps at log_{10} r = −2.3: each cycle’s period and stress drop against those of the previous cycle. A periodic orbit "
    "would be a few points."
)
_CAPTION = (
    "Stress at log_{10} r = −2.3 over some cycles (the paper’s Fig 9): the stress drops of the delay system vary little, but "
    "its ripples are no longer sinusoidal and change shape from cycle to cycle; the paper’s ODE is irregular. μ in units of σ, "
    "time in transits."
)

_BRANCHES = "Judged by the study `bifurcation`, on branches."
_OMISSIONS = (
    Omission("P8, mildly subcritical Hopf point (Fig 6).", _BRANCHES),
    Omission("P9, period doublings and torus of the ODE (Fig 6b).", _BRANCHES),
    Omission("P10, unstable primary orbit with T = 79.09 (Fig 7).", "Judged by the study `period-doubling`."),
    Omission("P14, bifurcations of the delay system.", _BRANCHES),
    Omission(
        "P7 and P11 beyond log_{10} r = −2.66.",
        "The delay system’s orbit loses stability there; runs then show a torus, not the orbit.",
    ),
)
