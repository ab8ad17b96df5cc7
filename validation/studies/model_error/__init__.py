"""Every reduction's orbit against the delay system's, as the waves gain in weight (r grows)."""

from validation.studies.model_error.runs import MODELS, SHOWN, Runs, curves, error, orbit_of, scene_at
from validation.studies.model_error.shown import error_table, errors_over_r, omissions
from validation.studies.model_error.verdicts import TARGETS, all_verdicts
from validation.study import Budget, Figure, Number, StudyResult
from validation.study.text import plain
from validation.work_precision import Setting, warm_up

NAME = "model-error"
QUESTION = "How wrong is each reduction's orbit, and what does a smaller error cost?"
SCENES = ("paper",)
SECONDS = (6.0, 22.0)

_RUNS_OWN = 3e-9  # relative error of a settled figure
_QUICK = (-2.69, -2.68, -2.67, -2.66)
_FULL = tuple(round(-2.695 + 0.0025 * step, 4) for step in range(15))


def run(budget: Budget) -> StudyResult:
    """Settle the delay system and every reduction over the range of r in which its orbit is periodic."""
    grid = _QUICK if budget.quick else _FULL
    runs: Runs = {}
    for model in budget.each(("delay", *MODELS, "quasidynamic", "fitted:4")):
        warm_up(Setting(model), scene_at(-2.68))
        few = model in ("quasidynamic", "fitted:4")
        runs[model] = {log10_r: orbit_of(model, log10_r) for log10_r in (SHOWN if few else grid)}
    return StudyResult(
        answer=_answer(runs),
        figures=(Figure("errors", _CAPTION, lambda: errors_over_r(curves(runs))),),
        tables=(error_table(runs),),
        verdicts=all_verdicts(runs),
        notes=(_note(runs),),
        numbers={
            f"{model} error of {symbol} at {log10_r}": _number(error(runs, model, log10_r, name))
            for model in MODELS
            for log10_r in SHOWN
            for symbol, name in (("T", "period"), ("drop", "drop"))
        },
        omissions=omissions(runs),
    )


def _number(error: float) -> Number:
    """A model's error for the baseline: the smaller it is, the more of it is the runs' own."""
    return Number(error, max(1e-5, _RUNS_OWN / abs(error)))


def _answer(runs: Runs) -> str:
    errors = {model: plain(abs(error(runs, model, -2.68, "period")), ".0e") for model in ("kelvin-voigt", *TARGETS, "modal:8")}
    return (
        f"At log_{{10}} r = −2.68 the paper’s ODE misses the period by {errors['kelvin-voigt']}, one exact mode of the slabs "
        f"(one state more) by {errors['modal:1']}, two by {errors['modal:2']}, eight by {errors['modal:8']}."
    )


def _note(runs: Runs) -> str:
    times = {model: orbit.milliseconds for model in ("delay", "modal:1", "modal:8") if (orbit := runs[model][-2.68])}
    listed = ", ".join(f"{milliseconds:.0f} ms with `{model}`" for model, milliseconds in times.items())
    return f"1000 transits at log_{{10}} r = −2.68 take {listed}: steps follow slip events, not the number of states."


_CAPTION = (
    "Relative error of period T (left) and stress drop Δμ (right) of each reduction’s settled orbit against the delay system’s, "
    "over r, from just beyond the onset to where the exact orbit stops being periodic. A dip is a change of sign."
)
