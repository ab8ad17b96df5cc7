"""Run time against error of every model at several settings."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

import slipwave as sw
from validation.chart import Chart, Panel, Scale, Trace
from validation.chart.looks import model_look, style_of
from validation.measure import memo
from validation.measure.costs import march_times
from validation.measure.cycle import Estimate, Orbit, estimate
from validation.report import (
    ROUNDING,
    WITNESS,
    Budget,
    Figure,
    StudyResult,
    Table,
    Verdict,
    Verdicts,
    claim,
    places,
    plain,
    power,
    table,
)
from validation.report.known import as_known, error_after, error_of

NAME = "cost-and-error"
QUESTION = "What does each answer cost?"
SCENES = ("paper",)
SECONDS = (10.0, 12.0)
TIMED = True

TRANSITS = 3000.0
_LOG10_R = -2.68
_ODES = ("kelvin-voigt", "block8", "block12", "modal:1", "modal:2", "modal:8")
_TOLERANCES = (1e-3, 1e-5, 1e-7, 1e-9, 1e-11)
_EXACT = 1e-13  # tolerance of the reference run of errors, and the smallest error that is drawn
_WAVE = "dg:7"
_MARCHES = ("exact", "explicit")
_LEAPFROG, _ELEMENTS = (16, 32, 64, 128, 256), (2, 3, 4, 6)
"""Cells per slab."""


class _SettingRun(NamedTuple):
    """A model with its numerical options: the last cycles of its run, relative errors of their period and drop, and quartiles of
    the run time in ms."""

    model: str
    options: dict[str, Any]
    cycle: Orbit
    error: float
    drop_error: float
    times: list[float]

    @property
    def march(self) -> tuple[float | None, str | None]:
        """Courant number and kind of the march of a full wave."""
        return self.options.get("cfl"), self.options.get("time")

    @property
    def words(self) -> str:
        """The options as text."""
        if "tol" in self.options:
            return f"tolerance 10^{{{math.log10(self.options['tol']):.2g}}}"
        words = {"cells": "{} cells", "cfl": "CFL {:g}", "time": "{} in time"}
        return ", ".join(words[name].format(value) for name, value in self.options.items())


def run(budget: Budget) -> StudyResult:
    """Run and time every model at a ladder of settings."""
    exact = memo.settled("delay", sw.read("paper"), _EXACT, 1e-10).orbit
    leapfrog, elements = budget.plan(_LEAPFROG[:-1], _LEAPFROG), budget.plan(_ELEMENTS[::2], _ELEMENTS)  # cells per slab
    settings: list[tuple[str, dict[str, Any]]] = [("delay", {"tol": tolerance}) for tolerance in _TOLERANCES]
    settings += [("fd", {"cells": n, "cfl": cfl}) for cfl in (1.0, 0.5) for n in leapfrog]
    settings += [(_WAVE, {"cells": n, "time": march}) for march in _MARCHES for n in elements]
    settings += [(model, {"tol": tolerance}) for model in _ODES for tolerance in _TOLERANCES]
    cycles = [_cycle_at(*setting) for setting in budget.each(settings, end=0.4)]
    points = [
        _SettingRun(*setting, cycle, _off(cycle.period, exact.period), _off(cycle.stress_drop, exact.stress_drop), times)
        for setting, cycle, times in zip(settings, cycles, _times_of(settings, budget.plan(quick=2, full=5)), strict=True)
    ]
    return StudyResult(
        answers={
            _answer(points): ("The finest setting", "The exact and the explicit"),
        },
        figures=(Figure("cost", _CAPTION, lambda: _work_precision(points), lead=True, timed=True),),
        tables=(_table(points),),
        verdicts=(*_finest_verdicts(points), _marches(points)),
    )


def _cycle_at(model: str, options: Mapping[str, Any]) -> Orbit:
    """The last cycles of a run."""
    return estimate(sw.run("paper", model, until=TRANSITS, **options).done.events)


def _times_of(settings: Sequence[tuple[str, dict[str, Any]]], rounds: int) -> list[list[float]]:
    """Quartiles of the processor time of a run (ms), all settings in turn; their code is loaded."""
    times = 1e3 * march_times(settings, sw.read("paper"), TRANSITS, rounds)
    return [each.tolist() for each in np.quantile(times, (0.25, 0.5, 0.75), axis=0).T]


def _off(ours: Estimate, exact: Estimate) -> float:
    return ours.value / exact.value - 1.0


def _answer(points: Sequence[_SettingRun]) -> str:
    """Run times and errors of T of the fastest and of the finest setting of some models. The least error chooses no setting of a
    reduction, where it is the model's own at every one."""

    def words(model: str) -> str:
        """Text of the two points."""
        chosen = [p for p in points if p.model == model and p.march[1] != "explicit"]
        both = min(chosen, key=lambda p: p.times[1]), _finest(chosen, model)
        return " to ".join(f"~{{{setting.times[1]:.0f} ms ({plain(abs(setting.error), '.0e')})}}" for setting in both)

    return (
        f"For {TRANSITS:.0f} transits (error of the period in brackets) the exact delay system takes {words('delay')}, the full "
        f"wave {words('fd')} by differences and {words(_WAVE)} by elements, the paper’s ODE {words('kelvin-voigt')}."
    )


def _table(points: Sequence[_SettingRun]) -> Table:
    rows = ((p.model, p.words, p.times[0], p.times[1], p.times[2], p.error, p.drop_error) for p in points)
    heading = "model | requested | lower quartile [ms] .1f | run [ms] .1f | upper quartile [ms] .1f"
    heading += " | error of T [relative] .1e | error of Δμ [relative] .1e"
    caption = (
        f"Processor time of a run of {TRANSITS:.0f} transits (march and event detection, code loaded; median and quartiles, all "
        "settings in turn) in the paper’s scene, and the errors reached of period and stress drop against the delay system’s."
    )
    return table("cost", caption, heading, rows)


def _finest_verdicts(points: Sequence[_SettingRun]) -> Verdicts:
    """One case for each model: reductions and the delay system against other programs, allowed the period's own error too; full
    waves against the delay system, allowed what the grid before leads to."""
    title = "The finest setting of each model has the known period"
    for model in ("delay", *_ODES):
        period = _finest(points, model).cycle.period
        yield from as_known(title, model, _LOG10_R, {"period": period.value}, error_of(period))
    for model in ("fd", _WAVE):
        fine = _finest(points, model)
        before = _finest([p for p in points if p is not fine and p.march == fine.march], model)
        left = error_after(model, before.error, before.options["cells"], fine.options["cells"])
        yield claim(title, WITNESS, abs(fine.error), left + ROUNDING, f"`{model}`: {fine.words}, against the delay system")


def _finest(points: Sequence[_SettingRun], model: str) -> _SettingRun:
    """The point of the smallest tolerance, or of the most cells."""
    mine = (point for point in points if point.model == model)
    return min(mine, key=lambda point: point.options.get("tol") or 1.0 / point.options["cells"])


def _marches(points: Sequence[_SettingRun]) -> Verdict:
    """The two marches of one grid, which share neither step nor friction solve."""
    runs = [[p for p in points if (p.model, p.march[1]) == (_WAVE, march)] for march in _MARCHES]
    pairs = list(zip(*runs, strict=True))
    apart = max(abs(exact.cycle.period.value / explicit.cycle.period.value - 1.0) for exact, explicit in pairs)
    allowed = 0.1 * min(max(abs(p.error) for p in some) for some in runs) + ROUNDING
    title = "The exact and the explicit march of one grid find the same period"
    return claim(title, WITNESS, apart, allowed, f"{_WAVE} on {len(pairs)} grids, to a tenth of their own error")


_CAPTION = (
    f"Run time against error of the period: each model at tolerances {power(_TOLERANCES[0])} to {power(_TOLERANCES[-1])}, or "
    f"{_LEAPFROG[0]} cells upwards with `fd` and {_ELEMENTS[0]} cells upwards with `{_WAVE}`, over {TRANSITS:.0f} transits at "
    f"log_{{10}} r = {places([_LOG10_R])}. Errors below {power(_EXACT)} are drawn there."
)


def _work_precision(points: Sequence[_SettingRun]) -> Chart:
    lines: dict[tuple[str, float | None, str | None], list[_SettingRun]] = {}
    for point in points:
        lines.setdefault((point.model, *point.march), []).append(point)
    traces = []
    for (model, cfl, time), chosen in lines.items():
        dashes = "-" if model in ("delay", "fd", _WAVE) else style_of(model).dashes
        half = (cfl is not None and cfl < 1.0) or time == "explicit"
        look = model_look(model, dashes=dashes, marker=style_of(model).marker, width=1.0, hollow=half)
        name = model + (f", CFL {cfl:g}" if cfl else "") + (f", {time} in time" if time else "")
        traces.append(Trace(name, [setting.times[1] for setting in chosen], [abs(setting.error) for setting in chosen], look))
    axes = Scale("run time (ms)", "log"), Scale("relative error of the period", "log", floor=_EXACT)
    return Chart([Panel("", *axes, traces, grid=True)], 4.6, legend="outside right center")
