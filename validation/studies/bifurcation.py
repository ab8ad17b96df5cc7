"""The bifurcation diagrams that the paper could not draw: orbits of the delay system and of the ODE, stable or not, over r."""

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

from reduced.continuation.special import Special
from reduced.orbit.figures import figures_of
from validation.references.published import half_digit, reference
from validation.study import Budget, Cell, Figure, Number, Omission, StudyResult, Table, memo, stated, table
from validation.study.branch_drawing import NAMES, color_of, draw_branch, draw_special, special_keys
from validation.study.drawing import Drawing, key, line, ruled, subplots
from validation.study.known import JUST_BELOW
from validation.study.over_r import COMPARED, FAR, Branch, branch_of, scene_at, unaccounted
from validation.study.text import minus, plain
from validation.study.verdict import ASYMPTOTIC, EXACT, WITNESS, Verdict, claim, holding, of_paper

NAME = "bifurcation"
QUESTION = "How do the periodic orbits of the exact system and of the paper’s ODE depend on r, and where do they lose stability?"
SCENES = ("paper",)
SECONDS = (16.0, 87.0)

WAVE = "dg:7"

_CELLS, _TOLERANCE = 8, 1e-8
_PUBLISHED = {"first fold": "LP", "first period doubling": "PD", "first torus point": "NS"}
_WAVE_ORBITS = 1e-9
_BUBBLES = ["PD", "PD", "LP", "LP", "PD", "PD", "LP", "LP", "PD", "PD", "NS"]


class WaveOrbit(NamedTuple):
    """Figures of the full wave's orbit at one r, and of the nearest orbit of the delay system's branch there, by period."""

    log10_r: float
    wave: dict[str, float]
    delay: dict[str, float]

    @property
    def apart(self) -> float:
        """Largest relative difference of period and drops."""
        return max(abs(self.wave[name] / self.delay[name] - 1.0) for name in COMPARED)


_DOUBLINGS = (
    "kinds of the special points from the first period doubling on: PD period doubling, LP saddle-node, NS torus point. The "
    "paper calls the doublings connected, which is about the doubled orbits, not about this branch"
)

_OVERLAID = 1e-6
_ENDS: dict[bool, dict[str, tuple[float, float] | tuple[float, float, float]]] = {
    True: {"delay": (-2.3, 78.5), "kelvin-voigt": (-2.579, FAR)},
    False: {
        "delay": (-2.3, 85.0),
        "kelvin-voigt": (-2.3, FAR),
        "modal:1": (-2.3, 79.3),
        "modal:2": (-2.3, 78.4, _OVERLAID),
        "modal:4": (-2.3, 78.4, _OVERLAID),
        "modal:8": (-2.3, 78.4, _OVERLAID),
    },
}
"""Quick report -> model -> log10 r and the period (transits) at which its branch ends, and the tolerance if not the default."""

_WAVES = {True: (-2.69, -2.68), False: (-2.69, -2.68, -2.67, -2.66)}


def run(budget: Budget) -> StudyResult:
    """Follow the branches from their Hopf points; find the full wave's own orbits."""
    ends = _ENDS[budget.quick]
    branches = {model: branch_of(model, *ends[model]) for model in budget.each(ends, end=len(ends) / (len(ends) + 1))}
    waves = [wave_orbit(branches["delay"], log10_r) for log10_r in _WAVES[budget.quick]]
    return StudyResult(
        answer=_answer(branches),
        figures=(
            Figure(
                "branches",
                _CAPTION,
                lambda: diagram(branches.values(), waves),
                paper="Fig 6",
                carries=("P8 ", "P9 ", "P11 ", "P14 "),
            ),
        ),
        tables=_tables(branches, waves, budget.quick),
        verdicts=_verdicts(branches, waves, budget.quick),
        notes=(_HOW, *(() if budget.quick else (_FOLDS,))),
        numbers=_numbers(branches),
        omissions=(_P9,) if budget.quick else (),
    )


def _tables(branches: dict[str, Branch], waves: list[WaveOrbit], quick: bool) -> tuple[Table, ...]:
    special = [_special_table(branch) for branch in branches.values()]
    delay, *others = branches.values()
    return (*special, *(() if quick else (structure_table(delay, others),)), _wave_table(waves))


def _verdicts(branches: dict[str, Branch], waves: list[WaveOrbit], quick: bool) -> tuple[Verdict, ...]:
    delay, ode = branches["delay"], branches["kelvin-voigt"]
    always = (
        published(delay),
        published(ode),
        index(branches.values()),
        same_orbits(waves),
        mildly_subcritical(delay, ode),
    )
    modal = [branch for model, branch in branches.items() if model.startswith("modal")]
    return (
        *always,
        *(() if quick else (*bubbles(ode), modes_converge(delay, modal))),
        unlike(delay, ode),
    )


def _answer(branches: dict[str, Branch]) -> str:
    torus, doubling = branches["delay"].of_kind("NS")[0].point, branches["kelvin-voigt"].of_kind("PD")[0].point
    return (
        "Both are born at a mildly subcritical Hopf point and become stable at a fold. From there on they differ: the orbit of "
        f"the exact system loses stability to a torus at log_{{10}} r = {torus.parameter:.7f} on a branch that folds back "
        f"and forth, that of the ODE by period doubling at {doubling.parameter:.7f}."
    ).replace("-2.", "−2.")


def _numbers(branches: dict[str, Branch]) -> dict[str, Number]:
    numbers: dict[str, Number] = {}
    for model, branch in branches.items():
        numbers[f"{model} HB"] = Number(branch.onset.parameter, 1e-11)
        for kind in ("LP", "PD", "NS"):
            for count, one in enumerate(branch.of_kind(kind), 1):
                numbers[f"{model} {kind} {count}"] = stated(one.point.parameter, one.bracket)
                numbers[f"{model} {kind} {count} T"] = stated(one.point.closed.cycle.period, _error_of_period(one))
    return numbers


def _error_of_period(special: Special) -> float:
    """By the bracket in log10 r and the branch's slope; at a fold r changes with the square of T, relative."""
    if special.kind == "LP":
        return special.point.closed.cycle.period * math.sqrt(special.bracket)
    change_of_period, change_of_r = special.point.tangent[-2:]
    return float(abs(change_of_period / change_of_r)) * special.bracket


_CAPTION = (
    "Period T, stress drop Δμ and elastic stress drop Δy of the periodic orbits over r, the paper’s Fig 6, near the onset (left) "
    "and as far as the branches were followed (right). Stable orbits are thick and solid, unstable ones thin and dotted. "
    "Circles: orbits of the full wave."
)
_HOW = (
    "Orbits are found by Newton’s method on the motion over one period, whether they are stable or not, and followed by "
    "pseudo-arclength from the Hopf point. Multipliers are computed anew at every point. Special points are bracketed where the "
    "number of unstable multipliers or the direction of the branch changes."
)
_FOLDS = (
    "The branch of the delay system is cut where a new ripple has entered the cycle several times; it folds about once per "
    "transit of T, and pairs of folds go on. With one exact mode of the slabs (`modal:1`) the folds are there, and the torus "
    "points begin a ripple later; with two (`modal:2`) they begin where the delay system’s do; the paper’s ODE has other "
    "bifurcations altogether."
)
_P9 = Omission(
    "P9, period doublings and torus of the ODE.",
    "The quick report ends its branch after two doublings.",
    ("Special points of `kelvin-voigt`",),
)

_LABELS = {"period": "$T$ (transits)", "stress_drop": r"$\Delta\mu$", "elastic_stress_drop": r"$\Delta y$"}
_COUNTED = {"LP": 9, "NS": 2, "PD": 1}  # special points of each kind that are compared
_ROUNDING = 1e-11  # brackets (log10 r) below this are not shown
_LEFT = -2.706
_ZOOM = -2.62


def _special_table(branch: Branch) -> Table:
    onset, model = branch.onset, branch.model
    counts = f"{onset.unstable_below} → {onset.unstable_above}"
    rows: list[tuple[Cell, ...]] = [("Hopf point", onset.parameter, onset.period, 0.0, 0.0, None, counts, None)]
    rows += [_special_row(special) for special in branch.special]
    heading = (
        "point | log_{10} r .10f | T [transits] .7f | Δμ [σ] .7f | Δy [σ] .7f | bracket [log_{10} r] | unstable | "
        "multiplier that passes"
    )
    caption = (
        f"Special points of the branch of `{model}`, in order from the Hopf point. Bracket: width of the interval that holds the "
        "point. Unstable: number of multipliers outside the unit circle before and after the point; at the Hopf point, growing "
        "roots of steady sliding below and above it. At a fold T is known to 10^{-6}, relative."
    )
    return table(f"special-{model.replace(':', '-')}", caption, heading, rows)


def _special_row(special: Special) -> tuple[Cell, ...]:
    """Row of a special point; at a fold r hardly changes, so that its bracket is lost in rounding."""
    found, value, bracket = figures_of(special.point.closed), special.multiplier, special.bracket
    turning = f"{plain(value.real, '.6f')} ± {plain(abs(value.imag), '.6f')} i"
    passing = {"LP": "1", "PD": "−1", "NS": turning}[special.kind]
    counts = f"{special.unstable_before} → {special.unstable_after}"
    width = plain(bracket, ".0e") if bracket > _ROUNDING else f"below {plain(_ROUNDING, '.0e')}"
    return (NAMES[special.kind], special.point.parameter, *(found[name] for name in COMPARED), width, counts, passing)


def structure_table(delay: Branch, others: Iterable[Branch]) -> Table:
    """Distances of the special points of other models from those of the delay system, by kind, in order."""
    every = [delay, *others]
    found = {NAMES["HB"]: [branch.onset.parameter for branch in every]} | {
        f"{NAMES[kind]} {n + 1}": [_r_of(branch, kind, n) for branch in every]
        for kind, most in _COUNTED.items()
        for n in range(most)
    }
    rows = ([point, exact, *(_apart(other, exact) for other in found)] for point, (exact, *found) in found.items())
    columns = " | ".join(f"{one.model} [log_{{10}} r] .1e" for one in every[1:])
    caption = (
        "Special points of the delay system, and how far those of other models are from them in log_{10} r; empty: the model has "
        "none of that number, or none up to where its branch was followed. Each kind is counted along the branch."
    )
    return table("structure", caption, f"point | delay [log_{{10}} r] .7f | {columns}", rows)


def _r_of(branch: Branch, kind: str, n: int) -> float | None:
    found = branch.of_kind(kind)
    return found[n].point.parameter if n < len(found) else None


def _apart(one: float | None, other: float | None) -> float | None:
    return None if one is None or other is None else one - other


def _wave_table(orbits: Iterable[WaveOrbit]) -> Table:
    rows = [(one.log10_r, *(one.wave[name] for name in COMPARED), one.apart) for one in orbits]
    caption = (
        f"Orbits of the full wave, `{WAVE}` marched exactly, by Newton’s method on the motion of the grid over one period; the "
        "last column is the largest relative difference of T, Δμ and Δy from the delay system’s branch."
    )
    return table("waves", caption, "log_{10} r .2f | T [transits] .10f | Δμ [σ] .10f | Δy [σ] .10f | apart .0e", rows)


def diagram(branches: Iterable[Branch], waves: Iterable[WaveOrbit]) -> Drawing:
    """The paper's Fig 6: period and drops over log10 r; left from the onset to log10 r = -2.62, right to the end."""
    figure, panels = subplots(8.2, 3, 2, r"$\log_{10} r$", sharex="col", sharey="row", width_ratios=(1.25, 1.0))
    cornered = {branch.model: (branch, branch.corners) for branch in branches}
    for (near, far), name in zip(panels, COMPARED, strict=True):
        for model, (branch, corners) in cornered.items():
            for axes in (near, far):
                draw_branch(axes, model, corners, name)
                draw_special(axes, branch, name)
        near.plot([one.log10_r for one in waves], [one.wave[name] for one in waves], "o", linestyle="none", **_WAVE)
        near.set(ylabel=_LABELS[name], xlim=(_LEFT, _ZOOM))
        ruled(near, far)
    figure.legend(handles=[*_keys(cornered, waves)], loc="outside upper left", ncols=4, handlelength=2.4)
    return figure


_WAVE: dict[str, Any] = {"color": "#d55e00", "markerfacecolor": "none", "markersize": 7.0, "markeredgewidth": 1.2}


def _keys(models: Iterable[str], waves: Iterable[WaveOrbit]) -> Iterator[Any]:
    """Lines for the legend: models, kinds of points, the full wave."""
    for model in models:
        yield key(**line(model, color=color_of(model), linestyle="-"))
    yield from special_keys(NAMES)
    if waves:
        yield key(marker="o", linestyle="none", label=f"full wave, {WAVE}", **_WAVE)


def wave_orbit(branch: Branch, log10_r: float) -> WaveOrbit:
    """The orbit that the full wave reaches from the scene's own start; `branch` is the delay system's."""
    wave = figures_of(memo.own_orbit(WAVE, scene_at(log10_r), _TOLERANCE, _CELLS).closed)
    others = [figures_of(orbit) for orbit in branch.orbits_at(log10_r)]
    return WaveOrbit(log10_r, wave, min(others, key=lambda one: abs(one["period"] - wave["period"])))


def published(branch: Branch) -> Verdict:
    """Verdict: the Hopf point and the special points against values of other programs."""
    known, found = reference()["special"][branch.model], {name: branch.of_kind(kind) for name, kind in _PUBLISHED.items()}
    pairs = [(branch.onset.parameter, reference()["hopf"][branch.model]["log10_r"], 0.0)]
    pairs += [
        (one[0].point.parameter, known[name]["log10_r"], one[0].bracket) for name, one in found.items() if name in known and one
    ]
    errors = [(abs(ours - theirs), 2.0 * half_digit(theirs) + bracket) for ours, theirs, bracket in pairs]
    off, allowed = max(errors, key=lambda one: one[0] / one[1])
    others = "AUTO-07p" if branch.model == "kelvin-voigt" else "lifted shooting and DDE-BIFTOOL"
    title = f"Special points of `{branch.model}` are where other programs find them"
    return claim(title, WITNESS, off, allowed, f"log_{{10}} r of {len(pairs)} points, Hopf point included, against {others}")


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


def same_orbits(waves: Sequence[WaveOrbit]) -> Verdict:
    """The full wave's orbits against the delay system's."""
    remark = f"largest relative difference of T, Δμ and Δy, `{WAVE}` at {len(waves)} values of r"
    title = "The full wave’s own orbits lie on the delay system’s branch"
    return claim(title, WITNESS, max(one.apart for one in waves), _WAVE_ORBITS, remark)


def mildly_subcritical(delay: Branch, ode: Branch) -> Verdict:
    """P8."""
    first = {branch.model: branch.special[0] for branch in (delay, ode)}
    turned = {one.model: 1.0 - 10.0 ** (first[one.model].point.parameter - one.onset.parameter) for one in (delay, ode)}
    kinds = {(one.kind, one.unstable_before, one.unstable_after) for one in first.values()}
    return of_paper(
        "P8 The Hopf point is very mildly subcritical; the branch becomes stable at a saddle-node",
        f"a fold at most {100 * JUST_BELOW:g} % below r_{{c}}",
        ", ".join(f"{100 * share:.2f} % below r_{{c}} ({model})" for model, share in turned.items()),
        min(turned.values()) > 0.0 and max(turned.values()) < JUST_BELOW and kinds == {("LP", 1, 0)},
        "unstable orbits lead from the Hopf point back to the fold, where one multiplier passes 1 inwards",
    ).with_margin(max(turned.values()), JUST_BELOW)


def bubbles(ode: Branch) -> Iterator[Verdict]:
    """P9: special points of the ODE's branch up to its torus point, and where that is."""
    kinds = [one.kind for one in ode.special]
    until = kinds[kinds.index("PD") : kinds.index("NS") + 1] if "NS" in kinds else kinds
    paper, torus = reference()["paper"]["log10_r_torus"], ode.of_kind("NS")[0].point.parameter
    title = "P9 The ODE’s orbits lose stability in pairs of period doublings split by saddle-nodes, then at a torus point"
    yield of_paper(title, " ".join(_BUBBLES), " ".join(until), until == _BUBBLES, _DOUBLINGS)
    larger = 100 * abs(10.0 ** (paper - torus) - 1.0)
    yield of_paper(
        "P9 The torus point of the ODE lies at r = 10^{-2.468}",
        minus(f"log_{{10}} r = {paper} ± {half_digit(paper):g}"),
        minus(f"log_{{10}} r = {torus:.6f}"),
        abs(torus - paper) <= half_digit(paper),
        f"the paper’s r is {larger:.2f} % larger; AUTO-07p confirms ours",
    ).with_margin(abs(torus - paper), half_digit(paper))


def modes_converge(delay: Branch, modal: Sequence[Branch]) -> Verdict:
    """Verdict: the first fold converges to that of the delay system with the number of modes; `modal` in increasing order."""
    fold, *folds = (branch.of_kind("LP")[0].point.parameter for branch in (delay, *modal))
    off = [abs(one - fold) for one in folds]
    left, title = (
        max(later / earlier for earlier, later in pairwise(off)),
        "The more exact modes a reduction keeps, the nearer its first fold is to the delay system’s",
    )
    where = f"in log_{{10}} r, {', '.join(f'`{branch.model}`' for branch in modal)}"
    shown = ", ".join(plain(one, ".1e") for one in off)
    return claim(title, ASYMPTOTIC, left, 0.5, where, shown, unit="of the distance before")


def unlike(delay: Branch, ode: Branch) -> Verdict:
    """P14: the first loss of stability of the two systems' orbits, except folds."""
    lost = {
        branch.model: next(one for one in branch.special if one.kind != "LP" and one.unstable_before < one.unstable_after)
        for branch in (delay, ode)
    }
    words = {"PD": "period doubling", "NS": "torus"}
    first = (f"{model}: first a " + minus(f"{words[one.kind]} at {one.point.parameter:.4f}") for model, one in lost.items())
    counts = [", ".join(str(len(branch.of_kind(kind))) for kind in ("LP", "PD", "NS")) for branch in (delay, ode)]
    return of_paper(
        "P14 The delay system has bifurcations similar to the ODE’s",
        "similar",
        "; ".join(first),
        lost["delay"].kind == lost["kelvin-voigt"].kind,
        "Hopf point and first fold are alike, what follows is not. Folds, period doublings, torus points of the branches shown: "
        f"{counts[0]} in the delay system, {counts[1]} in the ODE",
    )
