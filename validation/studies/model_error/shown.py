"""The reductions' errors as a table and over r, and what is left out."""

from collections.abc import Mapping

from slipwave.observe.pieces import Array
from validation.studies.model_error.runs import MODELS, MOST, RESTLESS, SHOWN, Runs, error, orbit_of, states
from validation.study import Cell, Omission, Table, table
from validation.study.drawing import WIDTH, Drawing, canvas, pen, ruled
from validation.study.text import plain

_BEYOND = (-2.65, -2.6, -2.5)


def error_table(runs: Runs) -> Table:
    """Errors of period and drop, and the time of 1000 transits."""
    rows = []
    for model in ("delay", *MODELS, "fitted:4"):
        cells: list[Cell] = [model, None if model == "delay" else states(model)]
        for log10_r in SHOWN:
            orbit = runs[model][log10_r]
            cells += [None if model == "delay" else error(runs, model, log10_r, name) for name in ("period", "drop")]
            cells += [orbit.milliseconds if orbit else None]
        rows.append(cells)
    each = [f"T, {log10_r:.2f} [relative] .1e | Δμ [relative] .1e | run [ms] .0f".replace("-", "−") for log10_r in SHOWN]
    caption = (
        "Errors of period T and stress drop Δμ against the delay system at log_{10} r = −2.69, −2.68 and −2.66, and the time of "
        "1000 transits at tolerance 10^{-10}, march and event detection. States: ψ, elastic stress, rate if there is mass, two "
        "per mode; the delay system’s state is a function. A dash: no settled orbit."
    )
    return table("models", caption, " | ".join(["model | states .0f", *each]), rows, (0,))


def omissions(runs: Runs) -> tuple[Omission, ...]:
    """Models and points without an orbit to compare."""
    beyond = [log10_r for log10_r in _BEYOND if orbit_of("delay", log10_r) is None]
    listed = ", ".join(f"{log10_r:g}".replace("-", "−") for log10_r in beyond)
    lost = [
        f"`{model}` at {x:g}".replace("-", "−") for model in ("delay", *MODELS) for x, orbit in runs[model].items() if not orbit
    ]
    left_out = [
        Omission(
            f"r beyond log_{{10}} r = {SHOWN[-1]:g}.".replace("-", "−"),
            f"The delay system’s cycles keep changing by more than {plain(RESTLESS, '.0e')} after {MOST:.0f} transits at "
            f"{listed}: no period to compare.",
        )
    ]
    if not any(runs["quasidynamic"].values()):
        left_out.append(Omission("Quasi-dynamic model.", "It slides steadily at every r shown; its onset lies above."))
    left_out.append(Omission("Quasi-static model.", "It has no limit cycle."))
    if lost:
        left_out.append(Omission("Points where a run had not settled.", f"After {MOST:.0f} transits: {', '.join(lost)}."))
    return tuple(left_out)


def errors_over_r(curves: Mapping[str, tuple[Array, Array, Array]]) -> Drawing:
    """`curves`: model -> (log10 r, error of the period, error of the drop); NaN leaves a gap."""
    figure = canvas(WIDTH, 4.4)
    panels = figure.subplots(1, 2, sharey=True)
    for model, (log10_r, *errors) in curves.items():
        look = pen(model)
        for axes, sizes in zip(panels, errors, strict=True):
            axes.semilogy(
                log10_r, sizes, color=look.color, linestyle=look.dashes, marker=look.marker, linewidth=1.1, label=look.label
            )
    for axes, title in zip(panels, ("period $T$", r"stress drop $\Delta\mu$"), strict=True):
        axes.set(title=title, xlabel=r"$\log_{10} r$")
        ruled(axes)
    panels[0].set_ylabel("relative error")
    figure.legend(handles=panels[0].get_lines(), loc="outside upper left", ncols=4, handlelength=3.0)
    return figure
