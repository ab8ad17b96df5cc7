"""The energy ledger of the full wave: work of the drive = friction + radiated + viscous + stored."""

import numpy as np

from slipwave.observe.pieces import Array
from validation.measure.order_fit import Fit
from validation.studies.energy.runs import BOUNDARIES, HIGH, LADDERS, UNTIL, History, history_of, order_of, residual_of
from validation.studies.energy.shown import closure, high_table, histories, residual_table, shares_table
from validation.studies.energy.verdicts import balances, closes, conserves, order_verdict
from validation.study import Budget, Figure, Number, StudyResult
from validation.study.text import plain

NAME = "energy"
QUESTION = "Where does the work of the drive go, and is any of it lost on the way?"
SCENES = ("paper", "grip", "viscous")
SECONDS = (8.0, 9.0)


def run(budget: Budget) -> StudyResult:
    """Measure the residual of every family's ledger, then follow the entries over two cycles."""
    residuals = {
        ladder.model: np.array([residual_of(ladder.model, cells, "rigid faces") for cells in ladder.cells])
        for ladder in budget.each(LADDERS, end=0.5)
    }
    high = {(model, name): residual_of(model, cells, name) for model, cells in HIGH.items() for name in BOUNDARIES}
    shown = {name: history_of(name, 4 if budget.quick else 8) for name in BOUNDARIES}
    orders = {ladder.model: order_of(ladder.cells, residuals[ladder.model]) for ladder in LADDERS if ladder.derived}
    curves = {ladder.model: (np.array(ladder.cells), np.abs(residuals[ladder.model])) for ladder in LADDERS}
    return StudyResult(
        answer=_answer(shown, residuals["fd"], orders),
        figures=(Figure("entries", _ENTRIES, lambda: histories(shown)), Figure("closure", _CLOSURE, lambda: closure(curves))),
        tables=(shares_table(shown), residual_table(residuals, orders), high_table(high)),
        verdicts=(
            *(conserves(residuals[ladder.model]) for ladder in LADDERS if not ladder.derived),
            *(order_verdict(ladder, orders[ladder.model]) for ladder in LADDERS if ladder.derived),
            balances(shown),
            *(closes(name, {model: high[model, name] for model in HIGH}) for name in BOUNDARIES),
        ),
        numbers={f"order of {model}": Number(found.order, 2e-2) for model, found in orders.items()},
    )


def _answer(shown: dict[str, History], fd: Array, orders: dict[str, Fit]) -> str:
    lost = {name: 100.0 * (history.share("radiated") + history.share("viscous")) for name, history in shown.items()}
    friction = 100.0 * min(history.share("friction") for history in shown.values())
    slopes = [found.order for found in orders.values()]
    return (
        f"At least {friction:.0f} % goes into friction: over two cycles grips absorb {lost['grips']:.2g} % of the work and "
        f"viscosity {lost['viscous']:.2g} %. The ledger of the leapfrog closes to {plain(float(np.abs(fd).max()), '.0e')}; "
        f"the residuals of the other families fall at orders {min(slopes):.1f} to {max(slopes):.1f} in the cell."
    )


_ENTRIES = (
    "The ledger over two cycles of the settled orbit, counted from an arbitrary moment of the slow phase, in units of σL. Above: "
    "work of the drive, heat of friction and change of the energy stored in the slabs. Below, on another scale: energy radiated "
    "through grips and heat of viscosity. Between events the drive loads the slabs; within two transits an event turns the "
    "stored energy into heat of friction."
)
_CLOSURE = (
    f"Residual of the ledger after {UNTIL:.0f} transits of the paper’s scene, relative to the largest entry, over "
    "cells per slab. The leapfrog conserves a discrete energy and stays at rounding."
)
