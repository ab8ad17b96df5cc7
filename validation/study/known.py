"""Claims that several studies judge: periods that other programs know, the order of periods, the error of (27)."""

import math
from collections.abc import Mapping

from validation.references.published import half_digit, reference_orbit
from validation.study import Evidence, Verdict, of_paper
from validation.study.bounds import bounded
from validation.study.text import places

_VERY_SMALL, _ORDER_OF_TEN_PER_CENT = 1e-2, (0.1 / math.sqrt(10.0), 0.1 * math.sqrt(10.0))


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


def error_of_27(prefix: str, slow: float, fast: float) -> tuple[Verdict, Verdict]:
    """The claim of Fig 2, for every study that checks it: the largest error up to V = 10^3, and that at V = 10^4."""
    low, high = _ORDER_OF_TEN_PER_CENT
    return (
        bounded(
            f"{prefix} the error of (27) is very small for V < 10^{{3}}",
            Evidence.PAPER,
            slow,
            _VERY_SMALL,
            "read as: below a tenth of the error that is claimed for V = 10^{4}",
        ),
        of_paper(
            f"{prefix} it grows to the order of 10 % at V = 10^{{4}}",
            f"{100 * low:.1f} to {100 * high:.1f} %",
            f"{100 * fast:.1f} %",
            low < fast < high,
            "read as: nearer to 10 % than to 1 % or 100 %, on a logarithmic scale",
        ),
    )
