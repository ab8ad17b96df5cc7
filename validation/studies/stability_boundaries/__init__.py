"""Where steady sliding loses stability, in the exact system and in every reduction of it: the paper's Figs 2 and 3 and beyond."""

import math
from collections.abc import Mapping, Sequence

import numpy as np

import slipwave
from reduced.impedance import impedance
from reduced.parameters import with_parameter
from reduced.stability import Boundary, FrictionSlopes, Stability, analyse, boundary, critical_round_trip, friction_slopes
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from validation.studies.stability_boundaries import measured
from validation.studies.stability_boundaries.measured import TRACED, Curves
from validation.study import Budget, Figure, Number, StudyResult, Table, table
from validation.study.drawing import WIDTH, Drawing, canvas, line, pen, subplots
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
    curves = measured.critical_over_velocity(paper, np.geomspace(1.0, 1e4, 25 if budget.quick else 81))
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
                lambda: critical_curves(curves.velocity, curves.delay, curves.kelvin_voigt),
                paper="Fig 2",
                carries=("P1 ", "P2 ", "Fig 2"),
            ),
            Figure("planes", _FIG_3, lambda: planes(traced, slopes, paper), paper="Fig 3", carries=("Fig 3",)),
            Figure("impedance", _FIG_Z, lambda: impedances(paper)),
            Figure("spectrum", _FIG_S, lambda: spectra(spectrum, paper.transit)),
        ),
        tables=(velocity_table(curves), model_table(onsets), scene_table(found)),
        verdicts=(
            *measured.closed_form_verdicts(paper, curves),
            *measured.fig_2(curves),
            *measured.fig_3(traced, slopes, paper),
            measured.thin_slabs(slopes),
            measured.crossed(paper, onsets, found),
            measured.taylor(paper),
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


def velocity_table(curves: Curves) -> Table:
    """Critical r at five velocities."""
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


def scene_table(found: dict[str, Stability]) -> Table:
    """Exact stability of one scene per row."""
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


def critical_curves(velocity: Array, delay: Array, kelvin_voigt: Array) -> Drawing:
    """The paper's Fig 2: r_c over V, and the relative error of the Kelvin-Voigt system's."""
    figure, (left, right) = subplots(3.1, 1, 2, "$V/V^*$", "$r_c$")
    for model, values in (("delay", delay), ("kelvin-voigt", kelvin_voigt)):
        left.loglog(velocity, values, **line(model, linestyle="-" if model == "delay" else (0, (5, 2))))
    left.legend()
    right.loglog(velocity, np.abs(kelvin_voigt / delay - 1.0), color=pen("kelvin-voigt").color)
    right.set_ylabel("relative error of $r_c$")
    right.axhline(0.1, color="#b5b5b0", linewidth=0.8, linestyle=(0, (2, 2)))
    right.text(1.3, 0.12, "10 %", color="#6b6b66")
    return figure


def planes(traced: Mapping[str, Sequence[Boundary]], slopes: FrictionSlopes, paper: Scene) -> Drawing:
    """The paper's Fig 3: both systems' boundaries, traced (marks) and in closed form (lines)."""
    figure, axes = subplots(4.0, 1, 1, "$r$", r"$\epsilon$")
    r = np.geomspace(10**-3.2, 10**-0.75, 4000)
    for model, function in TRACED.items():
        style = pen(model)
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


def spectra(found: Mapping[str, Stability], transit: float) -> Drawing:
    """Leading roots of several models in the upper half of the complex plane, per transit."""
    figure, axes = subplots(3.2, 1, 1, "Re $s$ (per transit)", "Im $s$ (per transit)")
    for size, (model, stability) in zip((7.0, 7.0, 10.0, 9.0, 12.0), found.items(), strict=True):
        style = pen(model)
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
