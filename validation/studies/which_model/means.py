"""Means of motions that never repeat: of runs so long that their errors are small beside the 1 % that they judge
(`validation.measure.on_record`). A report computes a few again."""

import math
from collections.abc import Callable, Iterator

from validation.measure.on_record import motions
from validation.measure.regimes import TOLERANCE, Regime
from validation.report import SELF, Verdict, claim, every
from validation.report.advice import JUDGED
from validation.report.known import ERRORS
from validation.report.text import places

_AGAIN = (-2.65, -2.5)
"""log10 r at which motions of the paper's scene are computed again. On a torus they stay near each other, so that means repeat;
an irregular motion differs between processors, so that its mean repeats within its error."""
_SHORT = 10000.0  # transits


def paper_at(log10_r: float) -> str:
    """The words that give the paper's scene at an r in a command."""
    return f"paper --set slab.log10_r={log10_r:g}"


def record_verdicts(again: Callable[[str, float, float], Regime]) -> Iterator[Verdict]:
    """Whether the present code, `again` (model, log10 r, transits), has the means on record."""
    places_of = {paper_at(x): x for x in _AGAIN}
    repeated = []
    for model, x, one in ((model, places_of[scene], one) for (model, scene), one in motions().items() if scene in places_of):
        torus = one.words == "torus"
        now = again(model, x, float(one.command.split()[2]) if torus else _SHORT)
        pairs = [(now.figures[symbol], one.figures[symbol]) for symbol in JUDGED if symbol in now.figures]
        off = max((abs(new.value - old.value) / (old.value if torus else new.error) for new, old in pairs), default=math.nan)
        if torus:
            repeated.append(off < 10.0 * TOLERANCE)
        else:
            title, where = "Means on record of irregular motions are those of shorter runs", f"`{model}` at {places([x])}"
            yield claim(title, SELF, off, ERRORS, f"{where}: T and Δμ, {_SHORT:g} transits", unit="standard errors")
    title = f"Means on record repeat on a torus, to {10.0 * TOLERANCE:g} of themselves"
    yield every(title, SELF, sum(repeated), len(repeated), f"at {places([_AGAIN[0]])}", "models")
