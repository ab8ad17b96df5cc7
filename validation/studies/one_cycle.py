"""All models over one stick-slip cycle of the paper's reference scene, against the delay system."""

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

import slipwave
from validation.chart import PALE, Chart, Look, Panel, Scale, Trace, outline
from validation.chart.looks import model_line, style_of
from validation.measure import memo
from validation.measure.cycle import SYMBOLS, OneCycle, Orbit, one_cycle
from validation.references.published import half_digit, reference, reference_orbit
from validation.report import (
    WITNESS,
    Budget,
    Figure,
    Omission,
    StudyResult,
    Table,
    Verdicts,
    claim,
    minus,
    places,
    plain,
    stated,
    table,
)
from validation.report.known import as_known

NAME = "one-cycle"
QUESTION = "Do the simplified models run through the same cycle as the wave?"
SCENES = ("paper",)
SECONDS = (5.0, 5.0)

LOG10_R = -2.68
MODELS = ("delay", "fd", "modal:8", "modal:2", "modal:1", "kelvin-voigt", "block8", "block12")
_CELLS, _CFL = 128, 0.5
_TOLERANCE = 1e-10
_MARGIN = 4.0  # transits shown on either side of a cycle
_APART = 5e-4  # leapfrog with these cells
_OUTLINE = 0.1  # a model whose period is further off does not have the same cycle


def run(budget: Budget) -> StudyResult:
    """Compute every model's orbit, overlay one cycle of each, compare."""
    runs = {model: _run_model(model) for model in budget.each(MODELS)}
    orbits, cycles = {model: orbit for model, (orbit, _) in runs.items()}, {model: cycle for model, (_, cycle) in runs.items()}
    errors = {model: _off(orbits, model, "period") for model in orbits}
    return StudyResult(
        answers={
            _answer(errors): ("Orbits", "The full wave"),
        },
        figures=(
            Figure("overlay", _OVERLAY, lambda: _overlay(cycles), lead=True),
            Figure("ode-orbit", _ODE_ORBIT, lambda: _ode_orbit(cycles), paper="Fig 4", carries=("P3 ", "P5 "), zoom=True),
            Figure("panels", _PANELS_CAPTION, lambda: _panels(cycles), paper="Fig 5", carries=("P4 ", "P5 ", "P6 ")),
        ),
        tables=(_table(orbits),),
        verdicts=tuple(_cycle_verdicts(orbits)),
        notes=(reference()["how"],),
        numbers={
            f"delay {name}": stated(estimate.value, estimate.error, known, half_digit(known))
            for name, known in reference_orbit("delay", LOG10_R).items()
            for estimate in [getattr(orbits["delay"], name)]
        },
        omissions=(
            Omission(
                "Quasi-static and quasi-dynamic curves.",
                f"At log_{{10}} r = {places([LOG10_R])} the first model runs away, the second slides steadily.",
                ("The quasi-static model runs away", "Runs leave steady sliding"),
            ),
        ),
    )


def _off(orbits: Mapping[str, Orbit], model: str, quantity: str) -> float:
    """Relative error of `quantity` (a field of Orbit) against the delay system's."""
    return orbits[model].values()[quantity] / orbits["delay"].values()[quantity] - 1.0


def _answer(errors: Mapping[str, float]) -> str:
    shown = {model: minus(f"{100 * error:+.1f} %") for model, error in errors.items()}
    modes = [plain(abs(errors[name]), ".0e") for name in ("modal:1", "modal:2")]
    near = sum(abs(error) < _OUTLINE for error in errors.values())
    count = "All" if near == len(errors) else f"{near} of {len(errors)}"
    return (
        f"{count} models show the outline of one cycle: the period is off by "
        f"{shown['kelvin-voigt']} in the paper’s ODE, {shown['block8']} and {shown['block12']} in the blocks, "
        f"{modes[0]} with one exact mode of the slabs, {modes[1]} with two."
    )


_OVERLAY = (
    "One cycle of the paper’s scene, each model on its own orbit, aligned at its slip event. Left: stress μ (σ) and slip rate v "
    "(V*) over time (transits); right: a piece of the slow phase, where the echo of the event runs to and fro, and both ripple "
    f"with a period of one transit ({math.pi / math.sqrt(6.0):.2f} in the Kelvin–Voigt ODE, none in the blocks)."
)
_PANELS_CAPTION = "Stress μ over the same cycle, model by model, each over the delay system (grey)."
_ODE_ORBIT = (
    f"The stable orbit of the paper’s ODE at log_{{10}} r = {places([LOG10_R])}: stress μ with ripples that blocks do not have, "
    "elastic stress y, slip rate v, and the orbit in the planes of stress and state over slip rate."
)
_SHOWN = ("delay", "fd", "modal:1", "kelvin-voigt", "block12")
_PANELS = ("fd", "modal:2", "modal:1", "kelvin-voigt", "block8", "block12")
_ZOOM = (46.0, 53.0)
_SINCE = Scale("time since the slip event (transits)")
_STRESS, _RATE = Scale(r"stress $\mu$"), Scale("slip rate $v/V^*$", "log")


def _table(orbits: Mapping[str, Orbit]) -> Table:
    columns = ("T [transits] .9g", "Δμ [σ] .7f", "Δy [σ] .7f", "v_{max} [V*] .8g", "v_{min} [V*] .7g")
    rows = []
    for model, own in orbits.items():
        pairs = [(value, None if model == "delay" else _off(orbits, model, name)) for name, value in own.values().items()]
        own_error = max(float(estimate.error / abs(estimate.value)) for estimate in vars(own).values())
        rows.append((model, *(cell for pair in pairs for cell in pair), own_error))
    heading = " | ".join(["model", *(f"{column} | error [relative] .1e" for column in columns), "own error [relative] .0e"])
    caption = (
        f"The orbit at log_{{10}} r = {places([LOG10_R])}, by Newton’s method but for the leapfrog’s; Δy: drop of the elastic "
        "stress, y′ = ε(V − v). Errors are against the delay system. *Own error*: the largest of any quantity by the "
        f"difference of two meshes; for the leapfrog, run until it settles, half of what its last {memo.WINDOW} cycles differ by."
    )
    return table("orbits", caption, heading, rows, (0,))


def _run_model(model: str) -> tuple[Orbit, OneCycle]:
    """The orbit of `model` in the paper's scene, with errors of its computation, and one cycle of it: by Newton's method; the
    leapfrog, whose steps cannot be fractions of a period, is run until it has settled."""
    scene = slipwave.read("paper")
    if model == "fd":
        settled = memo.settled(model, scene, None, _TOLERANCE, cells=_CELLS, cfl=_CFL)
        return settled.orbit, one_cycle(settled, before=_MARGIN, after=_MARGIN, per_piece=2)
    own = memo.own_orbit(model, scene, _TOLERANCE)
    return own.orbit, memo.cycle_of(own.closed, _MARGIN, _MARGIN)


def _cycle_verdicts(orbits: Mapping[str, Orbit]) -> Verdicts:
    """Every orbit against other programs', the leapfrog's against the delay system's."""
    for model, orbit in orbits.items():
        yield from as_known("Orbits are those of other programs", model, LOG10_R, orbit.values())
    off = max(abs(_off(orbits, "fd", name)) for name in SYMBOLS)
    remark = f"leapfrog with {_CELLS} cells at CFL {_CFL}; it vanishes at the second order"
    yield claim("The full wave runs on the delay system’s orbit", WITNESS, off, _APART, remark)


def _overlay(cycles: Mapping[str, OneCycle]) -> Chart:
    """Stress and slip rate over the cycle, left, and in the slow phase, framed by the delay system's range there, right."""
    exact = cycles["delay"]
    slow = (exact.time >= _ZOOM[0]) & (exact.time <= _ZOOM[1])
    shade = Trace("", *outline(_ZOOM, [-np.inf] * 2, [np.inf] * 2), Look("#efeee8", kind="area"))
    shown = []
    for name, axis in (("stress", _STRESS), ("slip_rate", _RATE)):
        is_log, values = axis.kind == "log", getattr(exact, name)[slow]
        values = np.log(values) if is_log else values
        ends = values.min() - 0.6 * np.ptp(values), values.max() + 0.6 * np.ptp(values)  # 0.6 of the range free on both sides
        low, high = np.exp(ends) if is_log else ends
        lines = [(cycles[model].time, getattr(cycles[model], name), style_of(model).width) for model in _SHOWN]
        whole = [model_line(model, *xy, width=0.6 * width) for model, (*xy, width) in zip(_SHOWN, lines, strict=True)]
        close = [model_line(model, *xy) for model, (*xy, _) in zip(_SHOWN, lines, strict=True)]
        ticks = {value: f"{value:g}" for value in (4.0, 6.0, 10.0, 15.0, 20.0)} if name == "slip_rate" else None
        title = "slow phase, enlarged" if name == "stress" else ""
        shown += [Panel("", replace(_SINCE, limits=(-4.0, 82.0)), axis, [shade, *whole])]
        shown += [Panel(title, replace(_SINCE, limits=_ZOOM), replace(axis, limits=(low, high), ticks=ticks), close)]
    return Chart(shown, 5.2, 2, widths=(1.9, 1.0), legend="outside upper left", legend_columns=3, keys=shown[1].traces)


def _panels(cycles: Mapping[str, OneCycle]) -> Chart:
    """One panel per model, its stress over the delay system's."""
    exact = model_line("delay", cycles["delay"].time, cycles["delay"].stress, color=PALE, width=2.4)
    shown = []
    for model in _PANELS:
        own = model_line(model, cycles[model].time, cycles[model].stress, dashes="-", width=1.0)
        shown.append(Panel(own.name, _SINCE, Scale(r"$\mu$"), [exact, own]))
    return Chart(shown, 5.2, 2, share=("all", "all"))


def _ode_orbit(cycles: Mapping[str, OneCycle]) -> Chart:
    """The cycle of the paper's ODE over time, and in the planes of stress and state over slip rate."""
    cycle = cycles["kelvin-voigt"]
    time, rate, stress = cycle.time, cycle.slip_rate, cycle.stress
    elastic = Trace("$y$", time, cycle.elastic_stress, Look(dashes="--", width=1.0))
    across = Scale("$v/V^*$", "log")
    state = model_line("kelvin-voigt", rate, cycle.psi / math.log(10.0))
    shown = (
        Panel("", _SINCE, Scale(r"$\mu$, $y$"), [model_line("kelvin-voigt", time, stress, r"$\mu$"), elastic], "best"),
        Panel("", _SINCE, Scale("$v/V^*$", "log"), [model_line("kelvin-voigt", time, rate)]),
        Panel("", across, Scale(r"$\mu$"), [model_line("kelvin-voigt", rate, stress)]),
        Panel("", across, Scale(r"$\log_{10}\phi$"), [state]),
    )
    return Chart(shown, 5.6, layout=((0, 0), (1, 1), (2, 3)), heights=(1.0, 1.0, 1.2))
