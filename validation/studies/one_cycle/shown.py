"""Every model's figures and errors as tables; the overlay that opens the report, and one small panel per model."""

from collections.abc import Mapping

import numpy as np

from reduced.orbit.periodic import relative_error
from validation.measure.cycle import Cycle
from validation.measure.settle import SYMBOLS, WINDOW
from validation.references.published import reference_orbit
from validation.studies.one_cycle.runs import COMPARED, LOG10_R, AtR, CycleRun, error
from validation.study import Cell, Table, table
from validation.study.drawing import WIDTH, Axes, Drawing, canvas, pen
from validation.study.text import places

_SHOWN = ("delay", "fd", "modal:1", "kelvin-voigt", "block12")
_PANELS = ("fd", "modal:2", "modal:1", "kelvin-voigt", "block8", "block12")
_ZOOM = (46.0, 53.0)


def _row(runs: dict[str, CycleRun], model: str, quantities: tuple[str, ...]) -> list[Cell]:
    cells: list[Cell] = [model]
    for quantity in quantities:
        off = None if model == "delay" else error(runs[model], runs["delay"], quantity)
        cells += [runs[model].orbit.values()[quantity], off]
    return cells


def drops(runs: dict[str, CycleRun]) -> Table:
    """Period and drops."""
    names = ("period", "stress_drop", "elastic_stress_drop")
    off = "error [relative] .1e"
    heading = f"model | T [transits] .9g | {off} | Δμ [σ] .7f | {off} | Δy [σ] .7f | {off}"
    caption = (
        f"The orbit at log_{{10}} r = {places([LOG10_R])}, by Newton’s method but for the leapfrog’s. T: time from one slip "
        "event to the next on the transit clock; Δμ: "
        "largest minus smallest stress; Δy: the same for the elastic stress, y′ = ε (V − v). Errors are relative, against the "
        "delay system."
    )
    return table("drops", caption, heading, (_row(runs, model, names) for model in runs), (0,))


def rates(runs: dict[str, CycleRun]) -> Table:
    """Extreme slip rates, and the computation's own error."""
    names = ("v_max", "v_min")
    heading = (
        "model | v_{max} [V*] .8g | error [relative] .1e | v_{min} [V*] .7g | error [relative] .1e | own error [relative] .0e"
    )
    rows = ((*_row(runs, model, names), relative_error(own.orbit)) for model, own in runs.items())
    caption = (
        "Largest and smallest slip rate v over the cycle, from the dense polynomials. *Own error*: the largest relative error of "
        "any of the five quantities by the difference of two meshes; for the leapfrog, which is run until it settles, half of "
        f"what its last {WINDOW} cycles differ by."
    )
    return table("rates", caption, heading, rows, (0,))


def beside_reference(runs: dict[str, CycleRun]) -> Table:
    """Ours beside values of other programs."""
    rows = []
    for model, own in runs.items():
        for quantity, known in reference_orbit(model, LOG10_R).items():
            ours = own.orbit.values()[quantity]
            rows.append((model, SYMBOLS[quantity], known, ours, ours / known - 1.0))
    caption = "Comparison with values of other programs (first note below); T in transits."
    return table("reference", caption, "model | quantity | reference .10g | ours .10g | difference [relative] .0e", rows)


def overlay(cycles: Mapping[str, Cycle]) -> Drawing:
    """Stress and slip rate over the cycle, left, and in the slow phase, right."""
    figure = canvas(WIDTH, 5.2)
    grid = figure.subplots(2, 2, sharex="col", gridspec_kw={"width_ratios": (1.9, 1.0)})
    for model in _SHOWN:
        cycle, style = cycles[model], pen(model)
        for row, values in zip(grid, (cycle.stress, cycle.slip_rate), strict=True):
            for axes, share in zip(row, (0.6, 1.0), strict=True):
                axes.plot(cycle.time, values, color=style.color, linestyle=style.dashes, linewidth=share * style.width)
    for axes in grid[1]:
        axes.set(yscale="log", xlabel="time since the slip event (transits)")
    grid[0, 0].set_ylabel(r"stress $\mu$")
    grid[1, 0].set_ylabel(r"slip rate $v/V^*$")
    for axes in grid[:, 0]:
        _mark(axes, _ZOOM)
        axes.set_xlim(-4.0, 82.0)
    _zoom(grid[:, 1], cycles["delay"])
    handles = grid[0, 1].get_lines()
    figure.legend(handles, [pen(model).label for model in _SHOWN], loc="outside upper left", ncols=3, handlelength=3.2)
    return figure


def _mark(axes: Axes, window: tuple[float, float]) -> None:
    """Shade the window that the right-hand panel shows."""
    axes.axvspan(*window, color="#efeee8", zorder=0, linewidth=0)


def _zoom(column: np.ndarray, exact: Cycle) -> None:
    """Frame the slow phase by the delay system's range there."""
    inside = (exact.time >= _ZOOM[0]) & (exact.time <= _ZOOM[1])
    stress, rate = exact.stress[inside], np.log(exact.slip_rate[inside])
    column[0].set_xlim(*_ZOOM)
    margin = 0.6 * np.ptp(stress)
    column[0].set_ylim(stress.min() - margin, stress.max() + margin)
    margin = 0.6 * np.ptp(rate)
    column[1].set_ylim(np.exp(rate.min() - margin), np.exp(rate.max() + margin))
    column[1].set_yticks([4, 6, 10, 15, 20], ["4", "6", "10", "15", "20"])
    column[1].minorticks_off()
    column[0].set_title("slow phase, enlarged")


def panels(cycles: Mapping[str, Cycle], errors: Mapping[str, float]) -> Drawing:
    """One panel per model, its stress over the delay system's; `errors` of the period, relative, beside its name."""
    exact = cycles["delay"]
    figure = canvas(WIDTH, 5.2)
    grid = figure.subplots((len(_PANELS) + 1) // 2, 2, sharex=True, sharey=True)
    for axes, model in zip(grid.flat, _PANELS, strict=True):
        cycle, style = cycles[model], pen(model)
        axes.plot(exact.time, exact.stress, color="#b5b5b0", linewidth=2.4)
        axes.plot(cycle.time, cycle.stress, color=style.color, linewidth=1.0)
        axes.set_title(f"{style.label}: {_signed(errors[model])}", fontsize=11)
    for axes in grid[-1]:
        axes.set_xlabel("time since the slip event (transits)")
    for axes in grid[:, 0]:
        axes.set_ylabel(r"$\mu$")
    return figure


def _signed(error: float) -> str:
    """A relative error in words: per cent down to 0.1 %, then a power of ten."""
    if abs(error) >= 1e-3:
        return f"${100 * error:+.1f}$ %"
    mantissa, _, exponent = f"{error:+.0e}".partition("e")
    return rf"${mantissa}\cdot 10^{{{int(exponent)}}}$"


def over_r_table(places: Mapping[float, Mapping[str, AtR]]) -> Table:
    """Period and stress drop of the models as r grows."""
    rows = [
        (log10_r, model, one.period.value, one.period.error, one.drop.value, one.drop.error, one.cycles or None)
        for log10_r, models in places.items()
        for model, one in models.items()
    ]
    heading = "log_{10} r .3f | model | T [transits] .6g | error .0e | Δμ [σ] .4f | error .0e | cycles .0f"
    caption = (
        "Period and stress drop as r grows: of the stable orbit, with the error of its computation; or, where none is found, "
        "means over so many cycles of a run, with standard errors that allow for the dependence of a cycle on those before it. A "
        "model that slides steadily at an r is left out there."
    )
    return table("growth", caption, heading, rows)


def cycles_over_r(places: Mapping[float, Mapping[str, AtR]]) -> Drawing:
    """One panel for each r: the elastic stress of the models over a cycle."""
    figure = canvas(WIDTH, 2.4 * ((len(places) + 1) // 2) + 0.6)
    grid = figure.subplots((len(places) + 1) // 2, 2, sharex=True, sharey=True, squeeze=False)
    for axes, (log10_r, models) in zip(grid.flat, places.items(), strict=True):
        for model, one in models.items():
            style, share = pen(model), 1.0 if one.cycles == 0 else 0.5
            for cycle in one.drawn:
                height = cycle.elastic_stress - cycle.elastic_stress.min()
                axes.plot(cycle.time, height, color=style.color, linestyle=style.dashes, linewidth=share * style.width)
        axes.set_title(rf"$\log_{{10}} r = {log10_r:g}$")
    for axes in grid[-1]:
        axes.set_xlabel("time since the slip event (transits)")
    for axes in grid[:, 0]:
        axes.set_ylabel(r"$y$ above its least")
    handles = [
        grid[0, 0].plot([], [], color=pen(model).color, linestyle=pen(model).dashes, linewidth=pen(model).width)[0]
        for model in COMPARED
    ]
    figure.legend(handles, [pen(model).label for model in COMPARED], loc="outside upper left", ncols=3, handlelength=3.2)
    return figure
