"""Periods of a study against those that other programs know."""

from collections.abc import Mapping

from validation.references.published import half_digit, reference_orbit
from validation.study import Evidence, Verdict
from validation.study.bounds import bounded
from validation.study.text import places


def as_known(periods: Mapping[str, float], log10_r: float, error: float) -> Verdict:
    """By model: half of the last digit known and `error`, relative, are allowed; the worst beside that is shown."""
    known = {model: value for model in periods if (value := reference_orbit(model, log10_r).get("period"))}
    off = {model: abs(periods[model] / value - 1.0) for model, value in known.items()}
    allowed = {model: half_digit(value) / value + error for model, value in known.items()}
    worst = max(known, key=lambda model: off[model] / allowed[model])
    return bounded(
        "Periods are those of other programs",
        Evidence.WITNESS,
        off[worst],
        allowed[worst],
        f"{', '.join(f'`{model}`' for model in known)} at log_{{10}} r = {places([log10_r])}; shown: `{worst}`",
    )
