"""How well the ledgers must close."""

from collections.abc import Mapping

import numpy as np

from slipwave.observe.pieces import Array
from validation.measure.order_fit import Fit, shortfall
from validation.studies.energy.runs import ENTRIES, EnergyLadder, History
from validation.study import Evidence, Verdict, judge
from validation.study.bounds import bounded

_CLOSED = {"rigid faces": 1e-13, "grips": 1e-13, "viscous": 2e-12}  # 4e-15, 5e-15 and 1.4e-13 were measured
_BALANCED = 1e-10
_ALLOWANCE = 0.1  # the coarsest grids do not follow the power law yet


def conserves(residual: Array) -> Verdict:
    """The leapfrog, on every grid."""
    worst = float(np.abs(residual).max())
    return bounded("The leapfrog’s ledger closes to rounding on every grid", Evidence.EXACT, worst, _CLOSED["rigid faces"])


def order_verdict(ladder: EnergyLadder, found: Fit) -> Verdict:
    """The order of a family that does not conserve, with its 95 % interval, against the order of its squared jumps."""
    assert ladder.derived is not None
    short = shortfall(found, ladder.derived, _ALLOWANCE)
    claim = "Energy losses of the other families have the order of their squared jumps"
    remark = f"`{ladder.model}`"
    return Verdict(claim, Evidence.EXACT, f"{ladder.derived:g}", with_interval(found), judge(not short), remark)


def with_interval(found: Fit) -> str:
    """An order with its 95 % interval."""
    return f"{found.order:.2f} ± {found.half_width:.2f}"


def balances(shown: Mapping[str, History]) -> Verdict:
    """The entries of two cycles: the input is the sum of the others."""
    off = {name: abs(1.0 - sum(history.share(entry) for entry in ENTRIES[1:])) for name, history in shown.items()}
    worst = max(off, key=off.__getitem__)
    claim = "Over two cycles the work of the drive is friction, radiation, viscous heat and what stays in the slabs"
    return bounded(claim, Evidence.EXACT, off[worst], _BALANCED, f"relative to the work; {', '.join(off)}; shown: {worst}")


def closes(name: str, residuals: dict[str, float]) -> Verdict:
    """Families of high degree on one scene."""
    worst = max(residuals, key=lambda model: abs(residuals[model]))
    claim = "Ledgers of high degree close to rounding"
    remark = f"{name}; worst of {', '.join(residuals)}: `{worst}`"
    return bounded(claim, Evidence.EXACT, abs(residuals[worst]), _CLOSED[name], remark)
