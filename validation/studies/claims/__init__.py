"""The paper's claims that runs and closed forms can settle; those about whole branches are judged by `bifurcation`."""

import math
from typing import Any

import numpy as np

import slipwave
from validation.studies.claims import measured
from validation.studies.claims.measured import LARGE_NUDGE, LONGEST, MODELS, SHOWN, Deep, Orbits, Ripples, recurrence, spread
from validation.study import Budget, Cell, Figure, Number, Omission, Outcome, StudyResult, Table, Verdict, stated, table
from validation.study.drawing import Drawing, pen, subplots
from validation.study.text import minus

NAME = "claims"
QUESTION = "Which of the paper’s claims hold?"
SCENES = ("paper", "paper-2.3")
SECONDS = (10.0, 20.0)

_LOG10_R = {
    True: (-2.695, -2.69, -2.685, -2.68, -2.67, -2.665, -2.66),
    False: tuple(round(-2.695 + 0.0025 * n, 4) for n in range(15)),
}
"""By quick or full report: from just beyond the onset to where the delay system's orbit loses stability (-2.6575)."""

_SAME = 1e-4  # relative difference of periods of one orbit
_SPEEDS = (1.0, 10.0, 100.0, 1e3, 1e4)


def run(budget: Budget) -> StudyResult:
    """Settle orbits along the stable branch, run deep inside it, evaluate the closed forms."""
    found = {log10_r: measured.settled_at(log10_r) for log10_r in budget.each(_LOG10_R[budget.quick], end=0.6)}
    orbits = {log10_r: models for log10_r, models in found.items() if models}
    deep = {
        model: measured.run_deep(model, 6000.0 if budget.quick else 16000.0)
        for model in ("delay", "kelvin-voigt", "quasidynamic")
    }
    ripples = {model: measured.measure_ripples(model) for model in ("delay", "kelvin-voigt")}
    verdicts = measured.all_verdicts(orbits, deep, ripples)
    return StudyResult(
        answer=_answer(verdicts),
        figures=(
            Figure("irregular", _CAPTION, lambda: irregular(deep), paper="Fig 9", carries=("P13 ",), zoom=True),
            Figure("planes", _PLANES, lambda: slip_planes(deep), paper="Fig 9", carries=("P13 ",)),
            Figure("returns", _RETURNS, lambda: returns(deep), zoom=True),
        ),
        tables=(_branch_table(orbits), _onset_table(), _deep_table(deep)),
        verdicts=verdicts,
        notes=(_NUMBERED, _two_orbits(orbits)),
        numbers=_numbers(orbits, ripples),
        omissions=_OMISSIONS,
    )


def _two_orbits(orbits: Orbits) -> str:
    """Whether another start finds another orbit at the largest r."""
    largest = max(orbits)
    usual, other = orbits[largest]["delay"].period.value, measured.from_large_nudge(largest).period.value
    at = minus(f"At log_{{10}} r = {largest:g}")
    if abs(other / usual - 1.0) < _SAME:
        return f"{at} a nudge of {LARGE_NUDGE:g} leads to the same orbit as the scene’s own start."
    return (
        f"{at} the delay system has two stable orbits: runs from the scene’s own start settle at T = {usual:.4f} transits, runs "
        f"from a nudge of {LARGE_NUDGE:g} at T = {other:.4f}. The verdicts above are about the first."
    )


def _answer(verdicts: tuple[Verdict, ...]) -> str:
    held, findings = (sum(verdict.outcome is kind for verdict in verdicts) for kind in (Outcome.PASS, Outcome.FINDING))
    return (
        f"Of {len(verdicts)} checks {held} hold and {findings} qualify a claim; those about branches are judged by the "
        "studies `bifurcation` and `period-doubling`."
    )


def _numbers(orbits: Orbits, ripples: dict[str, Ripples]) -> dict[str, Number]:
    periods = {f"{model} T at {r}": orbit.period for r, models in orbits.items() for model, orbit in models.items()}
    return {name: stated(found.value, found.error) for name, found in periods.items()} | {
        f"{model} ripple period": Number(measured.period, 1e-3) for model, measured in ripples.items()
    }


def _branch_table(orbits: Orbits) -> Table:
    symbols = {"stress_drop": "Δμ", "elastic_stress_drop": "Δy"}
    drops = [(symbol, name, model) for name, symbol in symbols.items() for model in MODELS[:2]]
    rows = (
        (r, *(found[model].period.value for model in MODELS), *(getattr(found[model], name).value for _, name, model in drops))
        for r, found in orbits.items()
    )
    columns = [*(f"T [{model}] .7g" for model in MODELS), *(f"{symbol} [{model}] .5f" for symbol, _, model in drops)]
    caption = "Settled orbits along the stable part of the branch. T: period in transits; Δμ, Δy: stress and elastic drop."
    return table("branch", caption, " | ".join(["log_{10} r .4f", *columns]), rows)


def _onset_table() -> Table:
    rows = (
        (v, o.omega_c, math.log10(o.r_delay), math.log10(o.r_kelvin_voigt), o.r_kelvin_voigt / o.r_delay - 1.0)
        for v, o in ((v, measured.onset_at(v)) for v in _SPEEDS)
    )
    heading = (
        "V [V*] .0f | ω_{c} [V*/L] .6g | log_{10} r_{c} [delay, (39)] .7f | log_{10} r_{c} [ODE, (27)] .7f | "
        "error of (27) [relative] .1e"
    )
    return table("onset", "Onset of stick-slip by the closed forms, paper material, ε = 2.8 · 10^{-5}.", heading, rows)


def _deep_table(deep: dict[str, Deep]) -> Table:
    rows = list[tuple[Cell, ...]]()
    for model, run in deep.items():
        e = run.events
        stated = [f(column) for column in (e.period, e.stress_drop, np.log10(e.v_max)) for f in (np.mean, spread, recurrence)]
        rows.append((model, float(e.time.size), *map(float, stated), float(e.v_max.max())))
    symbols = ("T [mean, transits]", "Δμ [mean, σ]", "log_{10} v_{max} [mean, V*]")
    stated_of = [f"{symbol} .4g | spread [of the mean] .1% | recurrence .2f" for symbol in symbols]
    caption = (
        f"Statistics of the cycles at log_{{10}} r = −2.3 after the first {SHOWN[0]:g} transits: mean, standard deviation over "
        f"mean, and how far the sequence is from repeating itself after up to {LONGEST} cycles (0: periodic, 1: no memory)."
    )
    return table("deep", caption, " | ".join(["model | cycles .0f", *stated_of, "v_{max} [V*] .1e"]), rows)


def irregular(deep: dict[str, Deep]) -> Drawing:
    """Stress over time, one panel per model."""
    figure, grid = subplots(3.6, len(deep), 1, "time (transits)", r"$\mu$", sharex=True, sharey=True)
    for axes, (model, run) in zip(grid, deep.items(), strict=True):
        axes.plot(run.time, run.stress, color=pen(model).color, linewidth=0.7)
        axes.set_title(pen(model).label, fontsize=11)
        axes.set_xlim(run.time[0], run.time[-1])
    return figure


def slip_planes(deep: dict[str, Deep]) -> Drawing:
    """Stress over slip rate, one panel per model, with the stress of steady sliding at each rate."""
    law: Any = slipwave.read("paper-2.3").law
    shown = {model: run for model, run in deep.items() if model in ("delay", "kelvin-voigt")}
    figure, panels = subplots(3.4, 1, len(shown), "$v/V^*$", sharex=True, sharey=True)
    for axes, (model, run) in zip(panels, shown.items(), strict=True):
        axes.semilogx(run.slip_rate, run.stress, color=pen(model).color, linewidth=0.5, label=pen(model).label)
        rate = np.geomspace(run.slip_rate.min(), run.slip_rate.max(), 50)
        axes.semilogx(rate, law.a_star + (law.a - law.b) * np.log(rate), color="#d55e00", linestyle="--", label="steady sliding")
        axes.set(title=pen(model).label, ylabel=r"$\mu$")
    axes.legend()
    return figure


def returns(deep: dict[str, Deep]) -> Drawing:
    """Periods and stress drops, each over that of the cycle before."""
    figure, panels = subplots(3.6, 1, 2)
    for axes, name, symbol in zip(panels, ("period", "stress_drop"), ("$T$ (transits)", r"$\Delta\mu$"), strict=True):
        for model, run in deep.items():
            values, look = getattr(run.events, name), pen(model)
            axes.plot(values[:-1], values[1:], look.marker, color=look.color, markersize=3.0, linestyle="none", label=look.label)
        axes.set(xlabel=f"{symbol} of one cycle", ylabel="of the next")
        axes.grid(True)
    figure.legend(handles=panels[0].get_lines(), loc="outside upper left", ncols=2)
    return figure


_NUMBERED = "P1, P2 ... number the claims of the paper in the order in which they appear there, from its section 2 to its Fig 9."
_RETURNS = (
    "Return maps at log_{10} r = −2.3: each cycle’s period and stress drop against those of the previous cycle. A periodic orbit "
    "would be a few points."
)
_PLANES = "The same cycles in the plane of stress and slip rate (the paper’s Fig 9); dashed: steady sliding."
_CAPTION = (
    "Stress at log_{10} r = −2.3 over some cycles (the paper’s Fig 9): the stress drops of the delay system vary little, but "
    "its ripples are no longer sinusoidal and change shape from cycle to cycle; the paper’s ODE is irregular. μ in units of σ, "
    "time in transits."
)
_BRANCHES = "Judged by the study `bifurcation`, on branches."
_OMISSIONS = (
    Omission("P8, mildly subcritical Hopf point (Fig 6).", _BRANCHES, ("P8 ",)),
    Omission("P9, period doublings and torus of the ODE (Fig 6b).", _BRANCHES, ("P9 ",)),
    Omission("P10, unstable primary orbit with T = 79.09 (Fig 7).", "Judged by the study `period-doubling`.", ("P10 ",)),
    Omission("P14, bifurcations of the delay system.", _BRANCHES, ("P14 ",)),
    Omission(
        "P7 and P11 beyond log_{10} r = −2.66.",
        "The delay system’s orbit loses stability there; runs then show a torus, not the orbit.",
        ("Special points of `delay`", "Beyond the first torus point a direct run does not settle"),
    ),
)
