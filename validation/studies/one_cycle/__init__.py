"""All models over one stick-slip cycle of the paper's reference scene, against the delay system."""

import math

import slipwave
from slipwave.errors import NumericsError
from validation.measure.settle import SYMBOLS, NoCycle, settle
from validation.references.onset import onset_of
from validation.references.published import half_digit, reference, reference_orbit
from validation.registry.build import build
from validation.studies.one_cycle.runs import CELLS, CFL, COMPARED, IN_TURN, LOG10_R, CycleRun, at_r, error, run_model
from validation.studies.one_cycle.shown import beside_reference, cycles_over_r, drops, over_r_table, overlay, panels, rates
from validation.study import Budget, Evidence, Figure, Number, Omission, StudyResult, Verdict, judge
from validation.study.bounds import bounded
from validation.study.text import places as places_of
from validation.study.text import plain

NAME = "one-cycle"
QUESTION = "Do the simplified models run through the same cycle as the wave?"
SCENES = ("paper",)
SECONDS = (5.0, 6.0)

_PLACES = {True: (-2.699, -2.65), False: (-2.699, -2.65, -2.5, -2.3)}
"""By quick or full report: log10 r at which some models are shown, from the onset to the paper's largest."""

MODELS = ("delay", "fd", "modal:8", "modal:2", "modal:1", "kelvin-voigt", "block8", "block12")
_OUTLINE = 0.1  # a model whose period is further off does not have the same cycle
_OURS = 9e-11  # beyond the digits of the others; 6e-11 was measured
_WAVE = 5e-4  # leapfrog with these cells; 2e-4 was measured


def run(budget: Budget) -> StudyResult:
    """Find every model's orbit, lay one cycle of each over the others, compare; then as r grows."""
    runs = {model: run_model(model) for model in budget.each(MODELS, end=0.7)}
    found = {log10_r: {model: at_r(model, log10_r) for model in COMPARED} for log10_r in _PLACES[budget.quick]}
    places = {log10_r: {model: one for model, one in models.items() if one} for log10_r, models in found.items()}
    cycles = {model: own.cycle for model, own in runs.items()}
    errors = {model: error(own, runs["delay"], "period") for model, own in runs.items()}
    escape = _quasistatic()
    return StudyResult(
        answer=_answer(runs),
        figures=(
            Figure("overlay", _OVERLAY, lambda: overlay(cycles), lead=True),
            Figure("panels", _PANELS, lambda: panels(cycles, errors)),
            Figure("growth", _GROWTH, lambda: cycles_over_r(places)),
        ),
        tables=(drops(runs), rates(runs), beside_reference(runs), over_r_table(places)),
        verdicts=(*_against_reference(runs), _full_wave(runs), _runaway(escape), _steady()),
        notes=(reference()["how"],),
        numbers=_numbers(runs),
        omissions=(
            Omission("Quasi-static curve.", f"It has no limit cycle: {escape or 'the run did not end'}."),
            Omission(
                "Quasi-dynamic curve.",
                _DAMPED,
            ),
        ),
    )


def _quasistatic() -> str:
    """What stops the quasi-static run; empty if nothing does."""
    try:
        settle(build("quasistatic", slipwave.read("paper")), most=2000.0)
    except NumericsError as error:
        return str(error).partition(" (scene")[0]
    except NoCycle:
        return ""
    return ""


def _slides_steadily() -> bool:
    try:
        settle(build("quasidynamic", slipwave.read("paper")), most=12000.0)
    except NoCycle:
        return True
    return False


def _percent(own: CycleRun, exact: CycleRun) -> str:
    return f"{100 * error(own, exact, 'period'):+.1f} %".replace("-", "−")


def _answer(runs: dict[str, CycleRun]) -> str:
    exact = runs["delay"]
    modes = [plain(abs(error(runs[name], exact, "period")), ".0e") for name in ("modal:1", "modal:2")]
    outline = max(abs(error(own, exact, "period")) for own in runs.values()) < _OUTLINE
    return (
        f"{'In outline' if outline else 'No'}, with the period off by {_percent(runs['kelvin-voigt'], exact)} in the paper’s "
        f"ODE, by {_percent(runs['block8'], exact)} and {_percent(runs['block12'], exact)} in the blocks; by {modes[0]} with "
        f"one exact mode of the slabs, by {modes[1]} with two."
    )


def _against_reference(runs: dict[str, CycleRun]) -> list[Verdict]:
    known = {model: reference_orbit(model, LOG10_R) for model in runs}
    return [_beside(model, runs[model].orbit.values(), figures) for model, figures in known.items() if figures]


def _beside(model: str, ours: dict[str, float], known: dict[str, float]) -> Verdict:
    """Every value may differ by half of the last known digit and by the error of our own orbit."""
    off = {name: abs(ours[name] / value - 1.0) for name, value in known.items()}
    allowed = {name: half_digit(value) / abs(value) + _OURS for name, value in known.items()}
    worst = max(known, key=lambda name: off[name] / allowed[name])
    return bounded(
        "The exact orbit as computed by other programs"
        if model == "delay"
        else "Reduced models’ orbits as computed by other programs",
        Evidence.WITNESS,
        off[worst],
        allowed[worst],
        f"`{model}`: {', '.join(map(SYMBOLS.__getitem__, known))}; shown: {SYMBOLS[worst]}, the worst beside its digits",
        f"{ours[worst]:.10g}, off by {plain(off[worst], '.0e')}",
    )


def _full_wave(runs: dict[str, CycleRun]) -> Verdict:
    off = max(abs(error(runs["fd"], runs["delay"], name)) for name in SYMBOLS)
    claim = "The full wave runs on the delay system’s orbit"
    remark = f"leapfrog with {CELLS} cells at CFL {CFL}; the next study shows how the difference vanishes"
    return bounded(claim, Evidence.WITNESS, off, _WAVE, remark)


def _runaway(escape: str) -> Verdict:
    ours = "runs away" if escape else "goes on"
    return Verdict("The quasi-static model runs away", Evidence.EXACT, "runs away", ours, judge(bool(escape)))


def _steady() -> Verdict:
    scene = slipwave.read("paper")
    r_c = onset_of(scene.law, scene.upper.epsilon, scene.velocity).r_quasidynamic
    steady = _slides_steadily()
    return Verdict(
        "The quasi-dynamic model slides steadily where the wave sticks and slips",
        Evidence.EXACT,
        "steady" if scene.transit < r_c else "stick-slip",
        "steady" if steady else "stick-slip",
        judge(steady == (scene.transit < r_c)),
        "earthquake modellers’ radiation damping: its onset, r = ε/(b − a − εV/2) = "
        f"10^{{{math.log10(r_c):.3f}}}, lies above this scene’s r",
    )


def _numbers(runs: dict[str, CycleRun]) -> dict[str, Number]:
    return {
        f"{model} {name}": Number(value, 1e-8 if model != "fd" else 1e-7)
        for model, own in runs.items()
        for name, value in own.orbit.values().items()
    }


_OVERLAY = (
    "One stick-slip cycle of the paper’s scene, every model on its own orbit and aligned at its slip event (v has risen "
    "to half its largest value). Left: the whole cycle; right: a piece of the slow phase, where the echo of the slip event runs "
    "to and fro, so that stress and rate ripple with a period of one transit "
    f"({math.pi / math.sqrt(6.0):.2f} in the Kelvin–Voigt ODE, none in the blocks). "
    "μ: interface stress in units of σ; v: slip rate in units of V*; time in transits of the wave."
)
_DAMPED = (
    f"It slides steadily at log_{{10}} r = {places_of([LOG10_R])} (see its verdict); the last table shows it beyond its onset."
)
_PANELS = "Stress μ over the same cycle, model by model, each over the delay system (grey), with the error of its period."
_GROWTH = (
    "Elastic stress, above its least, over a cycle as r grows from the onset to the paper’s largest, aligned at the slip event: "
    f"the stable orbit or, where a model has none, {IN_TURN} cycles of a run in turn. Its height is the elastic drop Δy."
)
