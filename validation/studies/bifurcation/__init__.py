"""The bifurcation diagrams that the paper could not draw: orbits of the delay system and of the ODE, stable or not, over r; and
their first fold over V, how far it lies below the Hopf point, and that only the products εV and rV matter."""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np

import slipwave as sw
from validation.chart import DOTTED, ORANGE, Chart, Look, Panel, Scale, Trace
from validation.chart.looks import NAMES, model_line, model_look
from validation.measure.over_r import COMPARED, FAR, Branch, branch_of, scene_at, unaccounted
from validation.references.onset import onset_of
from validation.references.published import half_digit, reference
from validation.report import (
    EXACT,
    PAPER,
    PROGRAM,
    ROUNDING,
    WITNESS,
    Answers,
    Budget,
    Cell,
    Figure,
    Number,
    Omission,
    StudyResult,
    Table,
    Verdict,
    Verdicts,
    claim,
    holding,
    in_range,
    minus,
    plain,
    stated,
    table,
)
from validation.report.branch_drawing import branch_keys, branch_traces
from validation.report.known import JUST_BELOW
from validation.studies.bifurcation.doubling import (
    ODE,
    PAIRS,
    Bubble,
    Doubled,
    between_doublings,
    bubble,
    doubled,
    doubling_verdicts,
)

NAME = "bifurcation"
QUESTION = "How do the periodic orbits of the exact system and of the paper’s ODE depend on r, and where do they lose stability?"
SCENES = ("paper",)
SECONDS = (20.0, 60.0)

_WAVE, _CELLS, _TOLERANCE = "dg:7", 8, 1e-8
_WAVES_AT = (-2.69, -2.68, -2.67, -2.66)  # log10 r of its orbits
_PUBLISHED = {"first fold": "LP", "first period doubling": "PD", "first torus point": "NS"}
_WAVE_ORBITS = 1e-9
_BUBBLES = ["PD", "PD", "LP", "LP", "PD", "PD", "LP", "LP", "PD", "PD", "NS"]


def run(budget: Budget) -> StudyResult:
    """Follow the branches from their Hopf points; find the full wave's own orbits, the doubled orbits and the folds over V."""
    to_torus = not budget.quick  # the ODE's branch
    longest, highest = budget.plan(quick=(78.5, -2.579), full=(85.0, -2.3))
    ends = [("delay", -2.3, longest), (ODE, highest, FAR)]
    delay, ode = (branch_of(*end) for end in budget.each(ends, end=0.5))
    waves = {log10_r: _wave_orbit(delay, log10_r) for log10_r in budget.plan(_WAVES_AT[:2], _WAVES_AT)}
    pairs = budget.plan(quick=PAIRS[:1], full=PAIRS)
    orbits, bubbles = doubled(), [bubble(*pair) for pair in budget.each(pairs, end=0.8, begin=0.5)]
    models, points = budget.plan(quick=(["delay"], 12), full=(["delay", ODE], 24))
    folds = {model: _folds_over_drive(model, points) for model in models}
    branches = {"delay": delay, "kelvin-voigt": ode}
    return StudyResult(
        answers=_answers(delay, ode),
        figures=(
            Figure(
                "branches",
                _BRANCHES,
                lambda: _diagram([delay, ode], waves),
                paper="Fig 6",
                carries=("P8 ", "P9 ", "P11 ", "P14 "),
            ),
            Figure("planes", _PLANES, lambda: _orbits_in_planes(orbits, ode, bubbles), paper="Fig 7", carries=("P10 ",)),
        ),
        tables=tuple(map(_special_table, branches.values())),
        verdicts=(
            *published(branches.values()),
            index(branches.values()),
            *_same_orbits(waves),
            _mildly_subcritical(delay, ode),
            *_fold_verdicts(folds, _fold_at(folds["delay"][-1][1])),
            *(_bubbles_of(ode) if to_torus else ()),
            *doubling_verdicts(orbits, ode, bubbles),
            unlike(delay, ode),
        ),
        notes=(_HOW,),
        numbers=_numbers(branches.values(), orbits),
        omissions=() if to_torus else (_P9,),
    )


def _answers(delay: Branch, ode: Branch) -> Answers:
    torus, first, second = delay.of_kind("NS")[0], *ode.of_kind("PD")[:2]
    return {
        minus(
            "Both are born at a mildly subcritical Hopf point and become stable at a fold. From there on they differ: the "
            f"orbit of the exact system loses stability to a torus at log_{{10}} r = {torus.point.parameter:.7f} on a branch "
            f"that folds back and forth, that of the ODE by period doubling at {first.point.parameter:.7f}."
        ): ("Special points", "Along every branch", "The full wave’s own orbits", "P8 ", "Only the products", "P14 "),
        minus(
            f"From there to {second.point.parameter:.7f} the ODE’s simple orbit is unstable, and beside it lies a stable one "
            "of twice the period, born at one end and gone at the other."
        ): ("P9 ", "P10 ", "The orbit of T = 79.09", "A direct run settles on the doubled orbit"),
    }


def _numbers(branches: Iterable[Branch], orbits: Doubled) -> dict[str, Number]:
    numbers: dict[str, Number] = {}
    for branch in branches:
        numbers[f"{branch.model} HB"] = Number(branch.onset.parameter, 1e-11)
        for kind in ("LP", "PD", "NS"):
            for count, special in enumerate(branch.of_kind(kind), 1):
                numbers[f"{branch.model} {kind} {count}"] = stated(special.point.parameter, special.bracket)
    for name, orbit, within in (("", orbits.single, 1e-7), ("doubled ", orbits.double, 1e-6)):
        period = orbit.orbit.period
        numbers[f"{name}T"] = stated(period.value, period.error)
        numbers[f"{name}multiplier"] = Number(orbit.multipliers.values[0].real, within)
    return numbers


_HOW = (
    "Orbits are found by Newton’s method on the motion over one period, whether they are stable or not, and followed by "
    "pseudo-arclength from the Hopf point. Multipliers are computed anew at every point. Special points are bracketed where the "
    "number of unstable multipliers or the direction of the branch changes."
)
_P9 = Omission(
    "P9, period doublings and torus of the ODE.",
    "The quick report ends its branch after two doublings.",
    ("Special points are where other programs find them",),
)


def _special_table(branch: Branch) -> Table:
    onset, model = branch.onset, branch.model
    rows: list[tuple[Cell, ...]] = [
        ("Hopf point", onset.parameter, onset.period, "", f"{onset.unstable_below} → {onset.unstable_above}")
    ]
    for special in branch.special:
        width = plain(special.bracket, ".0e") if special.bracket > ROUNDING else f"below {plain(ROUNDING, '.0e')}"
        counts = f"{special.unstable_before} → {special.unstable_after}"
        rows.append((NAMES[special.kind], special.point.parameter, special.point.closed.cycle.period, width, counts))
    caption = (
        f"Special points of the branch of `{model}`, in order from the Hopf point. Bracket: width of the interval that holds the "
        "point; at a fold T is known to 10^{-6}, relative. Unstable: number of multipliers outside the unit circle before and "
        "after it; at the Hopf point growing roots below and above."
    )
    heading = "point | log_{10} r .10f | T [transits] .7f | bracket [log_{10} r] | unstable"
    return table(f"special-{model}", caption, heading, rows)


WaveOrbits: TypeAlias = Mapping[float, tuple[dict[str, float], dict[str, float]]]
"""log10 r -> figures of the full wave's orbit, and of the nearest orbit of the delay system's branch there, by period."""


def _wave_orbit(branch: Branch, log10_r: float) -> tuple[dict[str, float], dict[str, float]]:
    """The orbit that the full wave reaches from the scene's own start; `branch` is the delay system's, whose drops are computed
    anew on a finer mesh."""
    scene = scene_at(log10_r)
    wave = sw.orbit(scene, _WAVE, tol=_TOLERANCE, cells=_CELLS).summary
    nearest = min((closed.cycle.period for closed in branch.orbits_at(log10_r)), key=lambda period: abs(period - wave["period"]))
    return wave, sw.orbit(scene, "delay", tol=1e-10).summary | {"period": nearest}


def published(branches: Iterable[Branch]) -> Verdicts:
    """Verdicts: the Hopf points and special points against values of other programs."""
    for branch in branches:
        known = reference()["special"][branch.model]
        pairs = [(branch.onset.parameter, reference()["hopf"][branch.model]["log10_r"], 0.0)]
        for name, kind in _PUBLISHED.items():
            if name in known:
                pairs += [
                    (special.point.parameter, known[name]["log10_r"], special.bracket) for special in branch.of_kind(kind)[:1]
                ]
        errors = [(abs(ours - theirs), 2.0 * half_digit(theirs) + bracket) for ours, theirs, bracket in pairs]
        off, allowed = max(errors, key=lambda error: error[0] / error[1])
        others = "AUTO-07p" if branch.model == "kelvin-voigt" else "lifted shooting and DDE-BIFTOOL"
        remark = f"`{branch.model}`: log_{{10}} r of {len(pairs)} points, Hopf point included, against {others}"
        yield claim("Special points are where other programs find them", PROGRAM, off, allowed, remark)


def index(branches: Iterable[Branch]) -> Verdict:
    """Every change of the number of unstable multipliers is that of a special point."""
    counts = [(unaccounted(branch), len(branch.special)) for branch in branches]
    missed, events = map(sum, zip(*counts, strict=True))
    return holding(
        "Along every branch the number of unstable multipliers changes at special points alone, by 1 at a fold or a period "
        "doubling and by 2 at a torus point",
        EXACT,
        "0 points unaccounted for",
        f"{missed} points",
        missed == 0,
        f"{events} special points. Pairs of folds that a step passes whole change no count: these are excluded by short steps",
    ).with_margin(missed, 1.0)


def _same_orbits(waves: WaveOrbits) -> Verdicts:
    """The full wave's orbits against the delay system's."""
    title = f"The full wave’s own orbits, `{_WAVE}`, lie on the delay system’s branch"
    for log10_r, (wave, delay) in waves.items():
        apart = max(abs(wave[name] / delay[name] - 1.0) for name in COMPARED)
        remark = minus(f"log_{{10}} r = {log10_r:g}: largest relative difference of T, Δμ and Δy")
        yield claim(title, WITNESS, apart, _WAVE_ORBITS, remark)


def _mildly_subcritical(delay: Branch, ode: Branch) -> Verdict:
    """P8."""
    first = {branch.model: branch.special[0] for branch in (delay, ode)}
    turned = {
        branch.model: 1.0 - 10.0 ** (first[branch.model].point.parameter - branch.onset.parameter) for branch in (delay, ode)
    }
    kinds = {(special.kind, special.unstable_before, special.unstable_after) for special in first.values()}
    return holding(
        "P8 The Hopf point is very mildly subcritical; the branch becomes stable at a saddle-node",
        PAPER,
        f"a fold at most {100 * JUST_BELOW:g} % below r_{{c}}",
        ", ".join(f"{100 * share:.2f} % below r_{{c}} ({model})" for model, share in turned.items()),
        min(turned.values()) > 0.0 and max(turned.values()) < JUST_BELOW and kinds == {("LP", 1, 0)},
        "unstable orbits lead from the Hopf point back to the fold, where one multiplier passes 1 inwards",
    ).with_margin(max(turned.values()), JUST_BELOW)


def _bubbles_of(ode: Branch) -> Verdicts:
    """P9: special points of the ODE's branch up to its torus point, and where that is."""
    kinds = [special.kind for special in ode.special]
    until = kinds[kinds.index("PD") : kinds.index("NS") + 1] if "NS" in kinds else kinds
    paper, torus = reference()["paper"]["log10_r_torus"], ode.of_kind("NS")[0].point.parameter
    title = "P9 The ODE’s orbits lose stability in pairs of period doublings split by saddle-nodes, then at a torus point"
    yield holding(
        title,
        PAPER,
        " ".join(_BUBBLES),
        " ".join(until),
        until == _BUBBLES,
        "from the first period doubling on; LP is a saddle-node, NS the torus point",
    )
    larger = 100 * abs(10.0 ** (paper - torus) - 1.0)
    yield holding(
        "P9 The torus point of the ODE lies at r = 10^{-2.468}",
        PAPER,
        minus(f"log_{{10}} r = {paper} ± {half_digit(paper):g}"),
        minus(f"log_{{10}} r = {torus:.6f}"),
        abs(torus - paper) <= half_digit(paper),
        f"the paper’s r is {larger:.2f} % larger; AUTO-07p confirms ours",
    ).with_margin(abs(torus - paper), half_digit(paper))


def unlike(delay: Branch, ode: Branch) -> Verdict:
    """P14: the first loss of stability of the two systems' orbits, except folds."""
    lost = {
        branch.model: next(
            special for special in branch.special if special.kind != "LP" and special.unstable_before < special.unstable_after
        )
        for branch in (delay, ode)
    }
    words = {"PD": "period doubling", "NS": "torus"}
    first = (
        f"{model}: first a " + minus(f"{words[special.kind]} at {special.point.parameter:.4f}") for model, special in lost.items()
    )
    counts = [", ".join(str(len(branch.of_kind(kind))) for kind in ("LP", "PD", "NS")) for branch in (delay, ode)]
    return holding(
        "P14 The delay system has bifurcations similar to the ODE’s",
        PAPER,
        "similar",
        "; ".join(first),
        lost["delay"].kind == lost["kelvin-voigt"].kind,
        "Hopf point and first fold are alike, what follows is not. Folds, period doublings, torus points of the branches shown: "
        f"{counts[0]} in the delay system, {counts[1]} in the ODE",
    )


_LABELS = {"period": "$T$ (transits)", "stress_drop": r"$\Delta\mu$", "elastic_stress_drop": r"$\Delta y$"}
_OVER_R = r"$\log_{10} r$"
_NEAR = (-2.706, -2.62)
_BESIDE = 0.01  # of log10 r, around the pairs of period doublings
_LEGEND: dict[str, Any] = {"legend": "outside upper left"}


def _diagram(branches: Sequence[Branch], waves: WaveOrbits) -> Chart:
    """The paper's Fig 6: period and drops over log10 r, from the onset to log10 r = -2.62 and to the end."""
    panels, look = [], Look(ORANGE, "", "o", size=7.0, hollow=True)
    for name in COMPARED:
        traces = [trace for branch in branches for trace in branch_traces(branch, name)]
        orbits = Trace("full wave", [*waves], [wave[name] for wave, _ in waves.values()], look)
        panels.append(Panel("", Scale(_OVER_R, limits=_NEAR), Scale(_LABELS[name]), [*traces, orbits], grid=True))
        panels.append(Panel("", Scale(_OVER_R), Scale(_LABELS[name]), traces, grid=True))
    keys = [*(model_line(branch.model, [], [], dashes="-") for branch in branches), *branch_keys(NAMES), orbits]
    return Chart(panels, 8.2, 2, widths=(1.25, 1.0), keys=keys, legend_columns=4, **_LEGEND)


def _orbits_in_planes(doubled: Doubled, ode: Branch, bubbles: Iterable[Bubble]) -> Chart:
    """The paper's Fig 7: both orbits in two planes; below, T and half the doubled period over r."""
    double = model_look(ODE, color=ORANGE, dashes="-", width=0.9)
    looks = (
        ("doubled orbit, stable", doubled.double, double),
        ("T = 79.09, unstable", doubled.single, model_look(ODE, dashes=DOTTED)),
    )
    rows: tuple[list[Trace], ...] = ([], [], [])
    for name, orbit, look in looks:
        pieces, ten = orbit.closed.cycle.pieces, math.log(10.0)
        time = (pieces.time[:, None] + pieces.length[:, None] * orbit.closed.flow.nodes) / orbit.closed.cycle.period
        turn, rate, stress, state = [values.ravel() for values in (time, pieces.z / ten, pieces.mu, pieces.psi / ten)]
        for traces, (x, y) in zip(rows, ((turn, rate), (rate, stress), (rate, state)), strict=True):
            traces.append(Trace(name, x, y, look))
    pairs = between_doublings(ode)
    curves = [np.transpose(points) for *_, points in bubbles]
    halves = [Trace("half of doubled T", r, half, double) for r, half in curves]
    log_v, limits = r"$\log_{10} v$", (pairs[0][0].value - _BESIDE, pairs[-1][-1].value + _BESIDE)
    periods = [closed.period for pair in pairs for closed in pair]
    over_r = Scale("$T$, half of the doubled $T$", limits=(min(periods) - 0.2, max(periods) + 0.2))
    panels = (
        Panel("", Scale("time over the period of each orbit"), Scale(log_v), rows[0], grid=True),
        Panel("", Scale(log_v), Scale(r"$\mu$"), rows[1], grid=True),
        Panel("", Scale(log_v), Scale(r"$\log_{10}\phi$"), rows[2], grid=True),
        Panel("", Scale(_OVER_R, limits=limits), over_r, [*branch_traces(ode, "period"), *halves], grid=True),
    )
    keys = [*rows[0], *branch_keys(("PD",))]
    layout, heights = ((0, 0), (1, 2), (3, 3)), (0.8, 1.2, 1.0)
    return Chart(panels, 8.4, layout=layout, heights=heights, share=("", ""), keys=keys, legend_columns=2, **_LEGEND)


_BRANCHES = (
    "Period T, stress drop Δμ and elastic stress drop Δy of the periodic orbits over r, the paper’s Fig 6, near the onset (left) "
    "and as far as the branches were followed (right). Stable orbits are thick and solid, unstable ones thin and dotted. "
    "Circles: orbits of the full wave."
)
_PLANES = (
    "The ODE’s orbits at log_{10} r = −2.590007, the paper’s Fig 7: the unstable one of T = 79.09 transits (dotted) and the "
    "stable one of twice the period. Above: slip rate over time, each over its own period; middle: two planes; below: periods of "
    "the simple orbits over r and half the periods of the doubled ones."
)


Fold: TypeAlias = tuple[float, float]
"""log10 r and V of a fold."""
_OF_FOLDS = 1e-6
_LOW, _HIGH = -2.73, -2.3  # log10 r at V = 100 between which the fold is searched for
_ENDS = (50, 200)  # V towards which a curve is followed from V = 100


def _folds_over_drive(model: str, most: int) -> list[Fold]:
    """The first fold of `model` over V, from at most so many points on each side of V = 100."""
    over = f"log10_r={_LOW}:{_HIGH}"
    curves = [
        sw.curve("paper", of="LP", over=over, along=f"V=100:{end}", model=model, tol=_OF_FOLDS, most_points=most) for end in _ENDS
    ]
    return sorted(((point["log10_r"], point["V"]) for curve in curves for point in curve.points), key=lambda fold: fold[1])


def _fold_at(velocity: float) -> float:
    """log10 r of the delay system's first fold at this V, computed at V = 100 with epsilon and r larger by V/100."""
    scene = sw.read("paper", {"slab.epsilon": 2.8e-7 * velocity})
    larger = math.log10(velocity / 100.0)
    over = f"log10_r={_LOW + larger}:{_HIGH + larger}"
    branch = sw.branch(scene, model="delay", over=over, stop_at="LP", tol=_OF_FOLDS)
    return float(branch.special[-1]["log10_r"]) - larger


def _fold_verdicts(curves: Mapping[str, Sequence[Fold]], again: float) -> Verdicts:
    """`again`: the last fold of the delay system by `_fold_at`."""
    log10_r, velocity = curves["delay"][-1]
    title = "Only the products εV and rV matter: the fold at V is that at V = 100 with ε and r larger by V/100"
    yield claim(
        title, EXACT, log10_r, ROUNDING, f"log_{{10}} r of the delay system’s first fold at V = {velocity:.1f}", near=again
    )
    scene = sw.read("paper")
    for model, folds in curves.items():
        low, high = folds[0][1], folds[-1][1]
        below = [1.0 - 10.0**r / onset_of(scene.law, scene.upper.epsilon, v)[model] for r, v in folds]
        yield in_range(
            "P8 The Hopf point is very mildly subcritical, at other V (and so at other ε) too",
            PAPER,
            (0.0, JUST_BELOW),
            below,
            f"{model}: of r_{{c}}, how far below lie {len(folds)} folds at V from {low:.0f} to {high:.0f}; at fixed V that is ε "
            f"from {plain(2.8e-7 * low, '.2g')} to {plain(2.8e-7 * high, '.2g')}",
            ".2%",
        )
