"""Means of motions that never repeat: a record of runs so long that their errors are small beside the 1 % that they judge. A
report reads it and computes a few again; `python -m tests.verification.means` makes it."""

import json
import math
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path

from pydantic import TypeAdapter

from validation.measure.regimes import TOLERANCE, Regime
from validation.references import published
from validation.report import SELF, Verdict, claim, every
from validation.report.advice import JUDGED
from validation.report.known import ERRORS
from validation.report.text import places

RECORD = Path(published.__file__).with_name("means.json")
_AGAIN = (-2.65, -2.5)
"""log10 r at which motions of the paper's scene are computed again. On a torus they stay near each other, so that means repeat;
an irregular motion differs between processors, so that its mean repeats within its error."""
_SHORT = 10000.0  # transits


@cache
def recorded() -> dict[str, dict[str, Regime]]:
    """The motions on record: model -> scene and options, as in a command -> motion."""
    return TypeAdapter(dict[str, dict[str, Regime]]).validate_python(json.loads(RECORD.read_bytes())["means"])


def on_record(model: str, settings: str) -> Regime | None:
    """The motion of a model, given its scene and options."""
    return recorded().get(model, {}).get(settings)


def paper_at(log10_r: float) -> str:
    """The words that give the paper's scene at an r in a command."""
    return f"paper --set slab.log10_r={log10_r:g}"


def record_verdicts(again: Callable[[str, float, float], Regime]) -> Iterator[Verdict]:
    """Whether the present code, `again` (model, log10 r, transits), has the means on record."""
    found = [(model, x, by_scene.get(paper_at(x))) for model, by_scene in recorded().items() for x in _AGAIN]
    repeated = []
    for model, x, one in ((model, x, one) for model, x, one in found if one and one.cycles):
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
