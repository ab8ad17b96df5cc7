"""Where steady sliding loses stability, in the exact system and in every reduction of it: the paper's Figs 2 and 3 and beyond."""

import cmath
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

import slipwave
from reduced import closed_forms
from reduced.impedance import check_passivity, impedance, taylor_poles
from reduced.parameters import scaled, with_parameter
from reduced.stability import Boundary, FrictionSlopes, Stability, analyse, boundary, critical_round_trip, friction_slopes
from reduced.stability.characteristic import characteristic
from reduced.stability.spectrum import follow_root, unstable_count
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from validation.study import Budget, Figure, Number, StudyResult, Table, table
from validation.study.drawing import WIDTH, Drawing, canvas, line, style_of, subplots
from validation.study.text import plain
from validation.study.verdict import ASYMPTOTIC, EXACT, WITNESS, Verdict, claim, every, holding, of_paper

NAME = "stability-boundaries"
QUESTION = "Where does steady sliding give way to stick-slip, and how far off is each reduction there?"
SCENES = ("paper", "rock", "unlike", "unlike-irrational", "grip", "layered", "viscous", "reflection", "slip-law")
SECONDS = (8.0, 10.0)

TRACED = {"delay": closed_forms.delay_epsilon, "kelvin-voigt": closed_forms.kelvin_voigt_epsilon}
"""Models whose boundary is traced, with its closed form."""


class Curves(NamedTuple):
    """Critical r over V (Fig 2): computed from impedance, and closed forms; `gap` the largest relative difference of the two."""

    velocity: Array
    delay: Array
    kelvin_voigt: Array
    gap: float

    @property
    def error(self) -> Array:
        """Relative error of the Kelvin-Voigt system's critical r, (27) against (39)."""
        return self.kelvin_voigt / self.delay - 1.0


_ROUNDING = 2e-14  # relative
_STEP = 1e-6  # log10 r
_THIN, _ON_LINE = 1e-5, 1e-6
_TRACED = 4e-10  # Newton's method ends at steps of about this size squared
_FIRST_TRACED = 2e-3  # at eps = 1e-6 the branch (28) lies 9e-4 beyond its asymptote, relative

_WINDOW = ((-3.2, -0.75), (-6.0, -1.0))
_ONSETS = ("delay", "quasistatic", "quasidynamic", "block8", "block12", "kelvin-voigt", "modal:1", "modal:2", "modal:8")
_SPECTRA = ("delay", "kelvin-voigt", "modal:1", "modal:8", "block12")


def run(budget: Budget) -> StudyResult:
    """Compute the curves, trace the boundaries, compare both with the closed forms."""
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
            Figure(
                "critical-r",
                _FIG_2,
                lambda: _critical_curves(curves.velocity, curves.delay, curves.kelvin_voigt),
                paper="Fig 2",
                carries=("P1 ", "P2 "),
            ),
            Figure("planes", _FIG_3, lambda: boundaries_in_plane(traced, slopes, paper), paper="Fig 3", carries=("Fig 3",)),
            Figure("impedance", _FIG_Z, lambda: impedances(paper)),
            Figure("spectrum", _FIG_S, lambda: _spectra(spectrum, paper.transit)),
        ),
        tables=(_velocity_table(curves), model_table(onsets), _scene_table(found)),
        verdicts=(
            *closed_form_verdicts(paper, curves),
            *fig_3(traced, slopes, paper),
            thin_slabs(slopes),
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
        f"without running it. The paper’s ODE misses the exact r_{{c}} by {plain(abs(here), '.0e')} at V = 100, by "
        f"{plain(below, '.1e')} at V = 10^{{3}} and by {100 * abs(float(curves.error[-1])):.0f} % at V = 10^{{4}}."
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

_MODELS = ("quasistatic", "quasidynamic", "block12", "block8", "kelvin-voigt", "modal:1", "modal:8")
_SHIFT = 0.2


def _velocity_table(curves: Curves) -> Table:
    shown = [int(np.argmin(np.abs(np.log(curves.velocity / v)))) for v in (1.0, 10.0, 100.0, 1e3, 1e4)]
    rows = ((float(column[i]) for column in (curves.velocity, curves.delay, curves.kelvin_voigt, curves.error)) for i in shown)
    heading = "V [V*] .4g | r_{c}, delay (39) [L/V*] .12g | r_{c}, Kelvin–Voigt (27) [L/V*] .12g | relative error .3e"
    return table("critical-r", "Critical round trip over the drive V, the paper’s Fig 2.", heading, rows)


def model_table(onsets: dict[str, tuple[float, float]]) -> Table:
    """Critical r and frequency of every model at the paper's V and epsilon."""
    exact = onsets["delay"][0]
    rows = (
        (f"`{model}`", math.log10(r), r / exact - 1.0 if model != "delay" else None, omega, r * omega)
        for model, (r, omega) in onsets.items()
    )
    heading = "model | log_{10} r_{c} .11f | error of r_{c} [relative] .3e | ω at onset [V*/L] .8f | r_{c} ω [per transit] .8f"
    return table("models", "Onset of stick-slip in every model, V = 100, ε = 2.8 · 10^{-5}.", heading, rows)


def _scene_table(found: dict[str, Stability]) -> Table:
    rows = []
    for name, stability in found.items():
        lead = stability.leading_roots[0]
        root = f"{plain(lead.real, '.5g')} ± {plain(abs(lead.imag), '.6g')} i" if lead.imag else plain(lead.real, ".5g")
        state = "stable" if stability.stable else f"unstable ({stability.unstable_roots})"
        rows.append(
            (f"`{name}`", state, stability.omega_c, stability.log10_r_c, stability.epsilon_c, root, stability.essential_abscissa)
        )
    heading = (
        "scene | steady sliding | ω_{c} [V*/L] .6f | log_{10} r_{c} .8f | ε_{c} .6e | leading root [V*/L] | "
        "fast roots [Re, V*/L] .5g"
    )
    caption = (
        "Exact stability of other arrangements. In brackets: number of growing roots, certified by the argument principle. "
        "r_{c}: the upper slab’s round trip, both scaled together. Fast roots: where the real parts of the infinitely many "
        "fast roots accumulate."
    )
    return table("scenes", caption, heading, rows)


def _critical_curves(velocity: Array, delay: Array, kelvin_voigt: Array) -> Drawing:
    figure, (left, right) = subplots(3.1, 1, 2, "$V/V^*$", "$r_c$")
    for model, values in (("delay", delay), ("kelvin-voigt", kelvin_voigt)):
        left.loglog(velocity, values, **line(model, linestyle="-" if model == "delay" else (0, (5, 2))))
    left.legend()
    right.loglog(velocity, np.abs(kelvin_voigt / delay - 1.0), color=style_of("kelvin-voigt").color)
    right.set_ylabel("relative error of $r_c$")
    right.axhline(0.1, color="#b5b5b0", linewidth=0.8, linestyle=(0, (2, 2)))
    right.text(1.3, 0.12, "10 %", color="#6b6b66")
    return figure


def boundaries_in_plane(traced: Mapping[str, Sequence[Boundary]], slopes: FrictionSlopes, paper: Scene) -> Drawing:
    """The paper's Fig 3: both systems' boundaries, traced (marks) and in closed form (lines)."""
    figure, axes = subplots(4.0, 1, 1, "$r$", r"$\epsilon$")
    r = np.geomspace(10**-3.2, 10**-0.75, 4000)
    for model, function in TRACED.items():
        style = style_of(model)
        values = np.array([function(slopes, x) for x in r])
        values[values <= 0.0] = np.nan
        axes.loglog(r, values, **line(model, linestyle="-", linewidth=1.1))
        for curve in traced[model]:
            axes.plot(10 ** curve.first[::3], 10 ** curve.second[::3], style.marker, color=style.color, markersize=3.5)
    axes.plot(paper.transit, paper.upper.epsilon, "X", color="#d55e00", markersize=8)
    axes.annotate("paper's scene", (paper.transit, paper.upper.epsilon), (9, -12), textcoords="offset points", color="#d55e00")
    for square, name in ((8.0, r"$\sqrt{8}/\omega_c$"), (24.0, r"$\sqrt{24}/\omega_c$")):
        axes.axvline(np.sqrt(square) / slopes.omega_c, color="#b5b5b0", linewidth=0.8, linestyle=(0, (2, 2)))
        axes.text(np.sqrt(square) / slopes.omega_c, 1.6e-6, name, ha="right", rotation=90, va="bottom", color="#6b6b66")
    axes.text(1.0e-3, 2e-3, "steady sliding stable")
    axes.text(6e-3, 4e-6, "unstable")
    axes.set(xlim=(r[0], r[-1]), ylim=(1e-6, 0.1))
    axes.legend(loc="upper left")
    return figure


def impedances(paper: Scene) -> Drawing:
    """|Z| and phase of every model, and the relative error of each reduction."""
    omega = np.geomspace(0.05, 40.0, 1500)
    s = (_SHIFT + 1j * omega) / paper.transit
    exact = impedance(paper, s)
    figure = canvas(WIDTH, 4.6)
    grid = figure.subplot_mosaic([["size", "error"], ["phase", "error"]], width_ratios=(1.15, 1.0))
    for model in ("delay", *_MODELS):
        z = exact if model == "delay" else impedance(paper, s, model)
        grid["size"].plot(omega, np.abs(z) / paper.upper.epsilon, **line(model))
        grid["phase"].plot(omega, np.degrees(np.angle(z)), **line(model))
        if model != "delay":
            grid["error"].plot(omega, np.abs(z / exact - 1.0), **line(model))
    for name, label in (("size", r"$|Z|/\epsilon$"), ("phase", "phase of $Z$ (degrees)"), ("error", r"$|Z/Z_{\rm exact}-1|$")):
        grid[name].set(xscale="log", ylabel=label, xlabel=r"$\omega$ (radians per transit)")
    grid["size"].set(yscale="log", ylim=(0.02, 30.0), xlabel="")
    grid["phase"].set_yticks([-90, 0, 90])
    grid["error"].set(yscale="log", ylim=(1e-8, 20.0))
    handles = [*grid["size"].get_lines()[:1], *grid["error"].get_lines()]
    figure.legend(handles=handles, loc="outside upper left", ncols=4, handlelength=2.8)
    return figure


def _spectra(found: Mapping[str, Stability], transit: float) -> Drawing:
    figure, axes = subplots(3.2, 1, 1, "Re $s$ (per transit)", "Im $s$ (per transit)")
    for size, (model, stability) in zip((7.0, 7.0, 10.0, 9.0, 12.0), found.items(), strict=True):
        style = style_of(model)
        roots = np.array([root for root in stability.leading_roots if root.imag > 0.0]) * transit
        face = style.color if model == "delay" else "none"
        axes.plot(
            roots.real, roots.imag, style.marker, color=style.color, markerfacecolor=face, markersize=size, label=style.label
        )
    axes.axvline(found["delay"].essential_abscissa * transit, color="#6b6b66", linewidth=0.8, linestyle=(0, (4, 2)))
    axes.axvline(0.0, color="#b5b5b0", linewidth=0.8)
    axes.set_ylim(-0.7, 14.0)
    axes.set_yticks([0.0, 2 * np.pi, 4 * np.pi], ["0", r"$2\pi$", r"$4\pi$"])
    axes.legend(loc="center")
    return figure


def critical_over_velocity(paper: Scene, velocities: Array) -> Curves:
    """r_c(V) of the delay and the Kelvin-Voigt system from their impedance, compared with (39) and (27)."""
    forms = {"delay": closed_forms.delay_r, "kelvin-voigt": closed_forms.kelvin_voigt_r}
    every, epsilon = velocities.tolist(), paper.upper.epsilon
    found = [[critical_round_trip(scaled(paper, velocity=v), model)[0] for v in every] for model in forms]
    known = [[closed(friction_slopes(paper.law, v), epsilon) for v in every] for closed in forms.values()]
    delay, kelvin_voigt = np.array(found)
    return Curves(velocities, delay, kelvin_voigt, float(np.abs(np.array(found) / known - 1.0).max()))


def closed_form_verdicts(paper: Scene, curves: Curves) -> Iterator[Verdict]:
    """The closed forms against each other and against roots found from impedance."""
    speeds = (1.0, 10.0, 100.0, 1e3, 1e4)
    every = [_gaps(paper, friction_slopes(paper.law, v), paper.upper.epsilon, v) for v in speeds]
    worst = {name: max(gaps[name] for gaps in every) for name in every[0]}
    for title, gap in (worst | {"r_{c} from impedance alone equals (39) and (27), all V": curves.gap}).items():
        yield claim(title, EXACT, gap, _ROUNDING, "relative, V = 1 to 10^{4}")


def _gaps(paper: Scene, slopes: FrictionSlopes, epsilon: float, velocity: float) -> dict[str, float]:
    r = closed_forms.kelvin_voigt_r(slopes, epsilon)
    cubic, x = closed_forms.kelvin_voigt_cubic(slopes, epsilon), r / closed_forms.quasistatic_r(slopes, epsilon)
    quartic, s = closed_forms.kelvin_voigt_quartic(slopes, epsilon, r), 1j * slopes.omega_c
    at_39 = replace(paper.upper, round_trip=closed_forms.delay_r(slopes, epsilon))
    driven = replace(scaled(paper, velocity=velocity), upper=at_39, lower=at_39)
    off = [float(abs(np.polyval(one, at) / (np.polyval(np.polyder(one), at) * at))) for one, at in ((cubic, x), (quartic, s))]
    return {
        "(27) is the middle root of the cubic (21)": off[0],
        "(27) makes the quartic (18) vanish at i ω_{c}": off[1],
        "at r of (39) the delay system’s own equation has the root i ω_{c}": abs(
            follow_root(characteristic(driven), s * (1.0 + 1e-3j)) / s - 1.0
        ),
    }


def fig_3(traced: dict[str, list[Boundary]], slopes: FrictionSlopes, paper: Scene) -> Iterator[Verdict]:
    """The branches of Fig 3, traced and counted."""
    off = [
        np.abs(10**curve.second / np.array([closed(slopes, 10**x) for x in curve.first]) - 1.0).max()
        for model, closed in TRACED.items()
        for curve in traced[model]
    ]
    delay, ode = (len(traced[model]) for model in TRACED)
    yield claim(
        "Fig 3: boundaries traced in the (r, ε) plane without knowing them lie on (28) and (40)",
        EXACT,
        float(max(off)) if delay == ode == 2 else math.inf,
        _TRACED,
        f"{delay} branches of the delay system, {ode} of the ODE",
    )
    counts = [_on_both_sides(paper, model, curve) for model, curves in traced.items() for curve in curves]
    parted = all(abs(above - below) == 2 for above, below in counts)
    asymptote = math.sqrt(24.0) / slopes.omega_c
    begins = (float(10 ** curve.first.min()) for curve in traced["kelvin-voigt"])
    second = min(begin for begin in begins if begin > 0.5 * asymptote)
    yield of_paper(
        "Fig 3: beyond r = √24/ω_{c} a second pair of roots of the ODE crosses",
        f"from r = {plain(asymptote, '.5g')}",
        f"from r = {plain(second, '.5g')}",
        0.0 <= second / asymptote - 1.0 < _FIRST_TRACED and parted,
        "traced down to ε = 10^{-6}; the certified number of growing roots changes by 2 across every branch: "
        f"{'yes' if parted else 'no'}",
    ).with_margin(abs(second / asymptote - 1.0), _FIRST_TRACED)


def thin_slabs(slopes: FrictionSlopes) -> Verdict:
    """The asymptote that the paper names below (28)."""
    line = -slopes.healing * slopes.steady * _THIN
    off = [abs(closed(slopes, _THIN) / line - 1.0) for closed in TRACED.values()]
    title = "Fig 3: as r → 0 both boundaries approach the quasi-static line ε = −G_{φ} F_{ss}′ r"
    return claim(
        title, ASYMPTOTIC, max(off), _ON_LINE, f"relative distance of (28) and (40) from it at r = {plain(_THIN, '.0e')}"
    )


def _around(scene: Scene, model: str, name: str, value: float, step: float) -> list[int]:
    """The certified counts of growing roots a step below and above a value of a parameter."""
    scenes = (with_parameter(scene, name, value + shift) for shift in (-step, step))
    return [unstable_count(characteristic(one, model)) for one in scenes]


def _on_both_sides(paper: Scene, model: str, curve: Boundary) -> list[int]:
    """The certified counts on both sides of the middle of a boundary."""
    middle = len(curve.first) // 2
    at = with_parameter(paper, "log10_r", float(curve.first[middle]))
    return _around(at, model, "log10_epsilon", float(curve.second[middle]), 1e-3)


def crossed(paper: Scene, onsets: Mapping[str, tuple[float, float]], found: Mapping[str, Stability]) -> Verdict:
    """Verdict: the certified counts of growing roots just below and above every onset, which were not used to locate it."""
    places = {f"`{model}`": (paper, model, math.log10(r)) for model, (r, _) in onsets.items()}
    places |= {name: (slipwave.read(name), "delay", one.log10_r_c) for name, one in found.items() if math.isfinite(one.log10_r_c)}
    counts = {name: _around(scene, model, "log10_r", at, _STEP) for name, (scene, model, at) in places.items()}
    wrong = [name for name, (below, beyond) in counts.items() if beyond - below != 2]
    title, where = "Beyond every onset a pair of roots grows that decays below it", f"certified count {plain(_STEP, '.0e')} in"
    remark = f"{where} log_{{10}} r on both sides" + (f"; not so: {', '.join(wrong)}" if wrong else "")
    return every(title, WITNESS, len(counts) - len(wrong), len(counts), remark, "onsets")


def taylor(paper: Scene) -> Verdict:
    """The next truncation, which has growing roots of its own."""
    pole = max(taylor_poles(), key=lambda value: (value.real, value.imag))
    known = cmath.sqrt(complex(-40.0, math.sqrt(320.0)))  # 1 + s^2/24 + s^4/1920 = 0
    stable_scene = with_parameter(paper, "log10_r", -3.5)
    growing = analyse(stable_scene, "taylor").unstable_roots
    passive = check_passivity(paper, "taylor").passive
    return holding(
        "The next Taylor truncation after the paper’s cannot be used",
        EXACT,
        f"poles at {known.real:.4f} ± {known.imag:.4f} i",
        f"{pole.real:.4f} ± {abs(pole.imag):.4f} i per transit",
        abs(pole / known - 1.0) < _ROUNDING and pole.real > 0.0 and growing == 2 and not passive,
        f"its slab is {'' if passive else 'not '}passive: at r = 10^{{-3.5}}, where sliding is stable, it has {growing} growing "
        "roots of its own",
    ).with_margin(abs(pole / known - 1.0), _ROUNDING)
