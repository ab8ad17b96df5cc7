"""Slabs that differ: the delay network against every full-wave family, and the regime of each model over their ratios."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

import slipwave as sw
from reduced.stability.characteristic import characteristic
from reduced.stability.spectrum import unstable_count
from slipwave.observe import HistoryObserver
from slipwave.scene import Scene
from slipwave.solve import follow
from validation.chart import DASHED, ORANGE, PALE, Chart, Look, Panel, Scale, Trace
from validation.compute.build import build
from validation.compute.models import explicit_time, one_port_of
from validation.measure.cycle import OneCycle, cut, watch
from validation.measure.order_fit import WITHIN
from validation.results.result import Dataset
from validation.study import Budget, Figure, StudyAnswer, StudyResult, Table, stated, table
from validation.study.regimes import regime_areas
from validation.study.text import places, plain, power
from validation.study.verdict import ROUNDING, WITNESS, Verdict, claim, every, in_range
from validation.sweep.axes import axis_of, changed
from validation.sweep.difference import difference, model_regimes
from validation.sweep.map_figures import chart_of_sweep
from validation.sweep.sweep import plan_of, swept_here

NAME = "asymmetry"
QUESTION = "What does it change that the slabs differ?"
SCENES = ("unlike", "unlike-irrational", "paper")
SECONDS = (8.0, 28.0)

UNTIL = 600.0
TOLERANCE = 1e-11
"""Tolerance of the delay system."""
_WATCHED = 140.0  # transits before UNTIL that are kept for the picture
_BEFORE, _AFTER = 3.0, 2.0

_PAIRS = {"unlike": "2", "unlike-irrational": "√2"}
"""Scene -> its ratio of round trips; the ratio of impedances is 3 in both."""
_SECOND_ORDER = 4.0 * (1.0 - 2.0**-WITHIN)  # how far the leapfrog's ratio may lie from 4
_TITLES = {"unlike": "2", "unlike-irrational": r"$\sqrt{2}$"}
_GRIDS = {
    True: (("dg:7", 4, None), ("sbp:6", 64, None), ("fem:4", 8, None), ("fd", 96, 0.5), ("fd", 192, 0.5)),
    False: (("dg:7", 6, None), ("sbp:6", 96, None), ("fem:4", 12, None), ("fd", 192, 0.5), ("fd", 384, 0.5)),
}
"""Quick report -> models, cells per slab and Courant numbers."""

_MODELS = ("delay", "kelvin-voigt", "modal:2")
_AXES = ("ratio_epsilon", "ratio_r")
_RANGE = "0.7:1.4"
_LOG10_R, _LONGEST, _SWEPT = -2.67, 3000.0, 1e-6


@dataclass(frozen=True)
class PairRun:
    """A model's grid; psi at UNTIL, and period, drop and largest rate of the last complete cycle; that cycle with margins."""

    model: str
    cells: int | None
    figures: dict[str, float]
    cycle: OneCycle

    def differs(self, exact: "PairRun") -> dict[str, float]:
        """Difference in psi (absolute) and in the cycle's figures (relative)."""
        ours, theirs = self.figures, exact.figures
        return {name: ours[name] - theirs[name] if name == "psi" else ours[name] / theirs[name] - 1.0 for name in ours}


def run(budget: Budget) -> StudyResult:
    """March both scenes with every family; sweep the plane of ratios with some models."""
    runs: dict[str, list[PairRun]] = {}
    for name in budget.each(_PAIRS, end=0.6):
        runs[name] = [march_pair(sw.read(name), "delay")]
        runs[name] += [march_pair(sw.read(name), *grid) for grid in _GRIDS[budget.quick]]
    known = {name: error_of_delay(name, each[0].figures["psi"]) for name, each in runs.items()}
    budget.report(0.7)
    scene = sw.read("paper", {"run.until": _LONGEST, "slab.log10_r": _LOG10_R})
    data = swept_ratios(scene, 5 if budget.quick else 9)
    differences = difference(data, _MODELS[0])
    return StudyResult(
        answers=_answers(runs, data, differences.attrs["differences"]),
        figures=(
            Figure("cycles", _CAPTION, lambda: last_cycles(runs)),
            Figure("regimes", _REGIMES, lambda: chart_of_sweep(data, "verdict")),
            Figure("differences", _DIFFERENCES, lambda: chart_of_sweep(differences, "other_regime")),
        ),
        tables=(_table(runs), _errors(differences.attrs["differences"])),
        verdicts=(*_agreements(runs, known), *_leapfrog(runs), _as_counted(scene, data)),
        numbers={f"{name}: ψ({UNTIL:.0f})": stated(runs[name][0].figures["psi"], error) for name, error in known.items()}
        | regime_areas(differences),
    )


def _answers(runs: Mapping[str, list[PairRun]], data: Dataset, rows: Any) -> tuple[StudyAnswer, ...]:
    off = max(abs(each[1].differs(each[0])["psi"]) for each in runs.values())
    worst = max(rows, key=lambda row: row["other_regime_percent"])
    across, up = np.meshgrid(*(np.log(data[name].values) for name in _AXES), indexing="ij")
    steady = model_regimes(_MODELS[0], data) == 0
    share = 100.0 * float((steady & (across > up)).sum()) / max(int(steady.sum()), 1)
    return (
        StudyAnswer(
            f"The exact system stays exact: after {UNTIL:.0f} transits ψ of the delay network and of discontinuous Galerkin "
            f"differ by {plain(off, '.0e')} at most.",
            ("Unlike slabs:",),
        ),
        StudyAnswer(
            f"Of the plane of ratios that both decide, {worst['model']} has another regime than the delay system in "
            f"{worst['other_regime_percent']:.0f} %; {share:.0f} % of the points that slide steadily have a stiffer lower slab.",
            ("Runs of unlike slabs",),
        ),
    )


def march_pair(scene: Scene, model: str, cells: int | None = None, cfl: float | None = None) -> PairRun:
    """Run `model` on `scene` to UNTIL."""
    if model == "delay":
        solver = build(model, scene, tolerance=TOLERANCE)
    else:
        solver = build(model, scene, cells=cells, cfl=cfl, time=explicit_time(model))
    observer = watch(solver, UNTIL - _WATCHED)
    history = HistoryObserver(scene.law, solver.nodes)
    final = follow(solver, UNTIL, [observer, history])
    events = observer.events()
    last = {name: float(getattr(events, name)[-1]) for name in ("period", "stress_drop", "v_max")}
    samples = history.samples(per_piece=6 if model == "delay" else 1)
    cycle = cut(scene.law, samples, float(events.time[-1]), last["period"], _BEFORE, _AFTER)
    return PairRun(model, cells, {"psi": final.psi, **last}, cycle)


def error_of_delay(name: str, psi: float) -> float:
    """Of the delay system's final state, a logarithm: how far a run at ten times the tolerance is, or rounding."""
    return max(ROUNDING, abs(follow(build("delay", sw.read(name), tolerance=10.0 * TOLERANCE), UNTIL).psi - psi))


def swept_ratios(scene: Scene, count: int) -> Dataset:
    """The sweep of the plane with every model."""
    axes = [axis_of(name, f"{_RANGE}:{count}:log") for name in _AXES]
    return swept_here(plan_of(scene, axes, _MODELS, "verdict", tol=_SWEPT))


def growing_roots(scene: Scene, model: str, data: Dataset) -> Any:
    """The certified number of growing roots of steady sliding at each point of the plane."""
    first, second = (data[name].values for name in _AXES)
    scenes = ([changed(scene, dict(zip(_AXES, (x, y), strict=True))) for y in second] for x in first)
    return np.array([[unstable_count(characteristic(one, one_port_of(model))) for one in row] for row in scenes])


def _agreements(runs: Mapping[str, list[PairRun]], known: Mapping[str, float]) -> Iterator[Verdict]:
    title = f"Unlike slabs: ψ({UNTIL:.0f}) of the delay network and of each full-wave family of high order agree"
    for name, (exact, *others) in runs.items():
        for one in others:
            if one.model != "fd":
                remark = f"`{one.model}`, round trips {_PAIRS[name]} : 1"
                yield claim(title, WITNESS, one.differs(exact)["psi"], known[name], remark)


def _leapfrog(runs: Mapping[str, list[PairRun]]) -> Iterator[Verdict]:
    """Half the cells, four times the error."""
    title, ends = "Unlike slabs: leapfrog’s error falls with the square of the cell", (4.0 - _SECOND_ORDER, 4.0 + _SECOND_ORDER)
    for name, (exact, *others) in runs.items():
        coarse, fine = (abs(one.differs(exact)["psi"]) for one in others if one.model == "fd")
        remark = f"round trips {_PAIRS[name]} : 1: ratio of the errors of ψ({UNTIL:.0f}) at half and at all the cells"
        yield in_range(title, WITNESS, ends, [coarse / fine], remark, ".2f")


def _as_counted(scene: Scene, data: Dataset) -> Verdict:
    wrong, judged = 0, 0
    for model in _MODELS:
        found = model_regimes(model, data)
        steady = growing_roots(scene, model, data) == 0
        judged += int((found >= 0).sum())
        wrong += int(((found >= 0) & ((found == 0) != steady)).sum())
    title = "Runs of unlike slabs leave steady sliding where certified counts of roots say so"
    return every(title, WITNESS, judged - wrong, judged, "every model, every point with a verdict that lasts", "points")


def _table(runs: Mapping[str, list[PairRun]]) -> Table:
    rows = [
        (_PAIRS[name], one.model, one.cells, *(value if one is not each[0] else None for value in one.differs(each[0]).values()))
        for name, each in runs.items()
        for one in each[1:]
    ]
    symbols = {"ψ": "absolute", "T": "relative", "Δμ": "relative", "v_{max}": "relative"}
    heading = " | ".join(["ratio | model | cells [a slab] .0f", *(f"{symbol} [{unit}] .0e" for symbol, unit in symbols.items())])
    caption = (
        f"Differences from the delay system (tolerance {power(TOLERANCE)}) in the friction state ψ = ln φ after {UNTIL:.0f} "
        "transits of the upper slab from the smooth start, and in T, Δμ and v_{max} of the last complete cycle. Neither scene "
        "has settled. Lower slab: round trip 2 or √2 times the upper one’s, impedance 3 times."
    )
    return table("differences", caption, heading, rows)


def _errors(rows: Any) -> Table:
    heading = "model | both decide [%] .3g | other regime [%] .2g | largest error of T .1e | of the stress drop .1e"
    names = ("model", "compared_percent", "other_regime_percent", "period", "stress_drop")
    return table("errors", _ERRORS, heading, ([None if row[name] != row[name] else row[name] for name in names] for row in rows))


_CAPTION = (
    f"The last complete cycle before {UNTIL:.0f} transits of two unlike pairs: stress μ, slip rate v in units of V*. Line: delay "
    "system; dashes: discontinuous Galerkin, degree 7, at the same moments of its own run; t = 0 where v has risen to half its "
    "largest value; time in transits of the upper slab."
)
_PLANE = (
    f"Ratio of the slabs’ impedances and of their round trips (lower over upper slab) from 0.7 to 1.4, "
    f"log_{{10}} r = {places([_LOG10_R])} of the upper slab, V = 100 V*, runs of at most {_LONGEST:g} transits from a nudge"
)
_REGIMES = f"Verdicts on the motion of unlike slabs. {_PLANE}. “Too short”: too few cycles for a verdict."
_DIFFERENCES = "Where a model of unlike slabs has another regime than the delay system; white: one of both has no verdict."
_ERRORS = (
    "The plane of ratios: per cent of the area in which both a model and the delay system have a verdict; of that, per cent with "
    "another regime; and the largest relative errors where both motions are periodic."
)


def last_cycles(runs: Mapping[str, list[PairRun]]) -> Chart:
    """Columns: scenes; rows: stress and rate."""
    across, panels = Scale("time since the slip event (transits)"), []
    for name, up in (("stress", Scale(r"stress $\mu$")), ("slip_rate", Scale(r"slip rate $v/V^*$", "log"))):
        for pair, each in runs.items():
            exact, wave = (one.cycle for one in each[:2])
            traces = [
                Trace("delay system", exact.time, getattr(exact, name), Look(PALE, width=2.6)),
                Trace("full wave", wave.time, getattr(wave, name), Look(ORANGE, DASHED, width=1.0)),
            ]
            panels.append(Panel(f"round trips {_TITLES[pair]} : 1" if name == "stress" else "", across, up, traces))
    return Chart(panels, 4.8, len(runs), legend="outside upper left", legend_columns=2)
