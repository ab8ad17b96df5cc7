"""The study of the ledger: what closes, how fast, and where two cycles' work goes."""

import numpy as np
import pytest

from validation.measure.order_fit import fit_order
from validation.studies import energy
from validation.studies.energy.ledgers import LADDERS, ORDERS, history_of, ledger_order, residual_of
from validation.study import Outcome

CELLS = np.array([8, 12, 16, 24, 32, 48])


def test_leapfrog_closes_to_rounding_and_others_at_their_order():
    assert residual_of("fd", 12) < 1e-13
    found = ledger_order("dg:1", np.array([residual_of("dg:1", n) for n in LADDERS["dg:1"][:4]]))
    assert found.order == pytest.approx(3.0, abs=0.02)
    assert ORDERS == {"sbp:2": 4.0, "fem:1": 4.0, "fem:2": 4.0, "dg:1": 3.0, "dg:2": 5.0}


@pytest.mark.parametrize(("name", "lost"), [("rigid faces", ()), ("grips", ("radiated",)), ("viscous", ("viscous",))])
def test_history_shows_the_losses_a_scene_has(name, lost):
    history = history_of(name, 2)
    balance = history.total("input") - sum(history.total(entry) for entry in ("friction", "stored", "radiated", "viscous"))
    assert abs(balance) < 1e-6 * history.total("input")
    assert {entry for entry in ("radiated", "viscous") if history.total(entry) > 0.0} == set(lost)


@pytest.mark.parametrize(
    ("residual", "off", "red"), [(0.9e-13, 0.09, 0), (3e-13, -0.09, 1), (np.nan, 0.0, 1), (0.0, 0.3, 1), (0.0, -0.3, 1)]
)
def test_ledgers_are_judged_on_both_sides(residual, off, red):
    orders = {"dg:2": fit_order(CELLS, 1e-6 * (CELLS / 8.0) ** -(5.0 + off), 1e-9)}
    verdicts = [*energy.ladder_verdicts(np.array([1e-15, residual]), orders)]
    assert [verdict.outcome for verdict in verdicts].count(Outcome.FAIL) == red


@pytest.mark.parametrize(("share", "red"), [(0.9, 0), (3.0, 3)])
def test_high_degrees_must_close(share, red):
    sizes = {"rigid faces": share * 1e-13, "grips": share * 1e-13, "viscous": share * 2e-12}
    verdicts = [*energy.high_verdicts({"dg:4": dict.fromkeys(sizes, 0.0), "dg:7": sizes})]
    assert [verdict.outcome for verdict in verdicts].count(Outcome.FAIL) == red
