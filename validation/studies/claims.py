"""The paper's claims that runs and closed forms can settle; those about whole branches wait for continuation."""

from validation.studies.claims_figures import irregular
from validation.studies.claims_runs import Branch, measure_ripple, run_deep, settle_branch
from validation.studies.claims_tables import branch_table, deep_table, onset_table
from validation.studies.claims_verdicts import all_verdicts
from validation.study import Budget, Figure, Number, Omission, Outcome, StudyResult, Verdict

NAME = "claims"
QUESTION = "Which of the paper’s claims hold?"
SCENES = ("paper", "paper-2.3")
SECONDS = (8.0, 12.0)


def run(budget: Budget) -> StudyResult:
    """Settle orbits along the stable branch, run deep inside it, evaluate the closed forms."""
    branch = settle_branch(lambda share: budget.report(0.6 * share))
    deep = {model: run_deep(model, 3000.0 if budget.quick else 8000.0) for model in ("delay", "kelvin-voigt")}
    ripples = {model: measure_ripple(model) for model in ("delay", "kelvin-voigt")}
    verdicts = all_verdicts(branch, deep, ripples)
    return StudyResult(
        answer=_answer(verdicts),
        figures=(Figure("irregular", _CAPTION, lambda: irregular({m: (d.time, d.stress) for m, d in deep.items()})),),
        tables=(branch_table(branch), onset_table(), deep_table(deep)),
        verdicts=verdicts,
        notes=(
            "P1, P2 ... number the claims of the paper in the order in which they appear there, from its section 2 to its Fig 9.",
        ),
        numbers=_numbers(branch, ripples),
        omissions=_OMISSIONS,
    )


def _answer(verdicts: tuple[Verdict, ...]) -> str:
    findings = [verdict for verdict in verdicts if verdict.outcome is Outcome.FINDING]
    held = sum(verdict.outcome is Outcome.PASS for verdict in verdicts)
    waiting = sum(omission.what.startswith("P") and "beyond" not in omission.what for omission in _OMISSIONS)
    return (
        f"Of {len(verdicts)} checks {held} hold and {len(findings)} qualify a claim; {waiting} claims about branches wait for "
        "continuation."
    )


def _numbers(branch: Branch, ripples: dict[str, float]) -> dict[str, Number]:
    numbers = {
        f"{model} T at {r}": Number(orbit.period.value, 1e-7) for model, orbits in branch.items() for r, orbit in orbits.items()
    }
    return numbers | {f"{model} ripple period": Number(value, 1e-3) for model, value in ripples.items()}


_CAPTION = (
    "Stress at log_{10} r = −2.3 over some cycles (the paper’s Fig 9): the delay system keeps its drops, with ripples that are "
    "no longer sinusoidal and change shape from cycle to cycle; the paper’s ODE is irregular. μ in units of σ, time in "
    "transits."
)

_OMISSIONS = (
    Omission(
        "P8, mildly subcritical Hopf point (Fig 6).",
        "Needs the unstable branch: continuation of periodic orbits is not here yet.",
    ),
    Omission("P9, period doublings and torus of the ODE (Fig 6b).", "Needs continuation with multipliers."),
    Omission("P10, unstable primary orbit with T = 79.09 (Fig 7).", "Needs Newton on the orbit; a run cannot stay on it."),
    Omission("P14, bifurcations of the delay system.", "Needs continuation of the delay system."),
    Omission(
        "P7 and P11 beyond log_{10} r = −2.66.",
        "The delay system’s orbit loses stability there; runs then show a torus, not the orbit.",
    ),
)
