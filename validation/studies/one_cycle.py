"""All models over one stick-slip cycle of the paper's reference scene, against the delay system."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

import slipwave
from reduced.orbit import PeriodicOrbit, periodic_orbit
from reduced.orbit.approach import approach
from reduced.orbit.periodic import relative_error
from reduced.stability import analyse
from slipwave.observe.pieces import Array
from slipwave.observe.statistics import Estimate, Orbit
from slipwave.scene import Scene
from validation.chart import PALE, Chart, Look, Panel, Scale, Trace, outline, with_gaps
from validation.compute.looks import model_line, style_of
from validation.compute.orbits import moving
from validation.compute.settle import WINDOW
from validation.measure.cycle import SYMBOLS, OneCycle, one_cycle
from validation.references.published import half_digit, reference, reference_orbit
from validation.study import Budget, Figure, Number, Omission, StudyResult, Table, memo, stated, table
from validation.study.known import OTHERS
from validation.study.over_r import begun_at, scene_at
from validation.study.text import minus, places, plain
from validation.study.verdict import WITNESS, Verdict, claim

NAME = "one-cycle"
QUESTION = "Do the simplified models run through the same cycle as the wave?"
SCENES = ("paper",)
SECONDS = (5.0, 6.0)

LOG10_R = -2.68
COMPARED = ("delay", "kelvin-voigt", "block12", "quasidynamic")
"""Models that are followed as r grows."""
IN_TURN = 6
"""Number of cycles of a run drawn where a model has no stable orbit."""

_CELLS, _CFL = 128, 0.5
_TOLERANCE = 1e-10
_MARGIN = 4.0  # transits shown on either side of a cycle
_UNTIL, _LONGEST = 10000.0, 130.0
_WAVE = 5e-4  # leapfrog with these cells


class CycleRun(NamedTuple):
    """A model's orbit with errors of its computation, and one cycle of it."""

    orbit: Orbit
    cycle: OneCycle

    def off(self, exact: "CycleRun", quantity: str) -> float:
        """Relative error of `quantity` (a field of Orbit)."""
        return self.orbit.values()[quantity] / exact.orbit.values()[quantity] - 1.0


class AtR(NamedTuple):
    """A model at one r: period and stress drop of its stable orbit with its cycle or, where it has none, their means over so many
    `cycles` of a run with standard errors, and some of these cycles."""

    period: Estimate
    drop: Estimate
    drawn: list[OneCycle]
    cycles: int = 0


_LOG10_R = {True: (-2.699, -2.65), False: (-2.699, -2.65, -2.5, -2.3)}
"""Quick report -> log10 r at which some models are shown, from the onset to the paper's largest."""

MODELS = ("delay", "fd", "modal:8", "modal:2", "modal:1", "kelvin-voigt", "block8", "block12")
_OUTLINE = 0.1  # a model whose period is further off does not have the same cycle


def run(budget: Budget) -> StudyResult:
    """Compute every model's orbit, overlay one cycle of each, compare; then as r grows."""
    runs = {model: run_model(model) for model in budget.each(MODELS, end=0.7)}
    found = {log10_r: {model: at_r(model, log10_r) for model in COMPARED} for log10_r in _LOG10_R[budget.quick]}
    grown = {log10_r: {model: one for model, one in models.items() if one} for log10_r, models in found.items()}
    cycles = {model: own.cycle for model, own in runs.items()}
    errors = {model: own.off(runs["delay"], "period") for model, own in runs.items()}
    return StudyResult(
        answer=_answer(runs),
        figures=(
            Figure("overlay", _OVERLAY, lambda: overlay(cycles), lead=True),
            Figure(
                "ode-orbit",
                _ODE_ORBIT,
                lambda: _ode_orbit(cycles["kelvin-voigt"]),
                paper="Fig 4",
                carries=("P3 ", "P5 "),
                zoom=True,
            ),
            Figure("panels", _PANELS_CAPTION, lambda: panels(cycles, errors), paper="Fig 5", carries=("P4 ", "P5 ", "P6 ")),
            Figure("growth", _GROWTH, lambda: _cycles_over_r(grown)),
        ),
        tables=(_orbits(runs), _reference_table(runs), _over_r_table(grown)),
        verdicts=tuple(cycle_verdicts(runs)),
        notes=(reference()["how"],),
        numbers=_numbers(runs),
        omissions=(
            Omission("Quasi-static curve.", "It has no limit cycle.", ("The quasi-static model runs away",)),
            Omission("Quasi-dynamic curve.", _DAMPED, ("The quasi-dynamic model slides steadily",)),
        ),
    )


def _percent(own: CycleRun, exact: CycleRun) -> str:
    return minus(f"{100 * own.off(exact, 'period'):+.1f} %")


def _answer(runs: dict[str, CycleRun]) -> str:
    exact = runs["delay"]
    modes = [plain(abs(runs[name].off(exact, "period")), ".0e") for name in ("modal:1", "modal:2")]
    outline = max(abs(own.off(exact, "period")) for own in runs.values()) < _OUTLINE
    return (
        f"{'In outline' if outline else 'No'}, with the period off by {_percent(runs['kelvin-voigt'], exact)} in the paper’s "
        f"ODE, by {_percent(runs['block8'], exact)} and {_percent(runs['block12'], exact)} in the blocks; by {modes[0]} with "
        f"one exact mode of the slabs, by {modes[1]} with two."
    )


def _numbers(runs: dict[str, CycleRun]) -> dict[str, Number]:
    return {
        f"{model} {name}": _number(model, name, getattr(own.orbit, name))
        for model, own in runs.items()
        for name in own.orbit.values()
    }


def _number(model: str, name: str, found: Estimate) -> Number:
    """A number with the values known from other programs; the leapfrog's run states the differences of its cycles, not its
    error."""
    known = reference_orbit(model, LOG10_R).get(name)
    digit = half_digit(known) if known else 0.0
    return Number(found.value, 1e-7) if model == "fd" else stated(found.value, found.error, known, digit)


_OVERLAY = (
    "One stick-slip cycle of the paper’s scene, every model on its own orbit and aligned at its slip event (v has risen to half "
    "its largest value). Left: the whole cycle; right: a piece of the slow phase, where the echo of the slip event runs to and "
    f"fro, so that stress and rate ripple with a period of one transit ({math.pi / math.sqrt(6.0):.2f} in the Kelvin–Voigt ODE, "
    "none in the blocks). μ: interface stress in units of σ; v: slip rate in units of V*; time in transits of the wave."
)
_DAMPED = f"It slides steadily at log_{{10}} r = {places([LOG10_R])}; the last table shows it beyond its onset."
_PANELS_CAPTION = "Stress μ over the same cycle, model by model, each over the delay system (grey), with the error of its period."
_ODE_ORBIT = (
    f"The stable orbit of the paper’s ODE at log_{{10}} r = {places([LOG10_R])}: interface stress μ with the ripples that blocks "
    "do not have, elastic stress y, slip rate v, and the orbit in the planes of stress and state over slip rate."
)
_GROWTH = (
    "Elastic stress, above its least, over a cycle as r grows from the onset to the paper’s largest, aligned at the slip event: "
    f"the stable orbit or, where a model has none, {IN_TURN} cycles of a run in turn. Its height is the elastic drop Δy."
)

_SHOWN = ("delay", "fd", "modal:1", "kelvin-voigt", "block12")
_PANELS = ("fd", "modal:2", "modal:1", "kelvin-voigt", "block8", "block12")
_ZOOM = (46.0, 53.0)
_SINCE = Scale("time since the slip event (transits)")
_STRESS, _RATE = Scale(r"stress $\mu$"), Scale("slip rate $v/V^*$", "log")


def _orbits(runs: dict[str, CycleRun]) -> Table:
    columns = ("T [transits] .9g", "Δμ [σ] .7f", "Δy [σ] .7f", "v_{max} [V*] .8g", "v_{min} [V*] .7g")
    rows = []
    for model, own in runs.items():
        pairs = [
            (value, None if model == "delay" else own.off(runs["delay"], name)) for name, value in own.orbit.values().items()
        ]
        rows.append((model, *(cell for pair in pairs for cell in pair), relative_error(own.orbit)))
    heading = " | ".join(["model", *(f"{column} | error [relative] .1e" for column in columns), "own error [relative] .0e"])
    caption = (
        f"The orbit at log_{{10}} r = {places([LOG10_R])}, by Newton’s method but for the leapfrog’s. T: time from one slip "
        "event to the next on the transit clock; Δμ: largest minus smallest stress; Δy: the same for the elastic stress, y′ = ε "
        "(V − v); largest and smallest slip rate v from the dense polynomials. Errors are against the delay system. *Own error*: "
        "the largest of any quantity by the difference of two meshes; for the leapfrog, which is run until it settles, half of "
        f"what its last {WINDOW} cycles differ by."
    )
    return table("orbits", caption, heading, rows, (0,))


def _reference_table(runs: dict[str, CycleRun]) -> Table:
    known = ((model, name, value) for model in runs for name, value in reference_orbit(model, LOG10_R).items())
    both = ((model, name, value, runs[model].orbit.values()[name]) for model, name, value in known)
    rows = ((model, SYMBOLS[name], value, ours, ours / value - 1.0) for model, name, value, ours in both)
    caption = "Comparison with values of other programs (first note below); T in transits."
    return table("reference", caption, "model | quantity | reference .10g | ours .10g | difference [relative] .0e", rows)


def overlay(cycles: Mapping[str, OneCycle]) -> Chart:
    """Stress and slip rate over the cycle, left, and in the slow phase, framed by the delay system's range there, right."""
    exact = cycles["delay"]
    slow = (exact.time >= _ZOOM[0]) & (exact.time <= _ZOOM[1])
    shade = Trace("", *outline(_ZOOM, [-np.inf] * 2, [np.inf] * 2), Look("#efeee8", kind="area"))
    shown = []
    for name, axis in (("stress", _STRESS), ("slip_rate", _RATE)):
        ends = _framed(getattr(exact, name)[slow], axis.kind)
        lines = [(cycles[model].time, getattr(cycles[model], name), style_of(model).width) for model in _SHOWN]
        whole = [model_line(model, *xy, width=0.6 * width) for model, (*xy, width) in zip(_SHOWN, lines, strict=True)]
        close = [model_line(model, *xy) for model, (*xy, _) in zip(_SHOWN, lines, strict=True)]
        ticks = {value: f"{value:g}" for value in (4.0, 6.0, 10.0, 15.0, 20.0)} if name == "slip_rate" else None
        title = "slow phase, enlarged" if name == "stress" else ""
        shown += [Panel("", replace(_SINCE, limits=(-4.0, 82.0)), axis, [shade, *whole])]
        shown += [Panel(title, replace(_SINCE, limits=_ZOOM), replace(axis, limits=ends, ticks=ticks), close)]
    return Chart(shown, 5.2, 2, widths=(1.9, 1.0), legend="outside upper left", legend_columns=3, keys=shown[1].traces)


def _framed(values: Array, scale: str) -> tuple[float, float]:
    """Limits that leave 0.6 of the range free on both sides."""
    values = np.log(values) if scale == "log" else values
    ends = values.min() - 0.6 * np.ptp(values), values.max() + 0.6 * np.ptp(values)
    low, high = np.exp(ends) if scale == "log" else ends
    return float(low), float(high)


def panels(cycles: Mapping[str, OneCycle], errors: Mapping[str, float]) -> Chart:
    """One panel per model, its stress over the delay system's; relative `errors` of the period next to its name."""
    exact = model_line("delay", cycles["delay"].time, cycles["delay"].stress, color=PALE, width=2.4)
    shown = []
    for model in _PANELS:
        own = model_line(model, cycles[model].time, cycles[model].stress, dashes="-", width=1.0)
        shown.append(Panel(f"{own.name}: {_signed(errors[model])}", _SINCE, Scale(r"$\mu$"), [exact, own]))
    return Chart(shown, 5.2, 2, share=("all", "all"))


def _ode_orbit(cycle: OneCycle) -> Chart:
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


def _signed(error: float) -> str:
    """A relative error in words: per cent down to 0.1 %, then a power of ten."""
    mantissa, _, exponent = f"{error:+.0e}".partition("e")
    return f"${100 * error:+.1f}$ %" if abs(error) >= 1e-3 else rf"${mantissa}\cdot 10^{{{int(exponent)}}}$"


def _over_r_table(found: Mapping[float, Mapping[str, AtR]]) -> Table:
    rows = [
        (log10_r, model, one.period.value, one.period.error, one.drop.value, one.drop.error, one.cycles or None)
        for log10_r, models in found.items()
        for model, one in models.items()
    ]
    heading = "log_{10} r .3f | model | T [transits] .6g | error .0e | Δμ [σ] .4f | error .0e | cycles .0f"
    caption = (
        "Period and stress drop as r grows: of the stable orbit, with the error of its computation; or, where none is found, "
        "means over so many cycles of a run, with standard errors that allow for the dependence of a cycle on those before it. A "
        "model that slides steadily at an r is left out there."
    )
    return table("growth", caption, heading, rows)


def _cycles_over_r(found: Mapping[float, Mapping[str, AtR]]) -> Chart:
    shown = []
    for log10_r, models in found.items():
        curves = []
        for model, one in models.items():
            width = style_of(model).width * (1.0 if one.cycles == 0 else 0.5)
            heights = ((cycle.time, cycle.elastic_stress - cycle.elastic_stress.min()) for cycle in one.drawn)
            curves.append(model_line(model, *with_gaps(heights), width=width))
        shown.append(Panel(rf"$\log_{{10}} r$ = {minus(f'{log10_r:g}')}", _SINCE, Scale("$y$ above its least"), curves))
    keys = [model_line(model, [], []) for model in COMPARED]
    height = 2.4 * ((len(found) + 1) // 2) + 0.6
    return Chart(shown, height, 2, share=("all", "all"), legend="outside upper left", legend_columns=3, keys=keys)


def run_model(model: str) -> CycleRun:
    """The orbit of `model` in the paper's scene: by Newton's method; the leapfrog, whose steps cannot be fractions of a period,
    is run until it has settled."""
    scene = slipwave.read("paper")
    if model == "fd":
        settled = memo.settled(model, scene, None, _TOLERANCE, cells=_CELLS, cfl=_CFL)
        return CycleRun(settled.orbit, one_cycle(settled, before=_MARGIN, after=_MARGIN, per_piece=2))
    found = memo.own_orbit(model, scene, _TOLERANCE)
    return CycleRun(found.orbit, memo.cycle_of(found.closed, _MARGIN, _MARGIN))


def at_r(model: str, log10_r: float) -> AtR | None:
    """The model's stable orbit, or a run if there is none; None if it returns to steady sliding."""
    scene = scene_at(log10_r)
    if analyse(scene, model).stable:
        return None
    found = _stable_orbit(model, begun_at(log10_r))
    if found is not None:
        return AtR(found.orbit.period, found.orbit.stress_drop, [memo.cycle_of(found.closed, 0.0, 0.0)])
    period, drop, cycles = memo.means(model, scene, _UNTIL)
    return AtR(period, drop, memo.cycles_in_turn(model, scene, IN_TURN, _LONGEST), cycles)


def _stable_orbit(model: str, scene: Scene) -> PeriodicOrbit | None:
    """The orbit on which a run settles; None if its cycles keep changing."""
    guess = approach(moving(model, scene), _TOLERANCE)
    return periodic_orbit(*guess[:3], _TOLERANCE) if guess.settled else None


def cycle_verdicts(runs: dict[str, CycleRun]) -> Iterator[Verdict]:
    """Every orbit against other programs' and the delay system's; the failure of the simplest models is judged in
    `which-model`."""
    known = {model: reference_orbit(model, LOG10_R) for model in runs}
    yield from (_as_computed(model, runs[model].orbit.values(), figures) for model, figures in known.items() if figures)
    if "fd" in runs:
        off = max(abs(runs["fd"].off(runs["delay"], name)) for name in SYMBOLS)
        remark = f"leapfrog with {_CELLS} cells at CFL {_CFL}; `leapfrog-convergence` shows how the difference vanishes"
        yield claim("The full wave runs on the delay system’s orbit", WITNESS, off, _WAVE, remark)


def _as_computed(model: str, ours: dict[str, float], known: dict[str, float]) -> Verdict:
    """Every value may differ by half of the last known digit and by what others may be off beyond it."""
    off = {name: abs(ours[name] / value - 1.0) for name, value in known.items()}
    allowed = {name: half_digit(value) / abs(value) + OTHERS for name, value in known.items()}
    worst = max(known, key=lambda name: off[name] / allowed[name])
    whose = "The exact orbit" if model == "delay" else "Reduced models’ orbits"
    remark = f"`{model}`: {', '.join(map(SYMBOLS.__getitem__, known))}; shown: {SYMBOLS[worst]}, the worst relative to its digits"
    shown = f"{ours[worst]:.10g}, off by {plain(off[worst], '.0e')}"
    return claim(f"{whose} as computed by other programs", WITNESS, off[worst], allowed[worst], remark, shown)
