"""Predicted errors of the reductions: laws for the onset as r omega_c -> 0, and whether they hold for the cycle."""

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple, TypeAlias

import numpy as np

import slipwave
from reduced.stability import ErrorLaw, critical_round_trip, error_law, friction_slopes, scaled
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from validation.compute.build import build
from validation.compute.settle import settle
from validation.study import (
    ASYMPTOTIC,
    Budget,
    Figure,
    Number,
    Outcome,
    StudyResult,
    Table,
    Verdict,
    claim,
    of_paper,
    stated,
    table,
)
from validation.study.compared import against
from validation.study.drawing import Drawing, style_of, subplots
from validation.study.text import plain

NAME = "error-laws"
QUESTION = "Can the error of a reduction be predicted?"
SCENES = ("paper",)
SECONDS = (5.0, 12.0)

MODELS = ("quasistatic", "quasidynamic", "block8", "block12", "kelvin-voigt", "modal:1", "modal:2", "modal:8")
_CYCLING = ("block8", "block12", "kelvin-voigt", "modal:1", "modal:2")
_BASELINE = ("kelvin-voigt", "block12", "block8")
_SETTLED = 1e-7  # relative, to which cycles of a run agree: the period of each model may be off by so much
_SCALES = 4.0 ** np.arange(2.5, -3.0, -0.5)
_HERE = int(np.argmin(np.abs(_SCALES - 1.0)))
_FINER = _HERE + 2
"""Indices of the paper's own epsilon and of a quarter of it."""

_QUICK, _FULL = (2.0, 0.5), (2.0, 1.0, 0.5, 0.25, 0.125)
_BEYOND = 1.02
_PERCENT = f"{100.0 * (_BEYOND - 1.0):.0f} %"
_PUSH = 2.0
_ROUNDING = 4.0 * np.finfo(float).eps
_TEXT = {
    "quasistatic": "θ²/12",
    "quasidynamic": "θ G_{φ}/(2ω_{c})",
    "block8": "−θ²/24",
    "block12": "θ^{4}/720",
    "kelvin-voigt": "−θ^{4}/480",
}


class OnsetErrors(NamedTuple):
    """Relative error of a model's critical r over theta = r_c omega_c of the exact system, and its law."""

    theta: Array
    error: Array
    law: ErrorLaw

    def ratio(self, index: int) -> float:
        """Measured over predicted."""
        return float(self.error[index] / self.law.at(float(self.theta[index])))


class CycleErrors(NamedTuple):
    """The orbit 2 % beyond the exact onset: theta = r omega_c, exact v_max r, every model's relative error of the period, and the
    accuracy of each."""

    theta: float
    swiftness: float
    errors: dict[str, float]
    known: dict[str, float]


Onsets: TypeAlias = dict[str, OnsetErrors]


def run(budget: Budget) -> StudyResult:
    """Measure the errors of the onset and of the period while epsilon, and with it r, falls."""
    paper = slipwave.read("paper")
    onsets = measure_onsets(paper)
    scales = _QUICK if budget.quick else _FULL
    cycles = [measure_cycle(paper, scale) for scale in budget.each(scales)]
    here, half = {model: float(onset.error[_HERE]) for model, onset in onsets.items()}, cycles[scales.index(0.5)]
    cycle_verdict = _cycle_verdict(cycles)
    return StudyResult(
        answer=_answer(onsets, cycles, cycle_verdict.outcome is Outcome.PASS),
        figures=(Figure("fall", _CAPTION, lambda: fall(onsets, cycles)),),
        tables=(_onset_table(onsets), _cycle_table(cycles)),
        verdicts=(*_onset_verdicts(onsets), cycle_verdict),
        notes=(_why(onsets, cycles),),
        # the rounding of the ratio of two critical r moves a relative error of r_c
        numbers={f"error of r_c, {model}": Number(error, 1e-6 + _ROUNDING / abs(error)) for model, error in here.items()}
        | {f"error of T at ε/2, {model}": stated(half.errors[model], half.known[model]) for model in _BASELINE},
    )


def _answer(onsets: Onsets, cycles: list[CycleErrors], falls: bool) -> str:
    """`falls`: whether the error of the cycle falls with r, as that of the onset does."""
    off = max(abs(onset.ratio(_FINER) - 1.0) for model, onset in onsets.items() if model != "quasidynamic")
    errors = [100.0 * abs(cycle.errors["kelvin-voigt"]) for cycle in cycles]
    return (
        "For the onset of stick-slip, yes: the first term that a reduction’s impedance lacks predicts the error of r_{c}, to "
        f"{plain(off, '.0e')} of that error at a quarter of the paper’s ε. For the cycle, {'yes' if falls else 'no'}: the period "
        f"of the paper’s ODE is {min(errors):.1f} to {max(errors):.1f} % off at the r tried, down to θ = {cycles[-1].theta:.3f}."
    )


def measure_onsets(paper: Scene) -> Onsets:
    """Every reduction's error of the critical r over a range of epsilon."""
    slopes = friction_slopes(paper.law, paper.velocity)
    scenes = [scaled(paper, epsilon=float(scale)) for scale in _SCALES]
    exact = [critical_round_trip(scene) for scene in scenes]
    theta = np.array([r * omega for r, omega in exact])
    result = {}
    for model in MODELS:
        error = [critical_round_trip(scene, model)[0] / r - 1.0 for scene, (r, _) in zip(scenes, exact, strict=True)]
        result[model] = OnsetErrors(theta, np.array(error), error_law(model, slopes))
    return result


def measure_cycle(paper: Scene, scale: float) -> CycleErrors:
    """Settle the delay system and the reductions 2 % beyond the exact onset of the scene with epsilon scaled."""
    softer = scaled(paper, epsilon=scale)
    r_c, omega = critical_round_trip(softer)
    scene = scaled(softer, round_trip=_BEYOND * r_c / softer.transit)
    scene = replace(scene, start=replace(scene.start, size=_PUSH))
    theta = scene.transit * omega
    orbits = {
        model: settle(build(model, scene, tolerance=1e-9), tolerance=_SETTLED, most=600.0 / theta).orbit
        for model in ("delay", *_CYCLING)
    }
    exact = orbits["delay"]
    errors = {model: orbits[model].period.value / exact.period.value - 1.0 for model in _CYCLING}
    known = {model: 2.0 * _SETTLED + against(orbits[model].period, exact.period).standard_error for model in _CYCLING}
    return CycleErrors(theta, exact.v_max.value * scene.transit, errors, known)


def _onset_table(onsets: Onsets) -> Table:
    theta = next(iter(onsets.values())).theta
    law = {model: _TEXT.get(model, "θ^{4} Σ_{k>N} 2/(2πk)^{4}") for model in onsets}
    rows = (
        (f"`{model}`", law[model], float(onset.error[_HERE]), onset.ratio(_HERE), onset.ratio(_FINER))
        for model, onset in onsets.items()
    )
    caption = (
        f"Relative error of the critical r, at the paper’s ε (θ = r_{{c}} ω_{{c}} = {theta[_HERE]:.4f} radians per transit), the "
        f"law that the impedance predicts, and measured over predicted there and at a quarter of ε (θ = {theta[_FINER]:.4f})."
    )
    return table("onset", caption, "model | law | measured .4e | ratio [at ε] .6f | ratio [at ε/4] .6f", rows)


def _cycle_table(cycles: list[CycleErrors]) -> Table:
    rows = ((cycle.theta, cycle.swiftness, *(cycle.errors[model] for model in _CYCLING)) for cycle in cycles)
    caption = (
        f"Relative error of the period against the delay system, {_PERCENT} beyond the exact onset, while ε and with it r fall "
        "at fixed V. v_{max} r: how often friction’s state renews itself, at the fastest slip, during one transit of a wave."
    )
    heading = " | ".join(["θ = r ω_{c} .4f", "v_{max} r .3f", *(f"`{model}` .2e" for model in _CYCLING)])
    return table("period", caption, heading, rows)


def _onset_verdicts(onsets: Onsets) -> Iterator[Verdict]:
    for model, onset in onsets.items():
        title, ratio = f"{model}: error of r_{{c}} follows {_TEXT.get(model, 'its θ^{4} law')}", onset.ratio(_FINER)
        remark = f"shown: measured over law at θ = {onset.theta[_FINER]:.3f}; its distance from 1 is the next term"
        yield claim(title, ASYMPTOTIC, ratio, _next_term(model, onset), remark, f"{ratio:.5f}", near=1.0)


def _next_term(model: str, onset: OnsetErrors) -> float:
    """Twice the next term, as it shows at the paper's epsilon: from there it falls as theta^2, or theta for the one odd law. What
    a wrong factor leaves does not fall. And the rounding of the ratio of two critical r adds to the error."""
    here, theta = (float(onset.theta[index]) for index in (_HERE, _FINER))
    fall = (theta / here) ** (1 if model == "quasidynamic" else 2)
    return 2.0 * fall * abs(onset.ratio(_HERE) - 1.0) + _ROUNDING / abs(onset.law.at(theta))


def _cycle_verdict(cycles: list[CycleErrors]) -> Verdict:
    first, last = cycles[0], cycles[-1]
    shrink = abs(last.errors["kelvin-voigt"] / first.errors["kelvin-voigt"])
    most = 0.5 * last.theta / first.theta
    return of_paper(
        "The paper’s ODE tends to the exact system as r → 0: in the period of the cycle",
        f"error falls to {most:.3f} of itself, half as fast as θ",
        f"{shrink:.3f}, {plain(first.errors['kelvin-voigt'], '.1e')} → {plain(last.errors['kelvin-voigt'], '.1e')}",
        shrink < most,
        f"θ from {first.theta:.3f} to {last.theta:.3f}; "
        f"v_{{max}} r stays near {last.swiftness:.1f}: during an event the expansion in r has no small parameter",
        evidence=ASYMPTOTIC,
    ).with_margin(shrink, most)


def _why(onsets: Onsets, cycles: list[CycleErrors]) -> str:
    """Text on why the error of the cycle remains, and at how many r the quasi-dynamic model has no cycle."""
    late = onsets["quasidynamic"]
    beyond = [float(np.interp(cycle.theta / _BEYOND, late.theta[::-1], late.error[::-1])) for cycle in cycles]
    steady = sum(error > _BEYOND - 1.0 for error in beyond)
    return (
        "Why the error of the period does not fall: friction sets the stress drop, which grows slowly; an event slips at about "
        "v_{max} ~ Δμ/ε; and r_{c} ~ ε/(b − a). So v_{max} r ~ Δμ/(b − a) for every ε. The quasi-dynamic model slides steadily "
        f"at {steady} of the {len(cycles)} r tried: its onset lies above."
    )


_CAPTION = (
    "Relative error over θ = r ω_{c}: of the critical r with the laws as lines, left; of the period "
    f"{_PERCENT} beyond the onset, right. Left, errors fall as the laws say; right, they do not fall."
)


def fall(onsets: Onsets, cycles: list[CycleErrors]) -> Drawing:
    """Log-log errors: onset, left, and period of the cycle, right, over theta = r omega_c."""
    figure, (left, right) = subplots(3.9, 1, 2, r"$\theta=r\,\omega_c$ (radians per transit)", "relative error", sharey=True)
    for model, onset in onsets.items():
        style = style_of(model)
        line = np.abs([onset.law.at(float(theta)) for theta in onset.theta])
        left.loglog(onset.theta, line, color=style.color, linewidth=0.8)
        left.loglog(onset.theta, np.abs(onset.error), style.marker, color=style.color, markersize=4.5, label=style.label)
    theta = [cycle.theta for cycle in cycles]
    for model in cycles[0].errors:
        style = style_of(model)
        errors = np.abs([cycle.errors[model] for cycle in cycles])
        right.loglog(theta, errors, style.marker, color=style.color, linestyle=style.dashes, linewidth=1.0, markersize=5)
    left.set(ylim=(1e-12, 2.0), title="onset: critical $r$")
    right.set(title="cycle: period", xlim=left.get_xlim())
    figure.legend(*left.get_legend_handles_labels(), loc="outside upper left", ncols=4, handletextpad=0.4)
    return figure
