"""Verdicts that bound a size: an error, a residual, a difference. One rule for all studies; it also reports how tight the bound
is."""

import math
from collections.abc import Iterable

from validation.study import Evidence, Outcome, Verdict, judge
from validation.study.text import plain

ROOMY, ROUNDING = 30.0, 1e-10
"""A limit of more than this many times the measured size lets faults pass. Below `ROUNDING` machines may differ by more."""


def bounded(
    claim: str, evidence: Evidence, size: float, limit: float, remark: str = "", ours: str = "", otherwise: Outcome = Outcome.FAIL
) -> Verdict:
    """PASS if `size` (>= 0) lies below `limit`, else `otherwise`; NaN does not pass. `ours` may say more than the size."""
    outcome = judge(size < limit, otherwise)
    known = size if math.isfinite(size) else None
    return Verdict(claim, evidence, f"below {plain(limit, '.2g')}", ours or plain(size, ".1e"), outcome, remark, known, limit)


def too_roomy(verdicts: Iterable[Verdict]) -> list[str]:
    """Claims whose limit lies more than `ROOMY` times above what was measured, and above rounding."""
    bounds = [(v, v.size, v.limit) for v in verdicts if v.size is not None and v.limit is not None]
    return [f"{v.claim}: {v.ours} ({v.remark}), {v.expected}" for v, size, limit in bounds if limit > max(ROOMY * size, ROUNDING)]
