"""The paper's claims that runs and closed forms can settle; those about whole branches are judged by `bifurcation`."""

import math

import numpy as np

from validation.studies.claims.measured import (
    LARGE_NUDGE,
    LONGEST,
    MODELS,
    SHOWN,
    Branch,
    Deep,
    Ripples,
    all_verdicts,
    beside,
    measure_ripples,
    onset_at,
    recurrence,
    run_deep,
    settle_branch,
    spread,
)
from validation.study import Budget, Cell, Figure, Number, Omission, Outcome, StudyResult, Table, Verdict, table
from validation.study.drawing import WIDTH, Drawing, canvas, pen

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


_SPEEDS = (1.0, 10.0, 100.0, 1e3, 1e4)


def branch_table(branch: Branch) -> Table:
    """Periods and drops along the stable branch."""
    rows = []
    for r, orbits in branch.items():
        periods = [orbits[model].period.value for model in MODELS]
        drops = [getattr(orbits[model], name).value for name in ("stress_drop", "elastic_stress_drop") for model in MODELS[:2]]
        rows.append((r, *periods, *drops))
    drops_of = [f"{symbol} [{model}] .5f" for symbol in ("Δμ", "Δy") for model in MODELS[:2]]
    heading = " | ".join(["log_{10} r .4f", *(f"T [{model}] .7g" for model in MODELS), *drops_of])
    caption = "Settled orbits along the stable part of the branch. T: period in transits; Δμ, Δy: stress and elastic drop."
    return table("branch", caption, heading, rows)


def onset_table() -> Table:
    """Onset of stick-slip by the closed forms, over the drive."""
    rows = (
        (v, o.omega_c, math.log10(o.r_delay), math.log10(o.r_kelvin_voigt), o.r_kelvin_voigt / o.r_delay - 1.0)
        for v, o in ((v, onset_at(v)) for v in _SPEEDS)
    )
    heading = (
        "V [V*] .0f | ω_{c} [V*/L] .6g | log_{10} r_{c} [delay, (39)] .7f | log_{10} r_{c} [ODE, (27)] .7f | "
        "error of (27) [relative] .1e"
    )
    return table("onset", "Onset of stick-slip by the closed forms, paper material, ε = 2.8 · 10^{-5}.", heading, rows)


def deep_table(deep: dict[str, Deep]) -> Table:
    """Statistics of the irregular runs."""
    rows: list[tuple[Cell, ...]] = []
    for model, run in deep.items():
        e = run.events
        stated = [f(column) for column in (e.period, e.stress_drop, np.log10(e.v_max)) for f in (np.mean, spread, recurrence)]
        rows.append((model, float(e.time.size), *map(float, stated), float(e.v_max.max())))
    stated_of = [
        f"{symbol} [mean, {unit}] .4g | spread [of the mean] .1% | recurrence .2f"
        for symbol, unit in (("T", "transits"), ("Δμ", "σ"), ("log_{10} v_{max}", "V*"))
    ]
    heading = " | ".join(["model | cycles .0f", *stated_of, "v_{max} [V*] .1e"])
    caption = (
        f"Statistics of the cycles at log_{{10}} r = −2.3 after the first {SHOWN[0]:g} transits: mean, standard deviation over "
        f"mean, and how far the sequence is from repeating itself after up to {LONGEST} cycles (0: periodic, 1: no memory)."
    )
    return table("deep", caption, heading, rows)


def irregular(deep: dict[str, Deep]) -> Drawing:
    """Stress over time, one panel per model."""
    figure = canvas(WIDTH, 3.6)
    grid = figure.subplots(len(deep), 1, sharex=True, sharey=True)
    for axes, (model, run) in zip(grid, deep.items(), strict=True):
        style = pen(model)
        axes.plot(run.time, run.stress, color=style.color, linewidth=0.7)
        axes.set_title(style.label, fontsize=11)
        axes.set(ylabel=r"$\mu$", xlim=(run.time[0], run.time[-1]))
    grid[-1].set_xlabel("time (transits)")
    return figure


def returns(deep: dict[str, Deep]) -> Drawing:
    """Periods and stress drops, each over that of the cycle before."""
    figure = canvas(WIDTH, 3.6)
    panels = figure.subplots(1, 2)
    for model, run in deep.items():
        style = pen(model)
        look = {"color": style.color, "markersize": 3.0, "linestyle": "none", "label": style.label}
        for axes, values in zip(panels, (run.events.period, run.events.stress_drop), strict=True):
            axes.plot(values[:-1], values[1:], style.marker, **look)
    for axes, symbol in zip(panels, ("$T$ (transits)", r"$\Delta\mu$"), strict=True):
        axes.set(xlabel=f"{symbol} of one cycle", ylabel="of the next")
        axes.grid(True)
    figure.legend(handles=panels[0].get_lines(), loc="outside upper left", ncols=2)
    return figure
