"""Slabs that differ: what the ratio of round trips changes, and that of impedances with it, at one impedance and one stiffness
of the interface; where stick-slip ends; the exact solution against full waves and another program; which model may be used.

Impedance, stiffness and static slip weakening of the interface stay those of the paper's alike slabs; the ratios of impedances q
and of round trips p, lower over upper slab, vary.

    1/Z = 1/epsilon_1 + 1/epsilon_2,    1/k = r_1/epsilon_1 + r_2/epsilon_2        (per V*, per L)
    epsilon_1 = Z (1 + q)/q,  epsilon_2 = Z (1 + q),    r_1 = r (1 + q)/(q + p),  r_2 = p r_1

so that at p = 1 the interface cannot tell the pair from alike slabs of epsilon = 2 Z and r, and k = Z/r for all q and p. Times
are given in transits of these alike slabs, a clock that does not change.
"""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple, TypeAlias

import slipwave as sw
from validation.chart import DASHED, DOTTED, INK, Chart, Look, Panel, Scale, Trace
from validation.measure.in_words import command_words, motion_at, scene_of, state_at
from validation.measure.memo import critical_r
from validation.measure.on_record import MOTIONS, SPECIAL_POINTS, KnownPoint, first_point, on_record, special_points
from validation.measure.regimes import UNDECIDED, Regime
from validation.references import others
from validation.report import (
    ROUNDING,
    SELF,
    WITNESS,
    Answers,
    Budget,
    Figure,
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
from validation.report.compared import EXACT_MODEL, relative_costs
from validation.report.everywhere import first_good, first_in_words, motion_cells, recorded_table, repeated, summary
from validation.report.known import NO_OTHERS, OTHERS_AT, as_foreign, foreign_answer
from validation.report.model_table import ModelColumn

NAME = "asymmetry"
QUESTION = "What does it change that the slabs differ, and which model may be used for them?"
SCENES = ("unlike", "unlike-irrational", "layered", "paper")
FILES = (MOTIONS, SPECIAL_POINTS, *others.FILES)
SECONDS = (15.0, 25.0)

IMPEDANCE = 1.4e-5
"""Z, half of the paper's epsilon."""
ROUND_TRIPS = (1.0, math.sqrt(2.0), 2.0, 3.0, 5.0, 10.0)
IMPEDANCES = (1.0, 3.0, 10.0)
_NUDGE = 0.5


class _Pair(NamedTuple):
    """Slabs of two ratios, lower over upper, whose alike slabs have this log10 r."""

    impedances: float
    round_trips: float
    log10_r: float

    @property
    def clock(self) -> float:
        """A transit of the upper slab, in transits of the alike slabs."""
        return (1.0 + self.impedances) / (self.impedances + self.round_trips)

    @property
    def settings(self) -> str:
        """The words that give the scene in a command."""
        q, upper = self.impedances, 10.0**self.log10_r * self.clock
        keys = {
            "upper.epsilon": IMPEDANCE * (1.0 + q) / q,
            "lower.epsilon": IMPEDANCE * (1.0 + q),
            "upper.r": upper,
            "lower.r": upper * self.round_trips,
            "start.size": _NUDGE,
        }
        return command_words("paper", keys)

    @property
    def title(self) -> str:
        """Its numbers in a few words."""
        return minus(f"q = {self.impedances:g}, p = {self.round_trips:.4g}, log_{{10}} r = {self.log10_r:g}")


_Motions: TypeAlias = Mapping[_Pair, Regime]
_Ends: TypeAlias = Mapping[_Pair, tuple[float, float]]
"""log10 r of the alike slabs at the onset of stick-slip, and at the fold where its cycles end."""

LOG10_R = (-2.68, -2.6)
PAIRS = tuple(_Pair(q, p, log10_r) for log10_r in LOG10_R for q in IMPEDANCES for p in ROUND_TRIPS if p > 1.0 or q == 1.0)
"""Every pair once: at equal round trips the ratio of impedances changes nothing."""
FOLLOWED = tuple(pair for pair in PAIRS if pair.log10_r == LOG10_R[0])
"""Those whose first fold is on record."""
MODELS = (EXACT_MODEL, "modal:8", "modal:4", "modal:2", "kelvin-voigt", "block8", "block12", "quasidynamic")
UNTIL = 600.0
TOLERANCE = 1e-11
"""Tolerance of the delay system."""

_LADDER = ("modal:2", "modal:4", "modal:8")
_COSTED = _Pair(3.0, 2.0, -2.68)
_WITNESSED = {
    "unlike": "round trips 2 : 1",
    "unlike-irrational": "round trips √2 : 1",
    _Pair(10.0, 5.0, -2.68).settings: "round trips 5 : 1",
}


_AGAIN = ((EXACT_MODEL, _Pair(3.0, 5.0, -2.68)), ("modal:4", _Pair(3.0, 10.0, -2.68)), (EXACT_MODEL, _Pair(3.0, 2.0, -2.6)))
_MORE = (
    (EXACT_MODEL, _Pair(10.0, 10.0, -2.68)),
    ("modal:4", _Pair(1.0, 10.0, -2.68)),
    ("block8", _Pair(3.0, 3.0, -2.6)),
    ("kelvin-voigt", _Pair(10.0, 2.0, -2.6)),
    ("modal:8", _Pair(1.0, 5.0, -2.6)),
)
"""Motions on record that are computed again, and those that a full report adds."""
_SECOND = {"pair-2": _Pair(3.0, 2.0, -2.68), "pair-root2": _Pair(10.0, math.sqrt(2.0), -2.68)}
_TORN, _LEAKING = _Pair(10.0, 2.0, -2.68), 0.999
"""What docs/benchmark/pairs.csv has, by its names; the pair that has a torus behind leaking faces, and their R."""


def run(budget: Budget) -> StudyResult:
    """March three scenes with full waves; orbits of pairs of equal round trips; a few motions and folds on record again."""
    delay = {name: state_at(name, UNTIL, tol=TOLERANCE) for name in _WITNESSED}
    coarse = {name: state_at(name, UNTIL, tol=10.0 * TOLERANCE) for name in _WITNESSED}
    known = {name: max(ROUNDING, abs(coarse[name] - psi)) for name, psi in delay.items()}
    grids = budget.plan(quick=(("dg:7", 4), ("sbp:6", 64)), full=(("dg:7", 6), ("sbp:6", 96)))
    waves = {(name, of): state_at(name, UNTIL, of, cells=n, time="explicit") for name in _WITNESSED for of, n in grids}
    budget.report(0.4)
    alike, *two = map(_period_as_two, IMPEDANCES)
    exact = {pair: on_record(EXACT_MODEL, pair.settings) or Regime(UNDECIDED) for pair in PAIRS}
    ends = {pair: _end_of(pair) for pair in FOLLOWED}
    budget.report(0.6)
    timed = [model for model in MODELS if model != "quasidynamic"]
    costs = relative_costs(timed, {}, scene_of(_COSTED.settings), budget.plan(quick=3, full=5))
    compared = recorded_table(NAME, [_column(pair) for pair in PAIRS], MODELS, _COSTED.title, costs)
    again = [(model, _column(pair)) for model, pair in budget.plan(_AGAIN, _AGAIN + _MORE)]
    return StudyResult(
        answers=_answers(exact, ends, alike, first_in_words(compared, _LADDER, "at every p and q of the table")),
        figures=(
            Figure("periods", _PERIODS, lambda: _periods(exact)),
            Figure("ends", _ENDS, lambda: _ends_over_ratio(ends)),
        ),
        tables=(_motions(exact, ends), summary(compared, "over all pairs of the table of motions", _FITTED)),
        verdicts=(
            *_of_waves([alike, *two], delay, waves, known),
            first_good(compared, _LADDER, f"{_FIRST} has the exact regimes, and T and Δμ to 1 %"),
            repeated("Motions of pairs on record are found again", again, motion_at),
            *_of_points(exact, ends, two[-1]),
        ),
        numbers={f"{name}: ψ({UNTIL:.0f})": stated(delay[name], known[name]) for name in SCENES[:2]}
        | {
            f"T at q = {pair.impedances:g}, p = {pair.round_trips:.4g}": stated(
                period.value * pair.clock, max(period.error, 1e-9 * period.value) * pair.clock
            )
            for pair in FOLLOWED
            if exact[pair].words == "periodic"
            for period in [exact[pair].figures["T"]]
        },
        omissions=NO_OTHERS,
    )


_FIRST = "The first modal ladder that is good in every pair"
_FITTED = " `fitted:N` finds the modes of `modal:N` in these slabs."


def _column(pair: _Pair) -> ModelColumn:
    scene = scene_of(pair.settings)
    over_onset = scene.transit / critical_r(EXACT_MODEL, scene)
    return ModelColumn(pair.title, pair.log10_r, over_onset, f"log_{{10}} r = {places([pair.log10_r])}", pair.settings)


def _period_as_two(impedances: float) -> float:
    """Period of the orbit at equal round trips, of the two slabs as such: the upper one is written in halves, which hides that
    one slab is sufficient."""
    scene, halves = scene_of(_Pair(impedances, 1.0, LOG10_R[0]).settings), [{"fraction": 0.5, "impedance": 1.0}] * 2
    scene = sw.read(scene, {"upper.layers": halves}) if impedances > 1.0 else scene
    return float(sw.orbit(scene, EXACT_MODEL, tol=TOLERANCE).summary["period"])


def _end_of(pair: _Pair) -> tuple[float, float]:
    """log10 r of the alike slabs at the onset of stick-slip and at the fold where its cycles end."""
    shift = math.log10(pair.clock)
    (fold,) = special_points().get(pair.settings, (KnownPoint("LP", math.nan, math.nan),))
    return math.log10(critical_r(EXACT_MODEL, scene_of(pair.settings))) - shift, fold.log10_r - shift


def _answers(exact: _Motions, ends: _Ends, alike: float, of_models: str) -> Answers:
    near = {
        pair: motion.figures["T"].value * pair.clock
        for pair, motion in exact.items()
        if pair.log10_r == LOG10_R[0] and motion.figures
    }
    least = min(near, key=near.__getitem__)
    first = ends[FOLLOWED[0]]
    lower = max(first[0] - onset for onset, _ in ends.values())
    width = [onset - fold for onset, fold in ends.values()]
    return {
        (
            "With rigid faces and equal round trips the interface cannot tell slabs of any impedances from alike ones of "
            f"ε = 2 Z, 1/Z = 1/ε_{{1}} + 1/ε_{{2}}: T = {alike:.9f} at q = {places(IMPEDANCES[:-1])} and "
            f"{IMPEDANCES[-1]:g}. Where round trips differ, {of_models}"
        ): ("Slabs of equal round trips", _FIRST, "Motions of pairs"),
        (
            "What counts is the ratio p of round trips, and with it that of impedances, q: at one Z and one stiffness T falls "
            f"from {alike:.1f} to {near[least]:.1f} transits of the alike slabs at q = {least.impedances:g}, "
            f"p = {least.round_trips:g}, and log_{{10}} r = {places(LOG10_R[:1])}."
        ): ("Motions of pairs",),
        (
            f"Stick-slip begins at nearly the same r: the onset lies lower by at most {lower:.4f} in log_{{10}} r, and cycles "
            f"go on {min(width):.4f} to {max(width):.4f} below it."
        ): ("Folds on record",),
        **foreign_answer("full waves", "Unlike slabs: ψ", ("Orbits of pairs", "Onsets, folds")),
    }


def _of_waves(
    periods: Sequence[float],
    delay: Mapping[str, float],
    waves: Mapping[tuple[str, str], float],
    known: Mapping[str, float],
) -> Verdicts:
    """The network of delay lines against alike slabs (`periods` by IMPEDANCES, p = 1), full waves, another program."""
    title = "Slabs of equal round trips have the period of alike slabs, marched as two slabs"
    apart = max(abs(period / periods[0] - 1.0) for period in periods[1:])
    yield claim(title, WITNESS, apart, 1e-12, f"orbits by `{EXACT_MODEL}`, q = {places(IMPEDANCES[1:])}")
    off = {key: abs(psi - delay[key[0]]) for key, psi in waves.items()}
    name, model = max(off, key=lambda key: off[key] / known[key[0]])
    title = f"Unlike slabs: ψ({UNTIL:.0f}) of the delay network and of two full waves agree"
    yield claim(title, WITNESS, off[name, model], known[name], f"worst of {len(off)}: `{model}`, {_WITNESSED[name]}")
    title = f"Another program, {others.SEM2DPACK}, has the exact solution’s ψ in slabs that differ and in layers"
    if others.FILES:
        yield as_foreign(title, {name: {t: state_at(name, t, tol=1e-12) for t in OTHERS_AT} for name in SCENES[:3]})


def _of_points(exact: _Motions, ends: _Ends, period: float) -> Verdicts:
    """Folds on record again; the benchmark's second program on orbits and special points of pairs; `period` at equal round trips
    and the last of IMPEDANCES."""
    pairs = _Pair(3.0, 2.0, LOG10_R[0]), _Pair(10.0, math.sqrt(2.0), LOG10_R[0])
    apart = max(abs(first_point("LP", pair.settings).log10_r - math.log10(pair.clock) - ends[pair][1]) for pair in pairs)
    yield claim("Folds on record of pairs are found again", SELF, apart, ROUNDING, f"log_{{10}} r of {len(pairs)} pairs")
    if not others.FILES:
        return
    theirs, program = others.pairs(), "of pairs are those of a second program, of two delay lines"
    known = {"one-pair": period, "pair-2": exact[_SECOND["pair-2"]].figures["T"].value}
    apart = max(abs(ours / theirs[f"{name}.period"] - 1.0) for name, ours in known.items())
    yield claim(f"Orbits {program}", WITNESS, apart, ROUNDING, f"T, relative: q = {IMPEDANCES[-1]:g}, p = 1; q = 3, p = 2")
    face = {"kind": "reflection", "coefficient": _LEAKING}
    faces = {f"{slab}.face.{key}": value for slab in ("upper", "lower") for key, value in face.items()}
    torus = first_point("NS", command_words(_TORN.settings, faces)).log10_r
    off = [abs(torus - theirs[f"leaking-{_LEAKING:g}.torus.log10_r"])]
    for name, pair in _SECOND.items():
        for what, ours in zip(("onset", "fold"), ends[pair], strict=True):
            off.append(abs(ours + math.log10(pair.clock) - theirs[f"{name}.{what}.log10_r"]))
    where = "; ".join(f"q = {pair.impedances:g}, p = {pair.round_trips:.4g}" for pair in _SECOND.values())
    remark = f"log_{{10}} r: {where}; torus of q = {_TORN.impedances:g}, p = {_TORN.round_trips:g} behind R = {_LEAKING:g}"
    yield claim(f"Onsets, folds and torus points {program}", WITNESS, max(off), ROUNDING, remark)


def _motions(exact: _Motions, ends: _Ends) -> Table:
    rows = []
    for pair, (onset, fold) in ends.items():
        cells = [cell for log10_r in LOG10_R for cell in motion_cells(exact[pair._replace(log10_r=log10_r)], pair.clock)]
        rows.append([pair.impedances if pair.round_trips > 1.0 else "any", pair.round_trips, onset, fold, *cells])
    each = " | ".join(f"log_{{10}} r = {places([x])} | T [transits] | Δμ [σ]" for x in LOG10_R)
    return table("motions", _MOTIONS, f"q .3g | p .5g | onset, log_{{10}} r .6f | fold .6f | {each}", rows)


_CLOCK = "in transits of the alike slabs, a clock that does not change"
_HELD = f"Z = {plain(IMPEDANCE)} and the interface’s stiffness Z/r as in the paper’s scene"
_MOTIONS = (
    f"The exact motion over the ratios of impedances q and of round trips p, lower over upper slab, at {_HELD}: onset of "
    f"stick-slip and the fold below which it has no cycles, log_{{10}} r of the alike slabs; regimes, periods {_CLOCK}, and "
    "stress drops at two r, where motions do not repeat means with two standard errors."
)
_PERIODS = f"Period of the exact motion over the ratio of round trips, at {_HELD}, {_CLOCK}. Bars: two standard errors of means."
_ENDS = "Where stick-slip begins and ends over the ratio of round trips: onset (solid) and fold (dashed), log_{10} r."
_COLORS = (INK, "#0072b2", "#d55e00")
_RATIO = Scale("ratio of round trips $p$", "log", ticks={float(p): str(p) for p in (1, 2, 3, 5, 10)})


def _of(impedances: float, log10_r: float) -> list[_Pair]:
    """Pairs over the ratio of round trips."""
    return [_Pair(impedances if p > 1.0 else 1.0, p, log10_r) for p in ROUND_TRIPS]


def _periods(exact: _Motions) -> Chart:
    """T over p, one line for each q, at both r."""
    panels = []
    for log10_r in LOG10_R:
        traces = []
        for q, color, marker in zip(IMPEDANCES, _COLORS, "os^", strict=True):
            known = [(pair.clock, exact[pair].figures.get("T")) for pair in _of(q, log10_r)]
            values = [clock * period.value if period else math.nan for clock, period in known]
            bars = [2.0 * clock * period.error if period else 0.0 for clock, period in known]
            traces.append(Trace(f"$q = {q:g}$", ROUND_TRIPS, values, Look(color, DOTTED, marker=marker), y_error=bars))
        title = rf"$\log_{{10}} r = {minus(f'{log10_r:g}')}$"
        panels.append(Panel(title, _RATIO, Scale("$T$ (transits of alike slabs)"), traces, grid=True))
    return Chart(panels, 3.4, 2, legend="outside upper left", legend_columns=3)


def _ends_over_ratio(ends: _Ends) -> Chart:
    """Onset and fold over p."""
    traces = []
    for q, color, marker in zip(IMPEDANCES, _COLORS, "os^", strict=True):
        onset, fold = zip(*(ends[pair] for pair in _of(q, LOG10_R[0])), strict=True)
        traces.append(Trace(f"onset, $q = {q:g}$", ROUND_TRIPS, onset, Look(color, marker=marker)))
        traces.append(Trace(f"fold, $q = {q:g}$", ROUND_TRIPS, fold, Look(color, DASHED, marker=marker, hollow=True)))
    panel = Panel("", _RATIO, Scale(r"$\log_{10} r$ of alike slabs"), traces, grid=True)
    return Chart([panel], 3.4, width=5.6, legend="outside right center")
