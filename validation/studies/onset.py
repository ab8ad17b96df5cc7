"""Where steady sliding loses stability, in the exact system and in every reduction of it: the paper's Figs 2 and 3 and beyond.
About a kernel, the stability of `reduced`."""

import cmath
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

import slipwave
from reduced import closed_forms
from reduced.impedance import check_passivity
from reduced.impedance.reduction import TAYLOR as TRUNCATION
from reduced.parameters import scaled, with_parameter
from reduced.stability import Boundary, FrictionSlopes, analyse, boundary, critical_round_trip, friction_slopes
from reduced.stability.characteristic import characteristic
from reduced.stability.spectrum import follow_root, unstable_count
from validation.chart import DASHED, GUIDE, ORANGE, Chart, Look, Panel, Scale, Trace, with_gaps
from validation.chart.looks import model_line, model_marks
from validation.report import (
    ASYMPTOTIC,
    EXACT,
    PAPER,
    WITNESS,
    Budget,
    Figure,
    Number,
    StudyResult,
    Verdict,
    Verdicts,
    claim,
    holding,
    plain,
)

NAME = "onset"
QUESTION = "Where does steady sliding give way to stick-slip, and how far off is each reduction there?"
SCENES = ("paper", "rock", "unlike", "unlike-irrational", "grip", "layered", "viscous", "reflection", "slip-law")
SECONDS = (8.0, 10.0)

FORMS = {
    "delay": (closed_forms.delay_r, closed_forms.delay_epsilon),
    "kelvin-voigt": (closed_forms.kelvin_voigt_r, closed_forms.kelvin_voigt_epsilon),
}
"""Models with closed forms of their boundary: r over V and epsilon, and epsilon over r."""

_SPEEDS = (1.0, 10.0, 100.0, 1e3, 1e4)
_ROUNDING = 2e-14  # relative
_STEP = 1e-6  # log10 r
_THIN, _ON_LINE = 1e-5, 1e-6
_TRACED = 4e-10  # Newton's method ends at steps of about this size squared
_FIRST_TRACED = 2e-3  # at eps = 1e-6 the branch (28) lies 9e-4 beyond its asymptote, relative
_WINDOW = ((-3.2, -0.75), (-6.0, -1.0))
_ONSETS = ("delay", "quasistatic", "quasidynamic", "block8", "block12", "kelvin-voigt", "modal:1", "modal:2", "modal:8")

CLOSED = "Closed forms of the onset are roots of the systems’ own equations, found from impedance alone"
TRACED = "Fig 3: boundaries traced in the (r, ε) plane without knowing them lie on (28) and (40)"
SECOND = "Fig 3: beyond r = √24/ω_{c} a second pair of roots of the ODE crosses"
THIN = "Fig 3: as r → 0 both boundaries approach the quasi-static line ε = −G_{φ} F_{ss}′ r"
CROSSED = "Beyond every onset a pair of roots grows that decays below it"
TAYLOR = "The next Taylor truncation after the paper’s cannot be used"


def run(budget: Budget) -> StudyResult:
    """Compute the curves, trace the boundaries, compare both with the closed forms; count roots on both sides of every onset."""
    paper = slipwave.read("paper")
    velocity = np.geomspace(1.0, 1e4, budget.plan(quick=25, full=81))
    scenes = [scaled(paper, velocity=v) for v in velocity.tolist()]
    critical = {model: np.array([critical_round_trip(scene, model)[0] for scene in scenes]) for model in budget.each(FORMS, 0.2)}

    def paper_at(log10_r: float, log10_epsilon: float) -> slipwave.Scene:
        return with_parameter(with_parameter(paper, "log10_r", log10_r), "log10_epsilon", log10_epsilon)

    traced = {model: boundary(paper_at, model, _WINDOW) for model in budget.each(FORMS, 0.6, 0.2)}
    onsets = {f"`{model}`": (paper, model, math.log10(critical_round_trip(paper, model)[0])) for model in _ONSETS}
    others = {name: slipwave.read(name) for name in SCENES[1:]}
    onsets |= {
        f"scene {name}": (scene, "delay", analyse(scene).log10_r_c) for name, scene in budget.each(others.items(), 0.9, 0.6)
    }
    slopes = friction_slopes(paper.law, paper.velocity)
    error = critical["kelvin-voigt"] / critical["delay"] - 1.0
    return StudyResult(
        answers={
            answer(velocity, error): (CLOSED, TRACED, SECOND, THIN, CROSSED),
            "A further term of the paper’s expansion makes an ODE that grows where sliding is stable.": (TAYLOR,),
        },
        figures=(
            Figure("critical-r", _FIG_2, lambda: _critical_curves(velocity, critical), paper="Fig 2", carries=("P1 ", "P2 ")),
            Figure("planes", _FIG_3, lambda: _boundaries_in_plane(traced, slopes, paper), paper="Fig 3", carries=("Fig 3",)),
        ),
        verdicts=(
            *_closed_form_verdicts(paper, velocity, critical),
            *_fig_3(traced, slopes, paper),
            *_crossings(onsets),
            _taylor(paper),
        ),
        notes=(_HOW,),
        numbers={
            f"log10 r_c, {name.strip('`')}": Number(at, 1e-9 if "scene" in name else 1e-11) for name, (*_, at) in onsets.items()
        }
        | {"error of (27) at V = 1e4": Number(error[-1], 1e-9)},
    )


def answer(velocity: np.ndarray, error: np.ndarray) -> str:
    """Text with the relative `error` of the Kelvin-Voigt system's critical r over V, (27) against (39)."""
    here, below = abs(np.interp(2.0, np.log10(velocity), error)), np.abs(error[velocity <= 1e3]).max()
    return (
        "Stick-slip begins where the impedance of the slabs cancels that of friction, which every model tells without a run. "
        f"The paper’s ODE misses the exact r_{{c}} by {plain(here, '.0e')} at V = 100, by {plain(below, '.1e')} at V = 10^{{3}} "
        f"and by {100 * abs(error[-1]):.0f} % at V = 10^{{4}}."
    )


_HOW = (
    "H(s) + Z(s) = 0 for every scene and model: friction impedance plus slab impedance. Growing roots are counted by the "
    "argument principle on a contour that provably encloses all of them (a passive slab cannot make one where Re H > 0), then "
    "found by Newton’s method."
)
_FIG_2 = (
    "Critical round trip r_{c} over the drive V, of the exact delay system and of the paper’s Kelvin–Voigt system, and the "
    "relative error of the latter. Computed from impedance."
)
_FIG_3 = (
    "Stability boundaries in the (r, ε) plane at V = 100. Lines: closed forms (40) and (28); marks: traced by continuation of a "
    "neutral root. Steady sliding is unstable below the first branch; across the second a further pair of roots crosses. Between "
    "√8/ω_{c} and √24/ω_{c} the ODE has no boundary."
)


def _critical_curves(velocity: np.ndarray, critical: Mapping[str, np.ndarray]) -> Chart:
    """The paper's Fig 2."""
    over, dashes = Scale("$V/V^*$", "log"), {"delay": "-", "kelvin-voigt": DASHED}
    lines = [model_line(model, velocity, values, dashes=dashes[model]) for model, values in critical.items()]
    error = model_line("kelvin-voigt", velocity, np.abs(critical["kelvin-voigt"] / critical["delay"] - 1.0), dashes="-")
    tenth = Trace("10 %", [-np.inf, np.inf], [0.1, 0.1], GUIDE)
    panels = (
        Panel("", over, Scale("$r_c$", "log"), lines, "best"),
        Panel("", over, Scale("relative error of $r_c$", "log"), [error, tenth]),
    )
    return Chart(panels, 3.1, 2)


def _boundaries_in_plane(traced: Mapping[str, Sequence[Boundary]], slopes: FrictionSlopes, paper: slipwave.Scene) -> Chart:
    """The paper's Fig 3: both systems' boundaries, traced (marks) and in closed form (lines)."""
    r, series = np.geomspace(10**-3.2, 10**-0.75, 1000), list[Trace]()
    for model, (_, closed) in FORMS.items():
        values = np.array([closed(slopes, x) for x in r])
        points = with_gaps((10 ** curve.first[::3], 10 ** curve.second[::3]) for curve in traced[model])
        own = model_line(model, r, np.where(values > 0.0, values, np.nan), dashes="-", width=1.1)
        series += [own, Trace(f"{own.name}, traced", *points, model_marks(model, size=3.5))]
    series.append(Trace("paper's scene", [paper.transit], [paper.upper.epsilon], Look(ORANGE, "", "X", size=8.0)))
    for square in (8, 24):
        at = math.sqrt(square) / slopes.omega_c
        series.append(Trace(rf"$\sqrt{{{square}}}/\omega_c$", [at, at], [-np.inf, np.inf], GUIDE))
    for words, x, y in (("steady sliding stable", 6e-3, 4e-3), ("unstable", 6e-3, 4e-6)):
        series.append(Trace(words, [x], [y], Look(kind="text")))
    plane = Scale("$r$", "log", (r[0], r[-1])), Scale(r"$\epsilon$", "log", (1e-6, 0.1))
    return Chart([Panel("", *plane, series, "upper left")], 4.0)


def _closed_form_verdicts(paper: slipwave.Scene, velocity: np.ndarray, critical: Mapping[str, np.ndarray]) -> Verdicts:
    """The closed forms against each other and against roots found from impedance."""
    epsilon = paper.upper.epsilon
    known = [[closed(friction_slopes(paper.law, v), epsilon) for v in velocity.tolist()] for closed, _ in FORMS.values()]
    gaps = [_gaps_at(paper, v) for v in _SPEEDS]
    worst = {name: max(gap[name] for gap in gaps) for name in gaps[0]}
    worst["r_{c} equals (39) and (27)"] = np.abs(np.array([*critical.values()]) / known - 1.0).max()
    for name, gap in worst.items():
        yield claim(CLOSED, EXACT, gap, _ROUNDING, f"{name}; relative, V = 1 to 10^{{4}}")


def _gaps_at(paper: slipwave.Scene, velocity: float) -> dict[str, float]:
    """Relative distances of the closed forms at a drive `velocity` from the roots that they shall be."""
    slopes, epsilon = friction_slopes(paper.law, velocity), paper.upper.epsilon
    r = closed_forms.kelvin_voigt_r(slopes, epsilon)
    cubic, x = closed_forms.kelvin_voigt_cubic(slopes, epsilon), r / closed_forms.quasistatic_r(slopes, epsilon)
    quartic, s = closed_forms.kelvin_voigt_quartic(slopes, epsilon, r), 1j * slopes.omega_c
    at_39 = replace(paper.upper, round_trip=closed_forms.delay_r(slopes, epsilon))
    driven = replace(scaled(paper, velocity=velocity), upper=at_39, lower=at_39)
    off = [
        float(abs(np.polyval(polynomial, at) / (np.polyval(np.polyder(polynomial), at) * at)))
        for polynomial, at in ((cubic, x), (quartic, s))
    ]
    return {
        "(27) is the middle root of the cubic (21)": off[0],
        "(27) makes the quartic (18) vanish at i ω_{c}": off[1],
        "at r of (39) the delay system has the root i ω_{c}": abs(
            follow_root(characteristic(driven), s * (1.0 + 1e-3j)) / s - 1.0
        ),
    }


def _fig_3(traced: Mapping[str, Sequence[Boundary]], slopes: FrictionSlopes, paper: slipwave.Scene) -> Verdicts:
    """The branches of Fig 3, traced and counted."""
    off = [
        np.abs(10**curve.second / np.array([closed(slopes, 10**x) for x in curve.first]) - 1.0).max()
        for model, (_, closed) in FORMS.items()
        for curve in traced[model]
    ]
    each = [len(curves) for curves in traced.values()]
    worst = max(off) if each == [2, 2] else math.inf
    yield claim(TRACED, EXACT, worst, _TRACED, f"{each[0]} branches of the delay system, {each[1]} of the ODE")
    counts = [_counts_across(paper, model, curve) for model, curves in traced.items() for curve in curves]
    asymptote = math.sqrt(24.0) / slopes.omega_c
    begins = (10 ** curve.first.min() for curve in traced["kelvin-voigt"])
    second = min(begin for begin in begins if begin > 0.5 * asymptote)
    parted = all(abs(above - below) == 2 for above, below in counts)
    yield holding(
        SECOND,
        PAPER,
        f"from r = {plain(asymptote, '.5g')}",
        f"from r = {plain(second, '.5g')}",
        0.0 <= second / asymptote - 1.0 < _FIRST_TRACED and parted,
        "traced down to ε = 10^{-6}; the certified number of growing roots changes by 2 across every branch: "
        f"{'yes' if parted else 'no'}",
    ).with_margin(abs(second / asymptote - 1.0), _FIRST_TRACED)
    quasistatic = -slopes.healing * slopes.steady * _THIN  # the asymptote that the paper names below (28)
    thin = max(abs(closed(slopes, _THIN) / quasistatic - 1.0) for _, closed in FORMS.values())
    yield claim(THIN, ASYMPTOTIC, thin, _ON_LINE, f"relative distance of (28) and (40) at r = {plain(_THIN, '.0e')}")


def _around(scene: slipwave.Scene, model: str, name: str, value: float, step: float) -> list[int]:
    """The certified counts of growing roots a step below and above a value of a parameter."""
    scenes = (with_parameter(scene, name, value + shift) for shift in (-step, step))
    return [unstable_count(characteristic(scene, model)) for scene in scenes]


def _counts_across(paper: slipwave.Scene, model: str, curve: Boundary) -> list[int]:
    """The certified counts on both sides of the middle of a boundary."""
    middle = len(curve.first) // 2
    at = with_parameter(paper, "log10_r", float(curve.first[middle]))
    return _around(at, model, "log10_epsilon", float(curve.second[middle]), 1e-3)


def _crossings(onsets: Mapping[str, tuple[slipwave.Scene, str, float]]) -> Verdicts:
    """The certified counts of growing roots just below and above each onset, which were not used to locate it."""
    for name, (scene, model, at) in onsets.items():
        below, beyond = _around(scene, model, "log10_r", at, _STEP)
        remark = f"{name}, log_{{10}} r_{{c}} = {plain(at, '.8f')}, counted {plain(_STEP, '.0e')} on both sides"
        yield holding(CROSSED, WITNESS, "2 roots more", f"{beyond - below} roots more", beyond - below == 2, remark)


def _taylor(paper: slipwave.Scene) -> Verdict:
    """The next truncation, which has growing roots of its own."""
    pole = max(TRUNCATION.poles_and_residues()[0], key=lambda value: (value.real, value.imag))
    known = cmath.sqrt(complex(-40.0, math.sqrt(320.0)))  # 1 + s^2/24 + s^4/1920 = 0
    growing = analyse(with_parameter(paper, "log10_r", -3.5), "taylor").unstable_roots
    passive, *_ = check_passivity(paper, "taylor")
    return holding(
        TAYLOR,
        EXACT,
        f"poles at {known.real:.4f} ± {known.imag:.4f} i",
        f"{pole.real:.4f} ± {abs(pole.imag):.4f} i per transit",
        abs(pole / known - 1.0) < _ROUNDING and pole.real > 0.0 and growing == 2 and not passive,
        f"its slab is {'' if passive else 'not '}passive: at r = 10^{{-3.5}}, where sliding is stable, it has {growing} growing "
        "roots of its own",
    ).with_margin(abs(pole / known - 1.0), _ROUNDING)
