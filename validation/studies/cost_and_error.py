"""Run time against error of every model, and two races against plain programs."""

import math
from collections.abc import Iterator

import slipwave
from slipwave.observe.statistics import Estimate
from validation.chart import Chart, Look, Panel, Scale, Trace
from validation.compute.build import build
from validation.compute.looks import style_of
from validation.compute.settle import settle
from validation.references.lsoda import PlainRun, plain_kelvin_voigt
from validation.references.onset import onset_of
from validation.references.published import half_digit, reference, reference_orbit
from validation.study import ROUNDING, WITNESS, Budget, Figure, Omission, StudyResult, Table, Verdict, claim, table
from validation.study.known import as_known, error_after, error_of
from validation.study.text import places, plain, power, run_time
from validation.timing import Setting, TimedRun, time_final, time_run

NAME = "cost-and-error"
QUESTION = "What does each answer cost?"
SCENES = ("paper", "yardstick")
SECONDS = (12.0, 14.0)
TIMED = True

TRANSITS = 3000.0
_LOG10_R = -2.68
_ODES = ("kelvin-voigt", "block8", "block12", "modal:1", "modal:2", "modal:8")
_TOLERANCES = (1e-3, 1e-5, 1e-7, 1e-9, 1e-11)
_EXACT = 1e-13
"""Tolerance of the reference run of errors, tighter than every setting."""
_FLOOR = 1e-13
"""Smallest error shown in the figure."""
_RACE_ERROR = 1e-8
_RIVALS = (1e-9, 1e-10)  # tolerances of LSODA
_ELEMENTS = "dg:7"
_CELLS = {"fd": {True: (16, 32, 64, 128), False: (16, 32, 64, 128, 256)}, _ELEMENTS: {True: (2, 4), False: (2, 3, 4, 6)}}
"""Family -> quick report -> cells per slab."""
_MARCHES = ("exact", "explicit")


def run(budget: Budget) -> StudyResult:
    """Time the ladder of settings of every model, then race."""
    paper = slipwave.read("paper")
    exact = settle(build("delay", paper, tolerance=_EXACT), tolerance=1e-10).orbit.values()
    damped = math.log10(onset_of(paper.law, paper.upper.epsilon, paper.velocity).r_quasidynamic)
    repeats = 2 if budget.quick else 3
    settings = budget.each(_settings(budget.quick), end=0.5)
    points = [time_run(setting, paper, TRANSITS, exact, repeats) for setting in settings]
    rivals = [plain_kelvin_voigt(paper, TRANSITS, tolerance) for tolerance in _RIVALS]
    ours = [point for point in points if point.setting.model == "kelvin-voigt"]
    finest = {model: _period(_finest(points, model)) for model in ("delay", *_ODES)}
    return StudyResult(
        answer=_answer(points),
        figures=(Figure("cost", _CAPTION, lambda: _work_precision(points), lead=True, timed=True),),
        tables=(_table(points), _final_states(), _race_table(ours, rivals)),
        verdicts=(
            _right(points),
            _agreement(rivals),
            *_waves(points),
            as_known(finest, _LOG10_R),
        ),
        notes=(
            "Processor times on the machine named above, with compiled code loaded; the least of several runs. A run is "
            f"{TRANSITS:.0f} transits of march and event detection. The error of a reduced model does not fall below that of its "
            "equations, however tight the tolerance.",
        ),
        omissions=(
            Omission(
                "Quasi-static and quasi-dynamic models.",
                f"At log_{{10}} r = {places([_LOG10_R])} the first runs away and the second slides steadily, as it does up to "
                f"{places([damped], '.3f')}: there is no period to compare. The study `which-model` has its cost, "
                "and its errors beyond.",
                ("The quasi-static model runs away", "The quasi-dynamic model slides steadily up to its own onset"),
            ),
        ),
    )


def _settings(quick: bool) -> list[Setting]:
    settings = [Setting("delay", tolerance=tolerance) for tolerance in _TOLERANCES]
    settings += [Setting("fd", cells=n, cfl=cfl) for cfl in (1.0, 0.5) for n in _CELLS["fd"][quick]]
    settings += [Setting(_ELEMENTS, cells=n, time=march) for march in _MARCHES for n in _CELLS[_ELEMENTS][quick]]
    return settings + [Setting(model, tolerance=tolerance) for model in _ODES for tolerance in _TOLERANCES]


def _answer(points: list[TimedRun]) -> str:
    def words(point: TimedRun) -> str:
        """Text of run time and error of one point."""
        return run_time(f"{1e3 * point.seconds:.0f} ms ({plain(abs(point.period_error), '.0e')})")

    of = {name: [p for p in points if p.setting.model == name] for name in ("delay", "fd", "kelvin-voigt", "block8")}
    of["dg"] = [p for p in points if p.setting.time == "exact"]
    quick = {name: min(group, key=lambda p: p.seconds) for name, group in of.items()}
    best = {name: min(group, key=lambda p: abs(p.period_error)) for name, group in of.items()}
    return (
        f"For {TRANSITS:.0f} transits, with the error of the period in brackets, the exact delay system takes "
        f"{words(quick['delay'])} to {words(best['delay'])}, the full wave {words(quick['fd'])} to {words(best['fd'])} by "
        f"differences and {words(quick['dg'])} to {words(best['dg'])} by elements that are propagated exactly in time; the "
        f"fastest runs take {words(quick['kelvin-voigt'])} with the paper’s ODE and {words(quick['block8'])} with a block."
    )


def _table(points: list[TimedRun]) -> Table:
    rows = (
        (p.setting.model, p.setting.words, 1e3 * p.seconds, 1e6 * p.seconds / TRANSITS, p.period_error, p.drop_error)
        for p in points
    )
    heading = "model | setting | run [ms] .1f | a transit [μs] .2f | error of T [relative] .1e | error of Δμ [relative] .1e"
    cycle = reference_orbit("delay", _LOG10_R)["period"]
    caption = (
        f"Time of {TRANSITS:.0f} transits (some {round(TRANSITS / cycle)} cycles) and error of period T and stress drop Δμ "
        "against the delay system’s."
    )
    return table("cost", caption, heading, rows)


def _final_states() -> Table:
    scene = slipwave.read("yardstick")
    rows, every = [], [known for known in reference()["states"]["jump"] if known["log10_r"] == _LOG10_R]
    times = ", ".join(str(known["time"]) for known in every)
    for known in every:
        for tolerance in _TOLERANCES[1:]:
            seconds, psi = time_final(Setting("delay", tolerance=tolerance), scene, float(known["time"]))
            rows.append((f"ψ({known['time']})", tolerance, 1e3 * seconds, psi, abs(psi - known["psi"])))
    heading = "state | tolerance .0e | run [ms] .1f | value .12g | error [absolute] .0e"
    caption = (
        f"The delay system on the reference scene, a jump of ψ = ln φ by {scene.start.size:g}: time and error of the state after "
        f"{times} transits, against values on which three resolutions of another program agree to 10^{{-10}}."
    )
    return table("final-states", caption, heading, rows)


def _known() -> float:
    return reference_orbit("kelvin-voigt", _LOG10_R)["period"]


def _error(period: float) -> float:
    """Relative error of a period of the Kelvin-Voigt system."""
    return period / _known() - 1.0


def _race_table(ours: list[TimedRun], rivals: list[PlainRun]) -> Table:
    runs: list[tuple[str, str, TimedRun | PlainRun]] = [("slipwave", one.setting.words, one) for one in ours]
    runs += [("scipy LSODA", Setting("", one.tolerance).words, one) for one in rivals]
    rows = ((program, words, 1e3 * one.seconds, one.period, _error(one.period)) for program, words, one in runs)
    heading = "program | setting | run [ms] .1f | T [transits] .12g | error [relative] .0e"
    caption = (
        f"The Kelvin–Voigt system over {TRANSITS:.0f} transits: this package against `scipy.integrate.solve_ivp` (LSODA) with "
        f"the right-hand side in Python, both timed in this run. Errors of T are against {_known():.10g}, known from other "
        f"programs. T to {plain(_RACE_ERROR, '.0e')}: {_race_factor(ours, rivals)}."
    )
    return table("race", caption, heading, rows)


def _race_factor(ours: list[TimedRun], rivals: list[PlainRun]) -> str:
    """How many times faster this package is at T to `_RACE_ERROR`. It is reported, not judged: run times vary on a busy
    machine."""
    mine, theirs = ([one.seconds for one in some if abs(_error(one.period)) <= _RACE_ERROR] for some in (ours, rivals))
    if not mine or not theirs:
        return "not reached by both"
    return f"this package is {run_time(f'{min(theirs) / min(mine):.0f} times')} faster"


def _period(run: TimedRun) -> Estimate:
    return Estimate(run.period, run.spread)


def _agreement(rivals: list[PlainRun]) -> Verdict:
    """The rival at its smallest tolerance, by as much as ten times that puts it off."""
    best, next_best = sorted(rivals, key=lambda rival: rival.tolerance)[:2]
    title, shown = "A ten-line program of the paper’s ODE finds the same period", f"{best.period:.10g} for {_known():.10g}"
    remark = "scipy’s LSODA on system (41); shares no code with our models"
    return claim(title, WITNESS, _error(best.period), abs(next_best.period / best.period - 1.0), remark, shown)


def _waves(points: list[TimedRun]) -> Iterator[Verdict]:
    """The two marches of one grid, which share neither step nor friction solve, and the finest grid of each full wave."""
    runs = [[p for p in points if (p.setting.model, p.setting.time) == (_ELEMENTS, march)] for march in _MARCHES]
    apart = max(abs(exact.period / explicit.period - 1.0) for exact, explicit in zip(*runs, strict=True))
    of_grids = min(max(abs(p.period_error) for p in some) for some in runs)
    title = "The exact and the explicit march of one grid find the same period"
    remark = f"largest relative difference of the periods, {_ELEMENTS} on {len(runs[0])} grids, within their own error"
    yield claim(title, WITNESS, apart, of_grids + ROUNDING, remark)
    allowed = {model: _left_by(points, model) for model in _CELLS}
    off = {model: abs(_finest(points, model).period_error) for model in allowed}
    worst = max(off, key=lambda model: off[model] / allowed[model])
    title = "The finest grid of each full wave has the delay system’s period"
    yield claim(title, WITNESS, off[worst], allowed[worst], f"{', '.join(off)}; shown: `{worst}`")


def _finest(points: list[TimedRun], model: str) -> TimedRun:
    """The point of the smallest tolerance, or of the most cells."""
    mine = (point for point in points if point.setting.model == model)
    return min(mine, key=lambda point: point.setting.tolerance or 1.0 / (point.setting.cells or 1))


def _left_by(points: list[TimedRun], model: str) -> float:
    """What the grid before the finest leads to, and rounding."""
    fine = _finest(points, model).setting
    coarse = _finest([p for p in points if (p.setting.cfl, p.setting.time) == (fine.cfl, fine.time) and p.setting != fine], model)
    return error_after(model, coarse.period_error, coarse.setting.cells or 1, fine.cells or 1) + ROUNDING


def _right(points: list[TimedRun]) -> Verdict:
    """Our own run at the smallest tolerance, in the race's setting."""
    best = _finest(points, "kelvin-voigt")
    title = "The Kelvin–Voigt run of the race has the period of other programs"
    limit = half_digit(_known()) / _known() + error_of(_period(best))
    return claim(title, WITNESS, abs(_error(best.period)), limit, f"at {best.setting.words}")


_CELLS_FROM = " and ".join(f"{cells[True][0]} cells upwards with `{model}`" for model, cells in _CELLS.items())
_CAPTION = (
    "Run time against error of the period, every model at several settings (tolerances "
    f"{power(_TOLERANCES[0])} to {power(_TOLERANCES[-1])}, or {_CELLS_FROM}), one run of {TRANSITS:.0f} transits. Lower left is "
    f"better. Errors are against the delay system at tolerance {power(_EXACT)}; points below {power(_FLOOR)} are drawn there."
)


def _work_precision(points: list[TimedRun]) -> Chart:
    lines: dict[tuple[str, float | None, str | None], list[TimedRun]] = {}
    for point in points:
        lines.setdefault((point.setting.model, point.setting.cfl, point.setting.time), []).append(point)
    series = []
    for (model, cfl, time), chosen in lines.items():
        style = style_of(model)
        if model == _ELEMENTS:  # its own plot style is as black and round as the delay system's
            style = style._replace(color="#a6761d", marker="P")
        half = (cfl is not None and cfl < 1.0) or time == "explicit"
        dashes = "-" if model in ("delay", "fd", _ELEMENTS) else style.dashes
        look = Look(style.color, dashes, style.marker, 1.0, hollow=half)
        name = style.label + (f", CFL {cfl:g}" if cfl else "") + (f", {time} in time" if time else "")
        errors = [abs(point.period_error) for point in chosen]
        series.append(Trace(name, [1e3 * point.seconds for point in chosen], errors, look))
    axes = Scale("run time (ms)", "log"), Scale("relative error of the period", "log", floor=_FLOOR)
    return Chart([Panel("", *axes, series, grid=True)], 4.6, legend="outside right center")
