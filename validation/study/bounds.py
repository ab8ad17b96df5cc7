"""Verdicts that bound a size: an error, a residual, a difference. One rule for all studies."""

import math

from validation.study import Evidence, Outcome, Verdict, judge
from validation.study.text import plain


def bounded(
    claim: str, evidence: Evidence, size: float, limit: float, remark: str = "", ours: str = "", otherwise: Outcome = Outcome.FAIL
) -> Verdict:
    """PASS if `size` (>= 0) lies below `limit`, else `otherwise`; NaN does not pass. `ours` may say more than the size."""
    outcome = judge(size < limit, otherwise)
    known = size if math.isfinite(size) else None
    return Verdict(claim, evidence, f"below {plain(limit, '.2g')}", ours or plain(size, ".1e"), outcome, remark, known, limit)
