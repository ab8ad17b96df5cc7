"""Slabs that differ: the exact delay system against every full-wave family, and what the difference costs."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

import slipwave
from slipwave.observe import HistoryObserver
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from slipwave.solve import follow
from validation.compute.build import build
from validation.compute.models import explicit_time
from validation.measure.cycle import OneCycle, cut, watch
from validation.measure.order_fit import WITHIN
from validation.study import Budget, Cell, Figure, Omission, StudyResult, Table, stated, table
from validation.study.drawing import Drawing, subplots
from validation.study.text import plain, power, run_time
from validation.study.verdict import ROUNDING, SELF, WITNESS, Outcome, Verdict, claim, holding, in_range
from validation.timing import UNLIKE_R, March, Setting, alike_and_unlike, in_turn, warm_up

NAME = "unlike-slabs"
QUESTION = "Do the exact delay system and the full wave agree for slabs that differ, and what does the difference cost?"
SCENES = ("unlike", "unlike-irrational", "paper")
SECONDS = (6.0, 16.0)
TIMED = True

UNTIL = 600.0
TOLERANCE = 1e-11
"""Tolerance of the delay system."""
_WATCHED = 140.0  # transits before UNTIL that are kept for the picture
_BEFORE, _AFTER = 3.0, 2.0

MODELS = {
    "delay": (600.0, Setting("delay", tolerance=1e-9)),
    "delay, loose": (600.0, Setting("delay", tolerance=1e-6)),
    "dg:7": (200.0, Setting("dg:7", cells=4, time="explicit")),
    "dg:7, finer": (60.0, Setting("dg:7", cells=8, time="explicit")),
    "fd": (200.0, Setting("fd", cells=128, cfl=0.5)),
}
"""Row -> transits timed, and the setting."""

Costs = dict[str, dict[str, float]]
"""model -> pair -> microseconds a transit."""


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


_PAIRS = {"unlike": "2", "unlike-irrational": "√2"}
"""Scene -> its ratio of round trips; the ratio of impedances is 3 in both."""
_SECOND_ORDER = 4.0 * (1.0 - 2.0**-WITHIN)  # how far the leapfrog's ratio may lie from 4
_CELLS_RATIO = 3.0
"""Cells of the 2 : 1 pair over those of one alike slab: the longer round trip takes twice as many of the same size."""
_LIMITS = {
    ("delay", "commensurate"): 3.0,
    ("delay", "irrational"): 10.0,
    **{(model, "commensurate"): 1.1 * _CELLS_RATIO for model in ("dg:7", "dg:7, finer", "fd")},
}
_TITLES = {"unlike": "round trips 2 : 1", "unlike-irrational": r"round trips $\sqrt{2}$ : 1"}
_GRIDS = {
    True: (("dg:7", 4, None), ("sbp:6", 64, None), ("fem:4", 8, None), ("fd", 96, 0.5), ("fd", 192, 0.5)),
    False: (("dg:7", 6, None), ("sbp:6", 96, None), ("fem:4", 12, None), ("fd", 192, 0.5), ("fd", 384, 0.5)),
}
"""Quick report -> models, cells per slab and Courant numbers."""
_HIGH = ("dg:7", "sbp:6", "fem:4")


def run(budget: Budget) -> StudyResult:
    """March both scenes with every family, then time alike against unlike slabs."""
    runs: dict[str, list[PairRun]] = {}
    for name in budget.each(_PAIRS, end=0.9):
        scene = slipwave.read(name)
        runs[name] = [march_pair(scene, "delay")]
        for model, cells, cfl in _GRIDS[budget.quick]:
            runs[name].append(march_pair(scene, model, cells, cfl))
    known = {name: error_of_delay(name, pair_runs[0].figures["psi"]) for name, pair_runs in runs.items()}
    timed = costs(repeats=5 if budget.quick else 9)
    shown = {name: (pair_runs[0].cycle, pair_runs[1].cycle) for name, pair_runs in runs.items()}
    return StudyResult(
        answer=_answer(runs, known, timed),
        figures=(Figure("cycles", _CAPTION, lambda: last_cycles(shown)),),
        tables=(_table(runs), _cost_table(timed)),
        verdicts=(*_agreements(runs, known), *_families(runs, known), *_leapfrog(runs), *cost_verdicts(timed)),
        notes=(
            f"Neither scene has settled at {UNTIL:.0f} transits. The last complete cycle is compared as it is, at the same time "
            "of every model’s run.",
            "The full wave marches two slabs where the alike pair needs one, and the longer slab of the commensurate pair has "
            "twice the cells: three times the work. Run times on a busy machine prove nothing, so a ratio that is not reached is "
            "a finding.",
        ),
        numbers={f"{name}: ψ({UNTIL:.0f})": stated(runs[name][0].figures["psi"], error) for name, error in known.items()},
        omissions=(Omission("Simplified models of unlike slabs.", "This study asks whether the two exact descriptions agree."),),
    )


def error_of_delay(name: str, psi: float) -> float:
    """Of the delay system's final state, a logarithm: how far a run at ten times the tolerance is, or rounding."""
    return max(ROUNDING, abs(follow(build("delay", slipwave.read(name), tolerance=10.0 * TOLERANCE), UNTIL).psi - psi))


def _answer(runs: dict[str, list[PairRun]], known: Mapping[str, float], timed: Costs) -> str:
    off, delay = {name: abs(pair_runs[1].differs(pair_runs[0])["psi"]) for name, pair_runs in runs.items()}, timed["delay"]
    agree, worst = all(off[name] < known[name] for name in off), max(off.values())
    return (
        f"{'They do' if agree else 'No'}: after {UNTIL:.0f} transits ψ of the delay network and of discontinuous "
        f"Galerkin differ by {plain(worst, '.0e')} at most. A transit of unlike slabs takes the delay system "
        f"{_times(delay['commensurate'] / delay['alike'])} as long as one of alike slabs, "
        f"{_times(delay['irrational'] / delay['alike'])} where echoes never coincide."
    )


def _times(ratio: float) -> str:
    return run_time(f"{ratio:.1f} times")


def _table(runs: dict[str, list[PairRun]]) -> Table:
    rows = []
    for name, pair_runs in runs.items():
        for pair_run in pair_runs:
            exact = pair_run is pair_runs[0]
            differences = [None if exact else value for value in pair_run.differs(pair_runs[0]).values()]
            rows.append((_PAIRS[name], pair_run.model, pair_run.cells, pair_run.figures["psi"], *differences))
    symbols = {"ψ": "absolute", "T": "relative", "Δμ": "relative", "v_{max}": "relative"}
    differences_in = [f"difference in {symbol} [{unit}] .0e" for symbol, unit in symbols.items()]
    heading = " | ".join([f"ratio | model | cells [a slab] .0f | ψ({UNTIL:.0f}) .12g", *differences_in])
    caption = (
        f"Friction state ψ = ln φ after {UNTIL:.0f} transits of the upper slab from the smooth start, and differences from the "
        f"delay system (tolerance {power(TOLERANCE)}) in ψ and in period T, stress drop Δμ and largest rate v_{{max}} of the "
        "last complete cycle. Lower slab: round trip 2 or √2 times the upper one’s, impedance 3 times."
    )
    return table("differences", caption, heading, rows, (i for i, row in enumerate(rows) if row[1] == "delay"))


def _agreements(runs: Mapping[str, list[PairRun]], known: Mapping[str, float]) -> Iterator[Verdict]:
    title = "Unlike slabs: delay network and discontinuous Galerkin agree"
    for name, (exact, wave, *_) in runs.items():
        yield claim(title, WITNESS, wave.differs(exact)["psi"], known[name], _where(name))


def _where(name: str) -> str:
    return f"ψ({UNTIL:.0f}), round trips {_PAIRS[name]} : 1"


def _families(runs: Mapping[str, list[PairRun]], known: Mapping[str, float]) -> Iterator[Verdict]:
    for name, pair_runs in runs.items():
        states = {one.model: one.figures["psi"] for one in pair_runs if one.model in _HIGH}
        off = max(states.values()) - min(states.values())
        remark = f"{', '.join(f'`{model}`' for model in _HIGH)}; {_where(name)}"
        yield claim("Unlike slabs: full-wave families agree", WITNESS, off, known[name], remark)


def _leapfrog(runs: Mapping[str, list[PairRun]]) -> Iterator[Verdict]:
    """Half the cells, four times the error."""
    ratios = []
    for exact, *others in runs.values():
        coarse, fine = (abs(one.differs(exact)["psi"]) for one in others if one.model == "fd")
        ratios.append(coarse / fine)
    where = (
        f"error of ψ({UNTIL:.0f}) at half and at all the cells, round trips {', '.join(f'{_PAIRS[name]} : 1' for name in runs)}"
    )
    title, ends = "Unlike slabs: leapfrog’s error falls with the square of the cell", (4.0 - _SECOND_ORDER, 4.0 + _SECOND_ORDER)
    yield in_range(title, WITNESS, ends, ratios, where, ".2f")


def _cost_table(found: Costs) -> Table:
    rows: list[tuple[Cell, ...]] = []
    for model, each in found.items():
        alike = each["alike"]
        others = [cell for name in ("commensurate", "irrational") for cell in (each[name], each[name] / alike)]
        rows.append((model.partition(",")[0], _words(model), alike, *others))
    heading = "model | setting | alike [μs] .1f | 2 : 1 [μs] .1f | ratio [of times] .2f | √2 : 1 [μs] .1f | ratio [of times] .2f"
    caption = (
        "Processor time of one transit of the upper slab, march and event detection, fastest of several alternating runs. r is "
        f"10^{{−2.68}} for the alike pair, {UNLIKE_R[0]:g} and {UNLIKE_R[1]:g} for the unlike ones, so that the slip events of "
        f"all three reach about the same rate (3300 to 3600 V* in {MODELS['delay'][0]:g} transits): faster events need smaller "
        "steps, alike slabs or not."
    )
    return table("cost", caption, heading, rows)


def _words(model: str) -> str:
    setting = MODELS[model][1]
    return f"{setting.cells} cells a slab" if setting.cells else setting.words


def cost_verdicts(found: Costs) -> Iterator[Verdict]:
    """Ratios against what is promised."""
    for (model, pair), limit in _LIMITS.items():
        name, expected, why = "delay system", f"{limit:g} times at most", ""
        if model != "delay":
            name, expected = "full wave", f"{_CELLS_RATIO:g} times, the ratio of the cells, within a tenth"
            why = "; two slabs are marched instead of one, and the longer one has twice the cells"
        title, ratio = f"Cost of unlike slabs over alike ones: {name}", found[model][pair] / found[model]["alike"]
        remark = f"`{model.partition(',')[0]}`, {_words(model)}, {pair} round trips{why}"
        verdict = holding(title, SELF, expected, _times(ratio), ratio <= limit, remark, Outcome.FINDING)
        yield verdict.with_margin(ratio, limit, "of times")


_CAPTION = (
    f"The last complete cycle before {UNTIL:.0f} transits of two unlike pairs: stress μ, slip rate v in units of V*. Line: delay "
    "system; circles: discontinuous Galerkin, degree 7, at the same moments of its own run; t = 0 where v has risen to half its "
    "largest value. The lower slab has three times the upper one’s impedance and twice (left) or √2 times (right) its round "
    "trip; time in transits of the upper slab."
)


def last_cycles(shown: Mapping[str, tuple[OneCycle, OneCycle]]) -> Drawing:
    """Columns: scenes; rows: stress and rate. Each entry holds (delay, full wave)."""
    figure, grid = subplots(4.8, 2, len(shown), "time since the slip event (transits)", sharex="col", sharey="row")
    for column, (pair, (exact, wave)) in zip(grid.T, shown.items(), strict=True):
        marked = _spread(wave.time, wave.slip_rate)
        look = {"color": "#d55e00", "markersize": 3.6, "markerfacecolor": "none", "label": "full wave"}
        for axes, name in zip(column, ("stress", "slip_rate"), strict=True):
            axes.plot(exact.time, getattr(exact, name), color="#111111", linewidth=1.2, label="delay system")
            axes.plot(wave.time[marked], getattr(wave, name)[marked], "o", **look)
        column[0].set_title(_TITLES[pair])
        column[1].set_yscale("log")
    grid[0, 0].set_ylabel(r"stress $\mu$")
    grid[1, 0].set_ylabel(r"slip rate $v/V^*$")
    figure.legend(handles=grid[0, 0].get_lines(), loc="outside upper left", ncols=2)
    return figure


def _spread(time: Array, rate: Array) -> Array:
    """Indices evenly spaced along the curve of ln v over time, about 110 of them."""
    length = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(time) / np.ptp(time), np.diff(np.log(rate)) / 12.0))])
    return np.unique(np.searchsorted(length, np.linspace(0.0, length[-1], 110)))


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


def costs(repeats: int) -> Costs:
    """Least of `repeats` runs of every model on every pair; the pairs alternate."""
    scene = alike_and_unlike()
    found: Costs = {}
    for row, (until, setting) in MODELS.items():
        runs = {name: March(setting, pair, until) for name, pair in scene.items()}
        for pair in scene.values():
            warm_up(setting, pair)
        rounds = in_turn(runs, repeats)
        found[row] = {name: 1e6 * min(times[name] for times in rounds) / until for name in scene}
    return found
