"""The study of the ledger: what closes, how fast, and where two cycles' work goes."""

import numpy as np
import pytest

from validation.studies.energy_runs import history_of, mean_order, residual_of


def test_leapfrog_closes_to_rounding_and_others_at_their_order():
    assert abs(residual_of("fd", 12, "rigid faces")) < 1e-13
    cells = (8, 16, 32)
    assert mean_order(cells, np.array([residual_of("dg:1", n, "rigid faces") for n in cells])) == pytest.approx(3.0, abs=0.1)


@pytest.mark.parametrize(("name", "lost"), [("rigid faces", ()), ("grips", ("radiated",)), ("viscous", ("viscous",))])
def test_history_shows_the_losses_a_scene_has(name, lost):
    history = history_of(name, 2)
    balance = history.total("input") - sum(history.total(entry) for entry in ("friction", "stored", "radiated", "viscous"))
    assert abs(balance) < 1e-6 * history.total("input")
    assert {entry for entry in ("radiated", "viscous") if history.total(entry) > 0.0} == set(lost)
