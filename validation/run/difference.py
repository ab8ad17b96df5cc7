"""How far the means of a run are from those of the reference: an error if both motions are periodic, else a difference with a
margin, because motions that never repeat agree only in their statistics."""

import math
from typing import NamedTuple

from validation.run.simulate import Run


class Difference(NamedTuple):
    """Relative to the reference's mean. `margin`: half the width of its 95 % interval, 0 if both motions are periodic, NaN if
    there are too few cycles to tell."""

    value: float
    margin: float


def is_error(run: Run, reference: Run) -> bool:
    """Whether differences between the two are errors of the model."""
    return run.kind == reference.kind == "periodic"


def differences(run: Run, reference: Run) -> dict[str, Difference]:
    """Those of the mean period and stress drop; NaN where a run has none, or failed. A run does not differ from itself."""
    found = {}
    for name, value in run.errors(reference).items():
        parts = [_share(one, name) for one in (run, reference)]
        found[name] = Difference(value, 0.0 if run is reference else (1.0 + value) * math.hypot(*parts))
    return found


def _share(run: Run, name: str) -> float:
    """The margin of a mean over the mean; 0 if the motion is periodic."""
    if run.kind == "periodic":
        return 0.0
    return float(getattr(run.statistics.margins, name)) / float(getattr(run.statistics, name).mean)


def in_json(run: Run, reference: Run) -> dict[str, dict[str, float | None]]:
    """`error` by name, None where the difference is none; for motions that never repeat `difference` and its `margin`."""
    found = differences(run, reference)
    if is_error(run, reference):
        return {"error": {name: one.value for name, one in found.items()}}
    known = {name: one for name, one in found.items() if not math.isnan(one.value)}
    nothing: dict[str, dict[str, float | None]] = {"error": dict.fromkeys(found)}
    if not known:
        return nothing
    return nothing | {
        "difference": {name: one.value for name, one in known.items()},
        "margin": {name: one.margin for name, one in known.items()},
    }
