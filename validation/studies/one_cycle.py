"""All models over one stick-slip cycle of the paper's reference scene, against the delay system."""

import math
from typing import NamedTuple

import scene
from scene.errors import NumericsError
from validation.closed_forms import Onset
from validation.models import build
from validation.orbits import Cycle, NoCycle, Orbit, Settled, one_cycle, settle
from validation.reference import reference, reference_orbit
from validation.report.text import plain
from validation.studies.one_cycle_figures import overlay, panels
from validation.study import Budget, Cell, Column, Evidence, Figure, Number, Omission, StudyResult, Table, Verdict, judge

NAME = "one-cycle"
QUESTION = "Do the simplified models run through the same cycle as the wave?"
SCENES = ("paper",)
SECONDS = (5.0, 6.0)

LOG10_R = -2.68
MODELS = ("delay", "fd", "modal:8", "modal:2", "modal:1", "kelvin-voigt", "block8", "block12")
_CELLS, _CFL = 128, 0.5
_QUANTITIES = {"period": "T", "stress_drop": "Δμ", "elastic_stress_drop": "Δy", "v_max": "v_{max}", "v_min": "v_{min}"}
_DIGITS = {"modal:1": 1e-6, "modal:2": 1e-6, "modal:8": 1e-6, "delay": 5e-7}


class Run(NamedTuple):
    """A model on its orbit and one cycle of it."""

    settled: Settled
    cycle: Cycle

    @property
    def orbit(self) -> Orbit:
        """Its figures."""
        return self.settled.orbit


def run(budget: Budget) -> StudyResult:
    """Settle every model, lay one cycle of each over the others, compare."""
    runs = {}
    for count, model in enumerate(MODELS):
        runs[model] = _run(model)
        budget.report((count + 1) / len(MODELS))
    cycles = {model: one.cycle for model, one in runs.items()}
    errors = {model: _error(one, runs["delay"], "period") for model, one in runs.items()}
    escape = _quasistatic()
    return StudyResult(
        answer=_answer(runs),
        figures=(
            Figure("overlay", _OVERLAY, lambda: overlay(cycles), lead=True),
            Figure("panels", _PANELS, lambda: panels(cycles, errors)),
        ),
        tables=(_drops(runs), _rates(runs), _beside_reference(runs)),
        verdicts=(*_against_reference(runs), _full_wave(runs), _runaway(escape), _steady()),
        notes=(reference()["how"],),
        numbers=_numbers(runs),
        omissions=(
            Omission("Quasi-static curve.", f"It has no limit cycle: {escape or 'the run did not end'}."),
            Omission("Quasi-dynamic curve.", "It slides steadily in this scene, see its verdict."),
        ),
    )


def _run(model: str) -> Run:
    what = scene.read("paper")
    solver = build(model, what, cells=_CELLS, cfl=_CFL) if model == "fd" else build(model, what, tolerance=1e-10)
    settled = settle(solver, tolerance=1e-10)
    return Run(settled, one_cycle(settled, before=4.0, after=4.0, per_piece=2 if model == "fd" else 12))


def _quasistatic() -> str:
    """What stops the quasi-static run; empty if nothing does."""
    try:
        settle(build("quasistatic", scene.read("paper")), most=2000.0)
    except NumericsError as error:
        return str(error).partition(" (scene")[0]
    except NoCycle:
        return ""
    return ""


def _slides_steadily(model: str) -> bool:
    try:
        settle(build(model, scene.read("paper")), most=12000.0)
    except NoCycle:
        return True
    return False


def _error(one: Run, exact: Run, quantity: str) -> float:
    return one.orbit.values()[quantity] / exact.orbit.values()[quantity] - 1.0


def _percent(one: Run, exact: Run, quantity: str = "period") -> str:
    return f"{100 * abs(_error(one, exact, quantity)):.1f} %"


def _answer(runs: dict[str, Run]) -> str:
    exact = runs["delay"]
    modes = [plain(abs(_error(runs[name], exact, "period")), ".0e") for name in ("modal:1", "modal:2")]
    return (
        f"All do in outline; the paper’s ODE falls {_percent(runs['kelvin-voigt'], exact)} short in period, the blocks "
        f"overshoot by {_percent(runs['block8'], exact)} and {_percent(runs['block12'], exact)}, one exact mode of the slabs "
        f"brings the error down to {modes[0]}, two to {modes[1]}."
    )


def _row(runs: dict[str, Run], model: str, quantities: tuple[str, ...]) -> list[Cell]:
    cells: list[Cell] = [model]
    for quantity in quantities:
        error = None if model == "delay" else _error(runs[model], runs["delay"], quantity)
        cells += [runs[model].orbit.values()[quantity], error]
    return cells


def _columns(quantities: tuple[tuple[str, str, str], ...]) -> tuple[Column, ...]:
    pairs = [(Column(_QUANTITIES[name], unit, spec), Column("error", "relative", ".1e")) for name, unit, spec in quantities]
    return (Column("model"), *(column for pair in pairs for column in pair))


def _drops(runs: dict[str, Run]) -> Table:
    names = ("period", "stress_drop", "elastic_stress_drop")
    columns = _columns(tuple(zip(names, ("transits", "σ", "σ"), (".9g", ".7f", ".7f"), strict=True)))
    caption = (
        "The settled orbit at log_{10} r = −2.68, V = 100. T: time from one slip event to the next on the transit clock; Δμ: "
        "largest less smallest stress; Δy: the same of the elastic stress, y′ = ε (V − v). Errors are relative, against the "
        "delay system."
    )
    return Table("drops", caption, columns, tuple(tuple(_row(runs, model, names)) for model in runs), (0,))


def _rates(runs: dict[str, Run]) -> Table:
    names = ("v_max", "v_min")
    columns = _columns(tuple(zip(names, ("V*", "V*"), (".8g", ".7g"), strict=True)))
    rows = []
    for model, one in runs.items():
        rows.append((*_row(runs, model, names), one.settled.cycles, one.settled.unrest, one.settled.solver.failures))
    caption = (
        "Largest and smallest slip rate v over the cycle, from the dense polynomials. *Unrest* is the largest relative spread "
        "of any of the five quantities over the last four cycles when the run was stopped: what is left of the transient."
    )
    more = (Column("cycles run", "", ".0f"), Column("unrest", "", ".0e"), Column("failed solves", "", ".0f"))
    return Table("rates", caption, (*columns, *more), tuple(rows), (0,))


def _beside_reference(runs: dict[str, Run]) -> Table:
    rows: list[tuple[Cell, ...]] = []
    for model, one in runs.items():
        for quantity, known in reference_orbit(model, LOG10_R).items():
            ours = one.orbit.values()[quantity]
            rows.append((model, _QUANTITIES[quantity], known, ours, ours / known - 1.0))
    columns = (
        Column("model"),
        Column("quantity"),
        Column("reference", "", ".10g"),
        Column("ours", "", ".10g"),
        Column("difference", "relative", ".0e"),
    )
    return Table(
        "reference", "Beside reference values of other programs (first note below); T in transits.", columns, tuple(rows)
    )


def _against_reference(runs: dict[str, Run]) -> list[Verdict]:
    verdicts = []
    for model, one in runs.items():
        known = reference_orbit(model, LOG10_R)
        if not known:
            continue
        worst = max(known, key=lambda name: abs(one.orbit.values()[name] / known[name] - 1.0))
        off = abs(one.orbit.values()[worst] / known[worst] - 1.0)
        limit = _DIGITS.get(model, 5e-8)
        verdicts.append(
            Verdict(
                "The exact orbit as computed by other programs" if model == "delay" else "Reduced models’ orbits likewise",
                Evidence.WITNESS,
                f"{known['period']:.10g}",
                f"{one.orbit.period.value:.10g}",
                judge(off < limit),
                f"`{model}`: period T; worst of {', '.join(map(_QUANTITIES.__getitem__, known))} off by {plain(off, '.0e')}",
            )
        )
    return verdicts


def _full_wave(runs: dict[str, Run]) -> Verdict:
    off = max(abs(_error(runs["fd"], runs["delay"], name)) for name in _QUANTITIES)
    return Verdict(
        "The full wave runs on the delay system’s orbit",
        Evidence.WITNESS,
        "0",
        f"{plain(off, '.0e')} at most",
        judge(off < 5e-4),
        f"leapfrog with {_CELLS} cells at CFL {_CFL}; how the difference vanishes is the next study’s question",
    )


def _runaway(escape: str) -> Verdict:
    ours = "runs away" if escape else "goes on"
    return Verdict("The quasi-static model runs away", Evidence.EXACT, "runs away", ours, judge(bool(escape)))


def _steady() -> Verdict:
    what = scene.read("paper")
    onset = Onset(what.law, what.upper.epsilon, what.velocity)
    steady = _slides_steadily("quasidynamic")
    return Verdict(
        "The quasi-dynamic model slides steadily where the wave sticks and slips",
        Evidence.EXACT,
        "steady" if what.transit < onset.r_quasidynamic else "stick-slip",
        "steady" if steady else "stick-slip",
        judge(steady == (what.transit < onset.r_quasidynamic)),
        "earthquake modellers’ radiation damping: its onset, r = ε/(b − a − εV/2) = "
        f"10^{{{math.log10(onset.r_quasidynamic):.3f}}}, lies above this scene’s r",
    )


def _numbers(runs: dict[str, Run]) -> dict[str, Number]:
    return {
        f"{model} {name}": Number(value, 1e-8 if model != "fd" else 1e-7)
        for model, one in runs.items()
        for name, value in one.orbit.values().items()
    }


_OVERLAY = (
    "One stick-slip cycle of the paper’s scene, every model on its own settled orbit and aligned at the start of its slip "
    "event (v rises through V). Left: the whole cycle; right: a piece of the slow phase, where the echo of the slip event runs "
    "to and fro and ripples stress and rate with period one transit (1.28 in the Kelvin–Voigt ODE, none in the blocks). μ: "
    "interface stress in units of σ; v: slip rate in units of V*; time in transits of the wave."
)
_PANELS = "Stress μ over the same cycle, model by model, each over the delay system (grey), with the error of its period."
