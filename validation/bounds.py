"""Verdicts that bound a size: an error, a residual, a difference. One rule for all studies, which also tells how tight it is."""

from collections.abc import Iterable

from validation.report.text import plain
from validation.study import Evidence, Outcome, Verdict, judge

ROOMY = 30.0
"""A limit further above what is measured than this many times lets faults pass."""


def bounded(
    claim: str,
    evidence: Evidence,
    size: float,
    limit: float,
    remark: str = "",
    ours: str = "",
    otherwise: Outcome = Outcome.FAIL,
) -> Verdict:
    """PASS if `size` (>= 0) lies below `limit`, else `otherwise`; NaN does not pass. `ours` may tell more than the size."""
    room = limit / size if size > 0.0 else None
    told = ours or plain(size, ".1e")
    return Verdict(claim, evidence, f"below {plain(limit, '.2g')}", told, judge(size < limit, otherwise), remark, room)


def too_roomy(verdicts: Iterable[Verdict]) -> list[str]:
    """Claims whose limit lies more than `ROOMY` times above what was measured."""
    return [f"{v.claim}: {v.ours} ({v.remark}), {v.expected}" for v in verdicts if v.room and v.room > ROOMY]
