"""Whether a study's bounds are near what was measured."""

from collections.abc import Iterable

from validation.study import Verdict

ROOMY, ROUNDING = 30.0, 1e-10
"""A limit of more than this many times the measured size lets faults pass. Below `ROUNDING` machines may differ by more."""


def too_roomy(verdicts: Iterable[Verdict]) -> list[str]:
    """Claims whose limit lies more than `ROOMY` times above what was measured, and above rounding."""
    bounds = [(v, v.size, v.limit) for v in verdicts if v.size is not None and v.limit is not None]
    return [f"{v.claim}: {v.ours} ({v.remark}), {v.expected}" for v, size, limit in bounds if limit > max(ROOMY * size, ROUNDING)]
