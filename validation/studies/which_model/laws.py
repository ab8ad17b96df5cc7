"""Whether a reduction's error can be predicted: laws for the onset as r omega_c -> 0, and whether they hold for the cycle."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple, TypeAlias

import numpy as np

import slipwave
from reduced.stability import ErrorLaw, critical_round_trip, error_law, friction_slopes, scaled
from validation.chart import Chart, Panel, Scale, Trace
from validation.chart.looks import model_line, model_marks, style_of
from validation.measure import memo
from validation.report import ASYMPTOTIC, Number, Outcome, Verdict, Verdicts, claim, holding, plain, stated
from validation.report.compared import against
from validation.report.model_table import Compared

MODELS = ("quasistatic", "quasidynamic", "block8", "block12", "kelvin-voigt", "modal:1", "modal:2", "modal:8")
_CYCLING = ("block8", "block12", "kelvin-voigt", "modal:1", "modal:2")
_SETTLED = 1e-7  # relative, to which cycles of a run agree: the period of each model may be off by so much
_SCALES = 4.0 ** np.arange(2.5, -3.0, -0.5)
_HERE = int(np.argmin(np.abs(_SCALES - 1.0)))
_FINER = _HERE + 2  # indices of the paper's own epsilon and of a quarter of it

HALF = 0.5
_BEYOND, _PUSH = 1.02, 2.0
_ROUNDING = 4.0 * np.finfo(float).eps
_TEXT = {
    "quasistatic": "θ²/12",
    "quasidynamic": "θ G_{φ}/(2ω_{c})",
    "block8": "−θ²/24",
    "block12": "θ^{4}/720",
    "kelvin-voigt": "−θ^{4}/480",
}


class _OnsetErrors(NamedTuple):
    """Relative error of a model's critical r over theta = r_c omega_c of the exact system, and its law."""

    theta: np.ndarray
    error: np.ndarray
    law: ErrorLaw

    def ratio(self, index: int) -> float:
        """Measured over predicted."""
        return float(self.error[index] / self.law.at(float(self.theta[index])))


class _CycleErrors(NamedTuple):
    """The orbit 2 % beyond the exact onset with epsilon scaled: theta = r omega_c, exact v_max r, every model's period
    against the exact one."""

    scale: float
    theta: float
    swiftness: float
    periods: dict[str, Compared]

    def error(self, model: str = "kelvin-voigt") -> float:
        """Relative error of the model's period."""
        return self.periods[model].error or 0.0


Onsets: TypeAlias = dict[str, _OnsetErrors]


def measure_onsets(paper: slipwave.Scene) -> Onsets:
    """Every reduction's error of the critical r over a range of epsilon."""
    slopes = friction_slopes(paper.law, paper.velocity)
    scenes = [scaled(paper, epsilon=float(scale)) for scale in _SCALES]
    exact = [critical_round_trip(scene) for scene in scenes]
    theta = np.array([r * omega for r, omega in exact])
    errors = {
        model: [critical_round_trip(scene, model)[0] / r - 1.0 for scene, (r, _) in zip(scenes, exact, strict=True)]
        for model in MODELS
    }
    return {model: _OnsetErrors(theta, np.array(error), error_law(model, slopes)) for model, error in errors.items()}


def measure_cycle(paper: slipwave.Scene, scale: float) -> _CycleErrors:
    """Settle the delay system and the reductions 2 % beyond the exact onset of the scene with epsilon scaled."""
    softer = scaled(paper, epsilon=float(scale))
    r_c, omega = critical_round_trip(softer)
    scene = scaled(softer, round_trip=_BEYOND * r_c / softer.transit)
    scene = replace(scene, start=replace(scene.start, size=_PUSH))
    theta = scene.transit * omega
    exact, *orbits = (memo.settled(model, scene, 1e-9, _SETTLED, 600.0 / theta).orbit for model in ("delay", *_CYCLING))
    periods = {model: against(orbit.period, exact.period) for model, orbit in zip(_CYCLING, orbits, strict=True)}
    known = {model: replace(period, standard_error=2.0 * _SETTLED + period.standard_error) for model, period in periods.items()}
    return _CycleErrors(scale, theta, exact.v_max.value * scene.transit, known)


def law_verdicts(onsets: Onsets, cycles: Sequence[_CycleErrors]) -> Verdicts:
    """On the onset one case for each model, and that on the cycle. Twice the next term of a law is allowed, as it shows at the
    paper's epsilon. From there it falls as theta^2, or theta for the one odd law; what a wrong factor leaves does not fall.
    Rounding of a ratio of critical r adds."""
    for model, onset in onsets.items():
        here, theta = (onset.theta[index] for index in (_HERE, _FINER))
        fall = (theta / here) ** (1 if model == "quasidynamic" else 2)
        allowed = 2.0 * fall * abs(onset.ratio(_HERE) - 1.0) + _ROUNDING / abs(onset.law.at(theta))
        title, ratio = "A reduction’s error of r_{c} follows the law of its impedance", onset.ratio(_FINER)
        law = _TEXT.get(model, "θ^{4} Σ_{k>N} 2/(2πk)^{4}")
        remark = f"`{model}`: measured over {law} at θ = {theta:.3f}; the next term is allowed"
        yield claim(title, ASYMPTOTIC, ratio, allowed, remark, f"{ratio:.5f}", near=1.0)
    yield from [_cycle_verdict(cycles)] if cycles else []


def _cycle_verdict(cycles: Sequence[_CycleErrors]) -> Verdict:
    """Whether the period of the paper's ODE tends to the exact one."""
    first, last = cycles[0], cycles[-1]
    shrink, most = abs(last.error() / first.error()), 0.5 * last.theta / first.theta
    return holding(
        "The paper’s ODE tends to the exact system as r → 0: in the period of the cycle",
        ASYMPTOTIC,
        f"error falls to {most:.3f} of itself, half as fast as θ",
        f"{shrink:.3f}, {plain(first.error(), '.1e')} → {plain(last.error(), '.1e')}",
        shrink < most,
        f"θ from {first.theta:.3f} to {last.theta:.3f}; v_{{max}} r stays near {last.swiftness:.1f}: friction sets the drop, "
        "v_{max} ~ Δμ/ε and r_{c} ~ ε/(b − a), so that during an event the expansion in r has no small parameter",
        otherwise=Outcome.FINDING,
    ).with_margin(shrink, most)


def law_numbers(cycles: Sequence[_CycleErrors]) -> dict[str, Number]:
    """Errors of the period at half of the paper's epsilon."""
    (half,) = (cycle.periods for cycle in cycles if cycle.scale == HALF)
    return {
        f"error of T at ε/2, {model}": stated(half[model].error or 0.0, half[model].standard_error)
        for model in ("kelvin-voigt", "block12", "block8")
    }


def law_answer(onsets: Onsets, cycles: Sequence[_CycleErrors]) -> str:
    """Whether the error can be predicted."""
    off = max(abs(onset.ratio(_FINER) - 1.0) for model, onset in onsets.items() if model != "quasidynamic")
    errors = [100.0 * abs(cycle.error()) for cycle in cycles]
    return (
        "The error of the onset can be predicted: the first term that a reduction’s impedance lacks gives it, to "
        f"{plain(off, '.0e')} of itself at a quarter of the paper’s ε. Of the cycle it says nothing: the "
        f"period of the paper’s ODE is {min(errors):.1f} to {max(errors):.1f} % off, down to θ = {cycles[-1].theta:.3f}."
    )


CAPTION = (
    f"Relative error over θ = r ω_{{c}}: left, of the critical r, with the laws as lines; right, of the period "
    f"{100.0 * (_BEYOND - 1.0):.0f} % beyond the onset, while ε and with it r fall at fixed V."
)


def fall(onsets: Onsets, cycles: Sequence[_CycleErrors]) -> Chart:
    """Errors of the onset, left, and of the period of the cycle, right, over theta = r omega_c."""
    left, right, theta = list[Trace](), list[Trace](), [cycle.theta for cycle in cycles]
    for model, onset in onsets.items():
        laws = [abs(onset.law.at(theta)) for theta in onset.theta]
        left += [model_line(model, onset.theta, laws, f"law of {model}", dashes="-", width=0.8)]
        left += [Trace(model, onset.theta, np.abs(onset.error), model_marks(model, size=4.5))]
        if model in _CYCLING:
            errors = [abs(cycle.error(model)) for cycle in cycles]
            right += [model_line(model, theta, errors, marker=style_of(model).marker, width=1.0)]
    scales = Scale(r"$\theta=r\,\omega_c$ (radians per transit)", "log"), Scale("relative error", "log", (1e-12, 2.0))
    panels = Panel("onset: critical $r$", *scales, left), Panel("cycle: period", *scales, right)
    return Chart(panels, 3.9, 2, share=("all", "all"), legend="outside upper left", legend_columns=4, keys=left[1::2])
