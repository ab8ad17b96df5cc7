"""Tables and pictures for the paper's claims."""

import math

import numpy as np

from validation.studies.claims.runs import LONGEST, MODELS, SHOWN, Branch, Deep, onset_at, recurrence, spread
from validation.study import Cell, Table, table
from validation.study.drawing import WIDTH, Drawing, canvas, pen

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
