"""Every reduction's orbit against the delay system's as the waves gain in weight (r grows); its means where none is stable."""

from collections.abc import Mapping

import numpy as np

from slipwave.observe.statistics import Estimate
from validation.studies.model_error import measured
from validation.studies.model_error.first_screen import first_table
from validation.studies.model_error.measured import (
    DAMPED,
    MODELS,
    RUN_AT,
    SHOWN,
    TARGETS,
    TIMED_AT,
    TOLERANCE,
    TRANSITS,
    Runs,
    error,
    states,
)
from validation.study import Budget, Cell, Figure, Number, Omission, StudyResult, Table, table
from validation.study.drawing import WIDTH, Axes, Drawing, canvas, line, pen, ruled
from validation.study.over_r import scene_at
from validation.study.text import places, plain, power
from validation.timing import Setting, warm_up

NAME = "model-error"
QUESTION = "How wrong is each reduction, from the onset to where its motion is irregular, and what does a smaller error cost?"
SCENES = ("paper",)
SECONDS = (6.0, 22.0)
TIMED = True

_FEW = (DAMPED, "fitted:4")
_OWN = 3e-9  # relative error of a figure, at most
_ORBITS = {
    True: (-2.699, -2.69, -2.68, -2.66),
    False: (-2.699, -2.6975, -2.695, -2.69, -2.685, -2.68, -2.675, -2.67, -2.665, -2.66),
}
"""By quick or full report: log10 r from the onset, -2.69955, to where the delay system's orbit loses stability, -2.6575."""

_MEANS = {True: (-2.65,), False: (-2.65, -2.6, -2.55, -2.5, -2.4, -2.3)}
_UNTIL = {True: 6000.0, False: 10000.0}


def run(budget: Budget) -> StudyResult:
    """Every model's orbits and means, and the time of a run."""
    grid, orbits, means, times = _ORBITS[budget.quick], Runs(), Runs(), dict[str, float]()
    for model in budget.each(("delay", *MODELS, *_FEW)):
        warm_up(Setting(model), scene_at(-2.68))
        times[model] = measured.milliseconds_of(model)
        orbits[model] = {log10_r: measured.orbit_of(model, log10_r) for log10_r in (SHOWN if model in _FEW else grid)}
        if model not in _FEW:
            means[model] = {log10_r: measured.mean_at(model, log10_r, _UNTIL[budget.quick]) for log10_r in _MEANS[budget.quick]}
    means[DAMPED] = {log10_r: measured.orbit_of(DAMPED, log10_r) for log10_r in sorted({*_MEANS[budget.quick], RUN_AT})}
    return StudyResult(
        answer=_answer(orbits, means),
        figures=(
            Figure("errors", _CAPTION, lambda: errors_over_r(orbits)),
            Figure("deep", _DEEP_CAPTION, lambda: errors_of_means(means)),
        ),
        tables=(error_table(orbits, times), mean_table(means)),
        verdicts=measured.all_verdicts(orbits, means),
        notes=(_note(times),),
        numbers={
            f"{model} error of {symbol} at {log10_r}": _number(error(orbits, model, log10_r, name).value)
            for model in MODELS
            for log10_r in SHOWN
            for symbol, name in (("T", "period"), ("drop", "drop"))
        }
        | {f"{DAMPED} T at {x}": Number(found.period.value, 1e-8) for x, found in means[DAMPED].items() if found},
        omissions=omissions(orbits),
        model_tables=(first_table(orbits, means, times),),
    )


def _number(error: float) -> Number:
    """A model's error for the baseline: the smaller it is, the more of it is the computation's own."""
    return Number(error, max(1e-5, _OWN / abs(error)))


def _answer(orbits: Runs, means: Runs) -> str:
    errors = {
        model: plain(abs(error(orbits, model, -2.68, "period").value), ".0e") for model in ("kelvin-voigt", *TARGETS, "modal:8")
    }
    last = max(means["delay"])
    ode, eight, damped = (error(means, model, last, "period") for model in ("kelvin-voigt", "modal:8", DAMPED))
    return (
        f"At log_{{10}} r = −2.68 the paper’s ODE misses the period by {errors['kelvin-voigt']}, one exact mode of the slabs "
        f"(one state more) by {errors['modal:1']}, two by {errors['modal:2']}, eight by {errors['modal:8']}. At −{-last:g}, "
        f"where no orbit of the exact system is stable, the mean period is off by {_percent(ode.value)} in the ODE, by "
        f"{_percent(eight.value)} ± {_percent(2.0 * eight.error)} with eight modes, and by {_percent(damped.value)} "
        "in the quasi-dynamic model."
    )


def _percent(value: float) -> str:
    return f"{100 * value:.2g} %".replace("-", "−")


def _note(times: dict[str, float]) -> str:
    listed = ", ".join(f"{times[model]:.0f} ms with `{model}`" for model in ("delay", "modal:1", "modal:8"))
    where = f"{TRANSITS:.0f} transits at log_{{10}} r = {places([TIMED_AT])}"
    return f"{where} take {listed}: steps follow slip events, not the number of states."


_CAPTION = (
    "Relative error of period T (left) and stress drop Δμ (right) of each reduction’s orbit against the delay system’s, by "
    "Newton’s method, over r from the onset to where the exact orbit loses stability. A dip is a change of sign."
)
_DEEP_CAPTION = (
    "The same beyond, where no orbit of the delay system is stable: signed differences of the means of T and Δμ over the "
    "cycles of a long run. Bars: two standard errors, which allow for the dependence of a cycle on those before it."
)


_QUANTITIES = {"period": "period $T$", "drop": r"stress drop $\Delta\mu$"}
_ALIKE = 1e-6  # relative standard error of cycles that repeat
_SPREAD = 0.003  # log10 r: models beside each other at one r, so that their bars can be told apart


def error_table(orbits: Runs, times: Mapping[str, float]) -> Table:
    """Errors of period and drop, and the time of 1000 transits."""
    rows = []
    for model in ("delay", *MODELS, "fitted:4", DAMPED):
        exact = model == "delay"
        cells: list[Cell] = [model, None if exact else states(model)]
        cells += [None if exact else error(orbits, model, x, name).value for x in SHOWN for name in _QUANTITIES]
        rows.append([*cells, times[model]])
    each = [f"T, {log10_r:.2f} [relative] .1e | Δμ [relative] .1e".replace("-", "−") for log10_r in SHOWN]
    caption = (
        "Errors of period T and stress drop Δμ of the orbits, by Newton’s method, against the delay system at log_{10} r = "
        f"{places(SHOWN)}; and the time of {TRANSITS:.0f} transits at {places([TIMED_AT])} and tolerance {power(TOLERANCE)}, "
        "march and event detection. States: ψ, elastic stress, rate if there is mass, two per mode; the delay system’s state is "
        "a function. A dash: there is no orbit."
    )
    return table("models", caption, " | ".join(["model | states .0f", *each, "run [ms] .0f"]), rows, (0,))


def mean_table(means: Runs) -> Table:
    """Means of period and drop with their standard errors."""
    rows = [
        (model, log10_r, mean.period.value, _scatter(mean.period), mean.drop.value, _scatter(mean.drop))
        for log10_r in means["delay"]
        for model in ("delay", *MODELS, DAMPED)
        if (mean := means[model][log10_r])
    ]
    heading = "model | log_{10} r .2f | mean T [transits] .5g | error .1e | mean Δμ [σ] .4f | error .1e"
    caption = (
        "Means over the cycles of a run where no orbit of the delay system is stable, each with its standard "
        f"error; a dash: the cycles are all alike, as on the stable orbit that `{DAMPED}` has from its onset on."
    )
    return table("deep", caption, heading, rows)


def _scatter(mean: Estimate) -> Cell:
    return mean.error if mean.error > _ALIKE * mean.value else None


def omissions(orbits: Runs) -> tuple[Omission, ...]:
    """Models without an orbit to compare."""
    lost = [f"`{model}` at {places([x])}" for model in ("delay", *MODELS) for x, orbit in orbits[model].items() if not orbit]
    left_out = [Omission("Quasi-static model.", "It has no limit cycle.")]
    steady = [x for x, orbit in orbits[DAMPED].items() if not orbit]
    if steady:
        why = (
            f"It slides steadily there; it sticks and slips from log_{{10}} r = {places([measured.onset_of_damped()], '.3f')} on."
        )
        left_out.append(Omission(f"Quasi-dynamic orbits at {places(steady)}.", why))
    if lost:
        left_out.append(Omission("Points where no orbit was found.", f"{', '.join(lost)}."))
    return tuple(left_out)


def errors_over_r(orbits: Runs) -> Drawing:
    """Absolute errors of the orbits' periods and drops; a missing orbit leaves a gap."""
    figure, panels = _panels()
    for axes, quantity in zip(panels, _QUANTITIES, strict=True):
        for model in MODELS:
            look = line(model, marker=pen(model).marker, linewidth=1.1)
            axes.semilogy(list(orbits["delay"]), measured.column(orbits, model, quantity), **look)
    panels[0].set_ylabel("relative error")
    figure.legend(handles=panels[0].get_lines(), loc="outside upper left", ncols=4, handlelength=3.0)
    return figure


def errors_of_means(means: Runs) -> Drawing:
    """Signed differences of the means, in per cent, with two standard errors."""
    figure, panels = _panels()
    grid = np.array(list(means["delay"]))
    for axes, quantity in zip(panels, _QUANTITIES, strict=True):
        for place, model in enumerate((*MODELS, DAMPED)):
            values = 100.0 * measured.column(means, model, quantity, lambda one: one.value)
            bars = 200.0 * measured.column(means, model, quantity, lambda one: one.error)
            at = grid + _SPREAD * (place - 0.5 * len(MODELS))
            look = line(model, linestyle="none", linewidth=1.0, marker=pen(model).marker)
            axes.errorbar(at, values, bars, capsize=2.0, **look)
        axes.axhline(0.0, color="#111111", linewidth=0.8)
    panels[0].set_ylabel("difference of the means (%)")
    figure.legend(handles=panels[0].containers, loc="outside upper left", ncols=4, handlelength=3.0)
    return figure


def _panels() -> tuple[Drawing, list[Axes]]:
    """Two panels side by side, period and drop over r."""
    figure = canvas(WIDTH, 4.4)
    panels = list(figure.subplots(1, 2, sharey=True))
    for axes, title in zip(panels, _QUANTITIES.values(), strict=True):
        axes.set(title=title, xlabel=r"$\log_{10} r$")
        ruled(axes)
    return figure, panels
