"""Every reduction's orbit against the delay system's as the waves gain in weight (r grows); its means where none is stable."""

from validation.studies.model_error.runs import (
    DAMPED,
    MODELS,
    SHOWN,
    TIMED,
    TIMED_AT,
    Runs,
    error,
    mean_at,
    milliseconds_of,
    orbit_of,
)
from validation.studies.model_error.shown import error_table, errors_of_means, errors_over_r, mean_table, omissions
from validation.studies.model_error.verdicts import RUN_AT, TARGETS, all_verdicts
from validation.study import Budget, Figure, Number, StudyResult
from validation.study.over_r import scene_at
from validation.study.text import places, plain
from validation.timing import Setting, warm_up

NAME = "model-error"
QUESTION = "How wrong is each reduction, from the onset to where its motion is irregular, and what does a smaller error cost?"
SCENES = ("paper",)
SECONDS = (6.0, 22.0)

_FEW = (DAMPED, "fitted:4")
_OWN = 3e-9  # relative error of a figure, at most
_ORBITS = {
    True: (-2.699, -2.69, -2.68, -2.66),
    False: (-2.699, -2.6975, -2.695, -2.69, -2.685, -2.68, -2.675, -2.67, -2.665, -2.66),
}
"""By quick or full report: log10 r from the onset, -2.69955, to where the delay system's orbit loses stability, -2.6575."""

_MEANS = {True: (-2.65,), False: (-2.65, -2.6, -2.55, -2.5, -2.4, -2.3)}
_UNTIL = {True: 6000.0, False: 10000.0}


def run(budget: Budget) -> StudyResult:
    """Every model's orbits and means, and the time of a run."""
    grid, orbits, means, times = _ORBITS[budget.quick], Runs(), Runs(), dict[str, float]()
    for model in budget.each(("delay", *MODELS, *_FEW)):
        warm_up(Setting(model), scene_at(-2.68))
        times[model] = milliseconds_of(model)
        orbits[model] = {log10_r: orbit_of(model, log10_r) for log10_r in (SHOWN if model in _FEW else grid)}
        if model not in _FEW:
            means[model] = {log10_r: mean_at(model, log10_r, _UNTIL[budget.quick]) for log10_r in _MEANS[budget.quick]}
    means[DAMPED] = {log10_r: orbit_of(DAMPED, log10_r) for log10_r in sorted({*_MEANS[budget.quick], RUN_AT})}
    return StudyResult(
        answer=_answer(orbits, means),
        figures=(
            Figure("errors", _CAPTION, lambda: errors_over_r(orbits)),
            Figure("deep", _DEEP_CAPTION, lambda: errors_of_means(means)),
        ),
        tables=(error_table(orbits, times), mean_table(means)),
        verdicts=all_verdicts(orbits, means),
        notes=(_note(times),),
        numbers={
            f"{model} error of {symbol} at {log10_r}": _number(error(orbits, model, log10_r, name).value)
            for model in MODELS
            for log10_r in SHOWN
            for symbol, name in (("T", "period"), ("drop", "drop"))
        }
        | {f"{DAMPED} T at {x}": Number(found.period.value, 1e-8) for x, found in means[DAMPED].items() if found},
        omissions=omissions(orbits),
    )


def _number(error: float) -> Number:
    """A model's error for the baseline: the smaller it is, the more of it is the computation's own."""
    return Number(error, max(1e-5, _OWN / abs(error)))


def _answer(orbits: Runs, means: Runs) -> str:
    errors = {
        model: plain(abs(error(orbits, model, -2.68, "period").value), ".0e") for model in ("kelvin-voigt", *TARGETS, "modal:8")
    }
    last = max(means["delay"])
    ode, eight, damped = (error(means, model, last, "period") for model in ("kelvin-voigt", "modal:8", DAMPED))
    return (
        f"At log_{{10}} r = −2.68 the paper’s ODE misses the period by {errors['kelvin-voigt']}, one exact mode of the slabs "
        f"(one state more) by {errors['modal:1']}, two by {errors['modal:2']}, eight by {errors['modal:8']}. At −{-last:g}, "
        f"where no orbit of the exact system is stable, the mean period is off by {_percent(ode.value)} in the ODE, by "
        f"{_percent(eight.value)} ± {_percent(2.0 * eight.error)} with eight modes, and by {_percent(damped.value)} "
        "in the quasi-dynamic model."
    )


def _percent(value: float) -> str:
    return f"{100 * value:.2g} %".replace("-", "−")


def _note(times: dict[str, float]) -> str:
    listed = ", ".join(f"{times[model]:.0f} ms with `{model}`" for model in ("delay", "modal:1", "modal:8"))
    where = f"{TIMED:.0f} transits at log_{{10}} r = {places([TIMED_AT])}"
    return f"{where} take {listed}: steps follow slip events, not the number of states."


_CAPTION = (
    "Relative error of period T (left) and stress drop Δμ (right) of each reduction’s orbit against the delay system’s, by "
    "Newton’s method, over r from the onset to where the exact orbit loses stability. A dip is a change of sign."
)
_DEEP_CAPTION = (
    "The same beyond, where no orbit of the delay system is stable: signed differences of the means of T and Δμ over the "
    "cycles of a long run. Bars: two standard errors, which allow for the dependence of a cycle on those before it."
)
