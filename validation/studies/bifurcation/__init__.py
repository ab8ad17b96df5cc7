"""The bifurcation diagrams that the paper could not draw: orbits of the delay system and of the ODE, stable or not, over r."""

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import slipwave as sw
from validation.chart.looks import NAMES
from validation.measure.over_r import COMPARED, FAR, Branch, branch_of, scene_at, unaccounted
from validation.references.published import half_digit, reference
from validation.report import Budget, Cell, Figure, Number, Omission, StudyAnswer, StudyResult, Table, stated, table
from validation.report.known import JUST_BELOW
from validation.report.text import minus, plain
from validation.report.verdict import EXACT, PROGRAM, WITNESS, Verdict, claim, holding, of_paper
from validation.studies.bifurcation.charts import CAPTION, PLANES, diagram, orbits_in_planes
from validation.studies.bifurcation.doubling import PAIRS, Doubled, bubble, doubled, doubling_verdicts
from validation.studies.bifurcation.folds import fold_at, fold_verdicts, folds_over_drive

NAME = "bifurcation"
QUESTION = "How do the periodic orbits of the exact system and of the paper’s ODE depend on r, and where do they lose stability?"
SCENES = ("paper",)
SECONDS = (20.0, 60.0)

WAVE = "dg:7"

_CELLS, _TOLERANCE = 8, 1e-8
_PUBLISHED = {"first fold": "LP", "first period doubling": "PD", "first torus point": "NS"}
_WAVE_ORBITS = 1e-9
_BUBBLES = ["PD", "PD", "LP", "LP", "PD", "PD", "LP", "LP", "PD", "PD", "NS"]


class _Plan(NamedTuple):
    """Model -> log10 r and the period (transits) at which its branch ends; log10 r of the full wave's orbits; the pairs of period
    doublings; models whose first fold is followed over V, with so many points on each side of V = 100; whether the branch of the
    ODE reaches its torus point."""

    ends: dict[str, tuple[float, float]]
    waves: tuple[float, ...]
    pairs: tuple[tuple[float, float], ...]
    folds: tuple[str, ...]
    points: int
    to_torus: bool


_QUICK = _Plan({"delay": (-2.3, 78.5), "kelvin-voigt": (-2.579, FAR)}, (-2.69, -2.68), PAIRS[:1], ("delay",), 12, False)
_FULL = _Plan(
    {"delay": (-2.3, 85.0), "kelvin-voigt": (-2.3, FAR)},
    (-2.69, -2.68, -2.67, -2.66),
    PAIRS,
    ("delay", "kelvin-voigt"),
    24,
    True,
)


class WaveOrbit(NamedTuple):
    """Figures of the full wave's orbit at one r, and of the nearest orbit of the delay system's branch there, by period."""

    log10_r: float
    wave: dict[str, float]
    delay: dict[str, float]

    @property
    def apart(self) -> float:
        """Largest relative difference of period and drops."""
        return max(abs(self.wave[name] / self.delay[name] - 1.0) for name in COMPARED)


def run(budget: Budget) -> StudyResult:
    """Follow the branches from their Hopf points; find the full wave's own orbits, the doubled orbits and the folds over V."""
    plan = budget.plan(_QUICK, _FULL)
    delay, ode = (branch_of(model, *end) for model, end in budget.each(plan.ends.items(), end=0.5))
    waves = [wave_orbit(delay, log10_r) for log10_r in plan.waves]
    orbits, bubbles = doubled(), [bubble(*pair) for pair in budget.each(plan.pairs, end=0.8, begin=0.5)]
    folds = {model: folds_over_drive(model, plan.points) for model in plan.folds}
    branches = {"delay": delay, "kelvin-voigt": ode}
    return StudyResult(
        answers=_answers(delay, ode),
        figures=(
            Figure(
                "branches",
                CAPTION,
                lambda: diagram([delay, ode], waves),
                paper="Fig 6",
                carries=("P8 ", "P9 ", "P11 ", "P14 "),
            ),
            Figure("planes", PLANES, lambda: orbits_in_planes(orbits, ode, bubbles), paper="Fig 7", carries=("P10 ",)),
        ),
        tables=tuple(map(_special_table, branches.values())),
        verdicts=(
            *published(branches.values()),
            index(branches.values()),
            *_same_orbits(waves),
            _mildly_subcritical(delay, ode),
            *fold_verdicts(folds, fold_at(folds["delay"][-1][1])),
            *(_bubbles_of(ode) if plan.to_torus else ()),
            *doubling_verdicts(orbits, ode, bubbles),
            unlike(delay, ode),
        ),
        notes=(_HOW,),
        numbers=_numbers(branches.values(), orbits),
        omissions=() if plan.to_torus else (_P9,),
    )


def _answers(delay: Branch, ode: Branch) -> tuple[StudyAnswer, ...]:
    torus, first, second = delay.of_kind("NS")[0], *ode.of_kind("PD")[:2]
    return (
        StudyAnswer(
            minus(
                "Both are born at a mildly subcritical Hopf point and become stable at a fold. From there on they differ: the "
                f"orbit of the exact system loses stability to a torus at log_{{10}} r = {torus.point.parameter:.7f} on a branch "
                f"that folds back and forth, that of the ODE by period doubling at {first.point.parameter:.7f}."
            ),
            ("Special points", "Along every branch", "The full wave’s own orbits", "P8 ", "Only the products", "P14 "),
        ),
        StudyAnswer(
            minus(
                f"From there to {second.point.parameter:.7f} the ODE’s simple orbit is unstable, and beside it lies a stable one "
                "of twice the period, born at one end and gone at the other."
            ),
            ("P9 ", "P10 ", "The orbit of T = 79.09", "A direct run settles on the doubled orbit"),
        ),
    )


def _numbers(branches: Iterable[Branch], orbits: Doubled) -> dict[str, Number]:
    numbers: dict[str, Number] = {}
    for branch in branches:
        numbers[f"{branch.model} HB"] = Number(branch.onset.parameter, 1e-11)
        for kind in ("LP", "PD", "NS"):
            for count, one in enumerate(branch.of_kind(kind), 1):
                numbers[f"{branch.model} {kind} {count}"] = stated(one.point.parameter, one.bracket)
    for name, orbit, within in (("", orbits.single, 1e-7), ("doubled ", orbits.double, 1e-6)):
        period = orbit.orbit.period
        numbers[f"{name}T"] = stated(period.value, period.error)
        numbers[f"{name}multiplier"] = Number(float(orbit.multipliers.values[0].real), within)
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

_ROUNDING = 1e-11  # brackets (log10 r) below this are not shown


def _special_table(branch: Branch) -> Table:
    onset, model = branch.onset, branch.model
    rows: list[tuple[Cell, ...]] = [
        ("Hopf point", onset.parameter, onset.period, "", f"{onset.unstable_below} → {onset.unstable_above}")
    ]
    for one in branch.special:
        width = plain(one.bracket, ".0e") if one.bracket > _ROUNDING else f"below {plain(_ROUNDING, '.0e')}"
        counts = f"{one.unstable_before} → {one.unstable_after}"
        rows.append((NAMES[one.kind], one.point.parameter, one.point.closed.cycle.period, width, counts))
    caption = (
        f"Special points of the branch of `{model}`, in order from the Hopf point. Bracket: width of the interval that holds the "
        "point; at a fold T is known to 10^{-6}, relative. Unstable: number of multipliers outside the unit circle before and "
        "after it; at the Hopf point growing roots below and above."
    )
    heading = "point | log_{10} r .10f | T [transits] .7f | bracket [log_{10} r] | unstable"
    return table(f"special-{model}", caption, heading, rows)


def wave_orbit(branch: Branch, log10_r: float) -> WaveOrbit:
    """The orbit that the full wave reaches from the scene's own start; `branch` is the delay system's, whose drops are computed
    anew on a finer mesh."""
    scene = scene_at(log10_r)
    wave = sw.orbit(scene, WAVE, tol=_TOLERANCE, cells=_CELLS).summary
    nearest = min((one.cycle.period for one in branch.orbits_at(log10_r)), key=lambda period: abs(period - wave["period"]))
    return WaveOrbit(log10_r, wave, sw.orbit(scene, "delay", tol=1e-10).summary | {"period": nearest})


def published(branches: Iterable[Branch]) -> Iterator[Verdict]:
    """Verdicts: the Hopf points and special points against values of other programs."""
    for branch in branches:
        known = reference()["special"][branch.model]
        pairs = [(branch.onset.parameter, reference()["hopf"][branch.model]["log10_r"], 0.0)]
        for name, kind in _PUBLISHED.items():
            if name in known:
                pairs += [(one.point.parameter, known[name]["log10_r"], one.bracket) for one in branch.of_kind(kind)[:1]]
        errors = [(abs(ours - theirs), 2.0 * half_digit(theirs) + bracket) for ours, theirs, bracket in pairs]
        off, allowed = max(errors, key=lambda one: one[0] / one[1])
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


def _same_orbits(waves: Iterable[WaveOrbit]) -> Iterator[Verdict]:
    """The full wave's orbits against the delay system's."""
    title = f"The full wave’s own orbits, `{WAVE}`, lie on the delay system’s branch"
    for one in waves:
        remark = minus(f"log_{{10}} r = {one.log10_r:g}: largest relative difference of T, Δμ and Δy")
        yield claim(title, WITNESS, one.apart, _WAVE_ORBITS, remark)


def _mildly_subcritical(delay: Branch, ode: Branch) -> Verdict:
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


def _bubbles_of(ode: Branch) -> Iterator[Verdict]:
    """P9: special points of the ODE's branch up to its torus point, and where that is."""
    kinds = [one.kind for one in ode.special]
    until = kinds[kinds.index("PD") : kinds.index("NS") + 1] if "NS" in kinds else kinds
    paper, torus = reference()["paper"]["log10_r_torus"], ode.of_kind("NS")[0].point.parameter
    title = "P9 The ODE’s orbits lose stability in pairs of period doublings split by saddle-nodes, then at a torus point"
    yield of_paper(
        title,
        " ".join(_BUBBLES),
        " ".join(until),
        until == _BUBBLES,
        "from the first period doubling on; LP is a saddle-node, NS the torus point",
    )
    larger = 100 * abs(10.0 ** (paper - torus) - 1.0)
    yield of_paper(
        "P9 The torus point of the ODE lies at r = 10^{-2.468}",
        minus(f"log_{{10}} r = {paper} ± {half_digit(paper):g}"),
        minus(f"log_{{10}} r = {torus:.6f}"),
        abs(torus - paper) <= half_digit(paper),
        f"the paper’s r is {larger:.2f} % larger; AUTO-07p confirms ours",
    ).with_margin(abs(torus - paper), half_digit(paper))


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
