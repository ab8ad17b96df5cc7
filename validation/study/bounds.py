"""Verdicts that bound a size: an error, a residual, a difference. One rule for all studies."""

import math

from validation.study import Evidence, Outcome, Verdict, judge
from validation.study.text import plain


def bounded(
    claim: str, evidence: Evidence, size: float, limit: float, remark: str = "", ours: str = "", otherwise: Outcome = Outcome.FAIL
) -> Verdict:
    """PASS if `size` (>= 0) lies below `limit`, else `otherwise`. NaN does not pass, nor does an independent witness that agrees
    to the last bit: then a thing was compared with itself. `ours` may say more than the size."""
    outcome = judge(size < limit and not (evidence is Evidence.WITNESS and size == 0.0), otherwise)
    known = size if math.isfinite(size) else None
    return Verdict(claim, evidence, f"below {plain(limit, '.2g')}", ours or plain(size, ".1e"), outcome, remark, known, limit)
