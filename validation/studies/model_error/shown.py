"""The reductions' errors as tables and over r, and what is left out."""

from collections.abc import Mapping

import numpy as np

from slipwave.observe.statistics import Estimate
from validation.studies.model_error.runs import (
    DAMPED,
    MODELS,
    SHOWN,
    TIMED,
    TIMED_AT,
    TOLERANCE,
    Runs,
    column,
    error,
    onset_of_damped,
    sizes,
    states,
)
from validation.study import Cell, Omission, Table, table
from validation.study.drawing import WIDTH, Axes, Drawing, canvas, pen, ruled
from validation.study.text import places, power

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
        f"{places(SHOWN)}; and the time of {TIMED:.0f} transits at {places([TIMED_AT])} and tolerance {power(TOLERANCE)}, march "
        "and event detection. States: ψ, elastic stress, rate if there is mass, two per mode; the delay system’s state is a "
        "function. A dash: there is no orbit."
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
        why = f"It slides steadily there; it sticks and slips from log_{{10}} r = {places([onset_of_damped()], '.3f')} on."
        left_out.append(Omission(f"Quasi-dynamic orbits at {places(steady)}.", why))
    if lost:
        left_out.append(Omission("Points where no orbit was found.", f"{', '.join(lost)}."))
    return tuple(left_out)


def errors_over_r(orbits: Runs) -> Drawing:
    """Absolute errors of the orbits' periods and drops; a missing orbit leaves a gap."""
    figure, panels = _panels()
    for axes, quantity in zip(panels, _QUANTITIES, strict=True):
        for model in MODELS:
            look = pen(model)
            axes.semilogy(
                list(orbits["delay"]),
                sizes(orbits, model, quantity),
                color=look.color,
                linestyle=look.dashes,
                marker=look.marker,
                linewidth=1.1,
                label=look.label,
            )
    panels[0].set_ylabel("relative error")
    figure.legend(handles=panels[0].get_lines(), loc="outside upper left", ncols=4, handlelength=3.0)
    return figure


def errors_of_means(means: Runs) -> Drawing:
    """Signed differences of the means, in per cent, with two standard errors."""
    figure, panels = _panels()
    grid = np.array(list(means["delay"]))
    for axes, quantity in zip(panels, _QUANTITIES, strict=True):
        for place, model in enumerate((*MODELS, DAMPED)):
            look, beside = pen(model), _SPREAD * (place - 0.5 * len(MODELS))
            values, bars = (
                100.0 * column(means, model, quantity, part) for part in (lambda one: one.value, lambda one: 2.0 * one.error)
            )
            axes.errorbar(
                grid + beside,
                values,
                bars,
                color=look.color,
                marker=look.marker,
                linestyle="none",
                capsize=2.0,
                linewidth=1.0,
                label=look.label,
            )
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
