"""The full wave's own periodic orbits beside the delay system's branch; what the branches must show: published points, the
index, the full wave's orbits, and the paper's P8, P9 and P14."""

from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

from reduced.orbit.figures import figures_of
from validation.references.published import half_digit, reference
from validation.study import ASYMPTOTIC, EXACT, WITNESS, Verdict, claim, holding, memo, of_paper
from validation.study.known import JUST_BELOW
from validation.study.over_r import COMPARED, Branch, scene_at, unaccounted
from validation.study.text import minus, plain

WAVE = "dg:7"

_CELLS, _TOLERANCE = 8, 1e-8
_PUBLISHED = {"first fold": "LP", "first period doubling": "PD", "first torus point": "NS"}
_DIGITS = 5e-9  # half the last published digit is 5e-10
_WAVES = 1e-9
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


def wave_orbit(branch: Branch, log10_r: float) -> WaveOrbit:
    """The orbit that the full wave reaches from the scene's own start; `branch` is the delay system's."""
    wave = figures_of(memo.own_orbit(WAVE, scene_at(log10_r), _TOLERANCE, _CELLS).closed)
    others = [figures_of(orbit) for orbit in branch.orbits_at(log10_r)]
    return WaveOrbit(log10_r, wave, min(others, key=lambda one: abs(one["period"] - wave["period"])))


def published(branch: Branch) -> Verdict:
    """The Hopf point and the special points that other programs know."""
    known, found = reference()["special"][branch.model], {name: branch.of_kind(kind) for name, kind in _PUBLISHED.items()}
    off = [abs(branch.onset.parameter - reference()["hopf"][branch.model]["log10_r"])]
    off += [abs(one[0].point.parameter - known[name]["log10_r"]) for name, one in found.items() if name in known and one]
    others = "AUTO-07p" if branch.model == "kelvin-voigt" else "lifted shooting and DDE-BIFTOOL"
    title = f"Special points of `{branch.model}` are where other programs find them"
    return claim(title, WITNESS, max(off), _DIGITS, f"log_{{10}} r of {len(off)} points, Hopf point included, against {others}")


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
    return claim(title, WITNESS, max(one.apart for one in waves), _WAVES, remark)


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
    """P9: what happens on the ODE's branch up to its torus point, and where that is."""
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
    """The first fold of the delay system by ever more modes; `modal` has the fewest first."""
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
    """P14: what takes the stability of the two systems' orbits first, folds left out."""
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


_DOUBLINGS = (
    "kinds of the special points from the first period doubling on: PD period doubling, LP saddle-node, NS torus point. The "
    "paper calls the doublings connected, which is about the doubled orbits, not about this branch"
)
