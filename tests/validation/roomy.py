"""Whether a study's bounds are near what was measured."""

from collections.abc import Sequence

from validation.study import Verdict

ROOMY, ROUNDING = 30.0, 1e-10
"""A limit of more than this many times the measured size lets faults pass. Below `ROUNDING` machines may differ by more."""


def too_roomy(verdicts: Sequence[Verdict]) -> list[str]:
    """Claims whose limit lies more than `ROOMY` times above what was measured, and above rounding."""
    counts = [v for v in verdicts if (v.size, v.limit) == (0.0, 1.0)]  # none of so many missed: no limit is nearer
    bounds = [(v, v.size, v.limit) for v in verdicts if v not in counts and v.size is not None and v.limit is not None]
    return [f"{v.claim}: {v.ours} ({v.remark}), {v.expected}" for v, size, limit in bounds if limit > max(ROOMY * size, ROUNDING)]
