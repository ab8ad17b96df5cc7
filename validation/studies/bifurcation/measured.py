"""DOC"""

from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import NamedTuple

from reduced.orbit import periodic_orbit
from reduced.orbit.approach import approach
from reduced.orbit.figures import figures_of
from validation.references.published import half_digit, reference
from validation.registry.orbits import moving
from validation.study import Evidence, Verdict, judge, of_paper
from validation.study.bounds import bounded
from validation.study.over_r import COMPARED, Branch, scene_at, unaccounted

WAVE, CELLS = "dg:7", 8
_TOLERANCE = 1e-8


class WaveOrbit(NamedTuple):
    """Figures of the full wave's orbit at one r, and of the nearest orbit of the delay system's branch there, by period."""

    log10_r: float
    wave: dict[str, float]
    delay: dict[str, float]

    @property
    def apart(self) -> float:
        """Largest relative difference of period and drops."""
        return max(abs(self.wave[name] / self.delay[name] - 1.0) for name in COMPARED)


def wave_orbit(branch: Branch, log10_r: float) -> WaveOrbit:
    """The orbit that the full wave reaches from the scene's own start; `branch` is the delay system's."""
    model = moving(WAVE, scene_at(log10_r), _TOLERANCE, CELLS)
    wave = figures_of(periodic_orbit(*approach(model.solver, model.freeze)[:3], _TOLERANCE).closed)
    others = [figures_of(orbit) for orbit in branch.orbits_at(log10_r)]
    return WaveOrbit(log10_r, wave, min(others, key=lambda one: abs(one["period"] - wave["period"])))


_PUBLISHED = {"first fold": "LP", "first period doubling": "PD", "first torus point": "NS"}
_DIGITS = 5e-9  # half the last published digit, 5e-10, was measured
_WAVES = 1e-9
_BUBBLES = ["PD", "PD", "LP", "LP", "PD", "PD", "LP", "LP", "PD", "PD", "NS"]


def published(branch: Branch) -> Verdict:
    """The Hopf point and the special points that other programs know."""
    known = reference()["special"][branch.model]
    off = [abs(branch.onset.parameter - reference()["hopf"][branch.model]["log10_r"])]
    for name, kind in _PUBLISHED.items():
        found = branch.of_kind(kind)
        if name in known and found:
            off.append(abs(found[0].point.parameter - known[name]["log10_r"]))
    others = "AUTO-07p" if branch.model == "kelvin-voigt" else "lifted shooting and DDE-BIFTOOL"
    claim = f"Special points of `{branch.model}` are where other programs find them"
    remark = f"log_{{10}} r of {len(off)} points, Hopf point included, against {others}"
    return bounded(claim, Evidence.WITNESS, max(off), _DIGITS, remark)


def index(branches: Iterable[Branch]) -> Verdict:
    """Every change of the number of unstable multipliers is that of a special point."""
    listed = list(branches)
    missed = sum(unaccounted(branch) for branch in listed)
    events = sum(len(branch.special) for branch in listed)
    return Verdict(
        "Along every branch the number of unstable multipliers changes at special points alone, by 1 at a fold or a period "
        "doubling and by 2 at a torus point",
        Evidence.EXACT,
        "no point unaccounted for",
        f"{missed} points",
        judge(missed == 0),
        f"{events} special points. Pairs of folds that a step passes whole change no count: these are excluded by short steps",
    )


def same_orbits(waves: Iterable[WaveOrbit]) -> Verdict:
    """The full wave's orbits against the delay system's."""
    listed = list(waves)
    claim = "The full wave’s own orbits lie on the delay system’s branch"
    remark = f"largest relative difference of T, Δμ and Δy, `{WAVE}` at {len(listed)} values of r"
    return bounded(claim, Evidence.WITNESS, max(one.apart for one in listed), _WAVES, remark)


def mildly_subcritical(branches: Iterable[Branch]) -> Verdict:
    """P8."""
    listed = [branch for branch in branches if branch.model in ("delay", "kelvin-voigt")]
    first = {branch.model: branch.special[0] for branch in listed}
    turned = {branch.model: 1.0 - 10.0 ** (first[branch.model].point.parameter - branch.onset.parameter) for branch in listed}
    holds = all(
        one.kind == "LP" and (one.unstable_before, one.unstable_after) == (1, 0) and turned[model] > 0.0
        for model, one in first.items()
    )
    return of_paper(
        "P8 The Hopf point is very mildly subcritical; the branch becomes stable at a saddle-node",
        "a fold just below r_{c}",
        ", ".join(f"{100 * share:.2f} % below r_{{c}} ({model})" for model, share in turned.items()),
        holds,
        "unstable orbits lead from the Hopf point back to the fold, where one multiplier passes 1 inwards",
    )


def bubbles(ode: Branch) -> tuple[Verdict, Verdict]:
    """P9: what happens on the ODE's branch up to its torus point, and where that is."""
    kinds = [one.kind for one in ode.special]
    until = kinds[kinds.index("PD") : kinds.index("NS") + 1] if "NS" in kinds else kinds
    paper, torus = reference()["paper"]["log10_r_torus"], ode.of_kind("NS")[0].point.parameter
    claim = "P9 The ODE’s orbits lose stability in pairs of period doublings split by saddle-nodes, then at a torus point"
    return (
        of_paper(claim, " ".join(_BUBBLES), " ".join(until), until == _BUBBLES, _P9),
        of_paper(
            "P9 The torus point of the ODE lies at r = 10^{-2.468}",
            f"10^{{{paper}}}",
            f"10^{{{torus:.6f}}}",
            abs(torus - paper) <= half_digit(paper),
            f"the paper’s r is {100 * abs(10.0 ** (paper - torus) - 1.0):.2f} % larger; AUTO-07p confirms ours",
        ),
    )


def modes_converge(delay: Branch, modal: Sequence[Branch]) -> Verdict:
    """The first fold of the delay system by ever more modes; `modal` has the fewest first."""
    fold = delay.of_kind("LP")[0].point.parameter
    off = [abs(branch.of_kind("LP")[0].point.parameter - fold) for branch in modal]
    return Verdict(
        "The more exact modes a reduction keeps, the nearer its first fold is to the delay system’s",
        Evidence.ASYMPTOTIC,
        "each distance below half the one before",
        ", ".join(f"{one:.1e}" for one in off),
        judge(all(later < 0.5 * earlier for earlier, later in pairwise(off))),
        f"in log_{{10}} r, {', '.join(f'`{branch.model}`' for branch in modal)}",
    )


def unlike(delay: Branch, ode: Branch) -> Verdict:
    """P14: what takes the stability of the two systems' orbits first, folds left out."""
    lost = {
        branch.model: next(one for one in branch.special if one.kind != "LP" and one.unstable_before < one.unstable_after)
        for branch in (delay, ode)
    }
    words = {"PD": "period doubling", "NS": "torus"}
    first = {model: f"{words[one.kind]} at {one.point.parameter:.4f}".replace("-", "−") for model, one in lost.items()}
    return of_paper(
        "P14 The delay system has bifurcations similar to the ODE’s",
        "similar",
        "; ".join(f"{model}: first a {point}" for model, point in first.items()),
        lost["delay"].kind == lost["kelvin-voigt"].kind,
        "Hopf point and first fold are alike, what follows is not. Folds, period doublings, torus points of the branches shown: "
        f"{_tally(delay)} in the delay system, {_tally(ode)} in the ODE",
    )


def _tally(branch: Branch) -> str:
    return ", ".join(str(len(branch.of_kind(kind))) for kind in ("LP", "PD", "NS"))


_P9 = (
    "kinds of the special points from the first period doubling on: PD period doubling, LP saddle-node, NS torus point. The "
    "paper calls the doublings connected, which is about the doubled orbits, not about this branch"
)
