"""How well the ledgers must close."""

import numpy as np

from scene.observe.pieces import Array
from validation.report.text import plain
from validation.studies.energy_runs import Ladder
from validation.study import Evidence, Verdict, judge

_CLOSED = 1e-12
_ALLOWANCE = 0.2


def conserves(residual: Array) -> Verdict:
    """The leapfrog, on every grid."""
    worst = float(np.abs(residual).max())
    return Verdict(
        "The leapfrog’s ledger closes to rounding on every grid", Evidence.EXACT, "0", plain(worst, ".0e"), judge(worst < _CLOSED)
    )


def order_verdict(ladder: Ladder, order: float) -> Verdict:
    """The mean order of a family that does not conserve."""
    assert ladder.declared is not None
    return Verdict(
        "Ledgers of the other families close at their order or faster",
        Evidence.EXACT,
        f"{ladder.declared:g} or more",
        f"{order:.2f}",
        judge(order >= ladder.declared - _ALLOWANCE),
        f"`{ladder.model}`",
    )


def closes(name: str, residuals: dict[str, float]) -> Verdict:
    """Families of high degree on one scene."""
    worst = max(residuals, key=lambda model: abs(residuals[model]))
    off = abs(residuals[worst])
    return Verdict(
        "Ledgers of high degree close to rounding",
        Evidence.EXACT,
        "0",
        plain(off, ".0e"),
        judge(off < _CLOSED),
        f"{name}; worst of {', '.join(residuals)}: `{worst}`",
    )
