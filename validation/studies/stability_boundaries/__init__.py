"""Where steady sliding loses stability, in the exact system and in every reduction of it: the paper's Figs 2 and 3 and beyond."""

import math

import numpy as np

import slipwave
from reduced.stability import Stability, analyse, boundary, critical_round_trip, friction_slopes, with_parameter
from validation.studies.stability_boundaries.measured import TRACED, Curves, critical_over_velocity
from validation.studies.stability_boundaries.shown import (
    critical_curves,
    impedances,
    model_table,
    planes,
    scene_table,
    spectra,
    velocity_table,
)
from validation.studies.stability_boundaries.verdicts import closed_form_verdicts, crossed, fig_2, fig_3, taylor
from validation.study import Budget, Figure, Number, StudyResult
from validation.study.text import plain

NAME = "stability-boundaries"
QUESTION = "Where does steady sliding give way to stick-slip, and how far off is each reduction there?"
SCENES = ("paper", "rock", "unlike", "unlike-irrational", "grip", "layered", "viscous", "reflection", "slip-law")
SECONDS = (8.0, 10.0)

_WINDOW = ((-3.2, -0.75), (-6.0, -1.0))
_ONSETS = ("delay", "quasistatic", "quasidynamic", "block8", "block12", "kelvin-voigt", "modal:1", "modal:2", "modal:8")
_SPECTRA = ("delay", "kelvin-voigt", "modal:1", "modal:8", "block12")


def run(budget: Budget) -> StudyResult:
    """Compute the curves, trace the boundaries, hold both against the closed forms."""
    paper = slipwave.read("paper")
    curves = critical_over_velocity(paper, np.geomspace(1.0, 1e4, 25 if budget.quick else 81))
    budget.report(0.2)
    traced = {model: boundary(paper, model, ("log10_r", "log10_epsilon"), _WINDOW) for model in TRACED}
    budget.report(0.6)
    found = {name: analyse(slipwave.read(name)) for name in SCENES}
    spectrum = {model: analyse(paper, model) for model in _SPECTRA}
    budget.report(0.8)
    onsets = {model: critical_round_trip(paper, model) for model in _ONSETS}
    slopes = friction_slopes(paper.law, paper.velocity)
    return StudyResult(
        answer=_answer(curves, onsets),
        figures=(
            Figure("critical-r", _FIG_2, lambda: critical_curves(curves.velocity, curves.delay, curves.kelvin_voigt)),
            Figure("planes", _FIG_3, lambda: planes(traced, slopes, paper)),
            Figure("impedance", _FIG_Z, lambda: impedances(paper)),
            Figure("spectrum", _FIG_S, lambda: spectra(spectrum, paper.transit)),
        ),
        tables=(velocity_table(curves), model_table(onsets), scene_table(found)),
        verdicts=(
            *closed_form_verdicts(paper, curves),
            *fig_2(curves),
            *fig_3(traced, slopes, paper),
            crossed(paper, onsets, found),
            taylor(paper),
        ),
        notes=(_HOW, *_remarks()),
        numbers=_numbers(onsets, curves, found),
    )


def _answer(curves: Curves, onsets: dict[str, tuple[float, float]]) -> str:
    here = onsets["kelvin-voigt"][0] / onsets["delay"][0] - 1.0
    below = float(np.abs(curves.error[curves.velocity <= 1e3]).max())
    return (
        "Stick-slip begins where the impedance of the slabs cancels that of friction. This can be computed for every model "
        "without running it. The paper’s ODE misses the exact r_{c} by "
        f"{plain(abs(here), '.0e')} at V = 100, by {plain(below, '.1e')} at V = "
        f"10^{{3}} and by {100 * abs(float(curves.error[-1])):.0f} % at V = 10^{{4}}."
    )


def _remarks() -> tuple[str, ...]:
    bare = analyse(with_parameter(slipwave.read("reflection"), "reflection", 0.5))
    return (
        "Slabs held through a bare reflection coefficient have no spring. With R = 0.5 on both faces the paper’s pair has "
        f"{bare.unstable_roots} growing root, real ({plain(bare.leading_roots[0].real, '.5g')} V*/L): it leaves steady "
        "sliding without oscillating, at any r. With the gallery’s R = 0.999 the load leaks slowly enough for an ordinary onset.",
        "Two unlike slabs behind rigid faces have modes in which both swing almost freely and in step, so that the "
        "interface hardly slips. If the ratio of round trips is irrational, the damping of these modes has no lower bound "
        "(`unlike-irrational`: 0).",
    )


def _numbers(onsets: dict[str, tuple[float, float]], curves: Curves, found: dict[str, Stability]) -> dict[str, Number]:
    return (
        {f"log10 r_c, {model}": Number(math.log10(r), 1e-11) for model, (r, _) in onsets.items()}
        | {f"log10 r_c, scene {name}": Number(stability.log10_r_c, 1e-9) for name, stability in found.items()}
        | {"error of (27) at V = 1e4": Number(float(curves.error[-1]), 1e-9)}
    )


_HOW = (
    "One equation for every scene and model: friction impedance plus slab impedance is zero, H(s) + Z(s) = 0. Growing roots are "
    "counted by the argument principle on a contour that provably encloses all of them (a passive slab cannot make one where "
    "Re H > 0), then found by Newton’s method."
)
_FIG_2 = (
    "Critical round trip r_{c} over the drive V, of the exact delay system and of the paper’s Kelvin–Voigt system, left; "
    "relative error of the latter, right. Computed from impedance; (39) and (27) give the same to rounding. The paper’s Fig 2."
)
_FIG_3 = (
    "Stability boundaries in the (r, ε) plane at V = 100. Lines: closed forms (40) and (28); marks: traced by continuation of a "
    "neutral root. Steady sliding is unstable below the first branch; across the second a further pair of roots crosses. Between "
    "√8/ω_{c} and √24/ω_{c} the ODE has no boundary. The paper’s Fig 3."
)
_FIG_Z = (
    "Impedance of the slab pair at the interface: modulus over ε and phase of Z(s) on s = 0.2 + iω per transit, left; "
    "relative error of every reduction against the exact Z, right."
)
_FIG_S = (
    "Roots s of steady sliding at log_{10} r = −2.68: the growing slow pair (conjugates left out), in which all models agree, "
    "and the reverberations, at 2π, 4π ... per transit in the exact system. Dashed: where its fast roots accumulate."
)
