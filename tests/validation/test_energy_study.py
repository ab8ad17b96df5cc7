"""The study of the ledger: what closes, how fast, and where two cycles' work goes."""

import numpy as np
import pytest

from validation.measure.order_fit import fit
from validation.studies import energy
from validation.studies.energy.runs import LADDERS, History, history_of, order_of, residual_of
from validation.studies.energy.shown import closure, histories
from validation.studies.energy.verdicts import closes, conserves, order_verdict
from validation.study import Outcome

DERIVED = {"sbp:2": 4.0, "fem:1": 4.0, "fem:2": 4.0, "dg:1": 3.0, "dg:2": 5.0}
CELLS = np.array([8, 12, 16, 24, 32, 48])


def test_leapfrog_closes_to_rounding_and_others_at_their_order():
    assert abs(residual_of("fd", 12, "rigid faces")) < 1e-13
    cells = (8, 12, 16, 24)
    found = order_of(cells, np.array([residual_of("dg:1", n, "rigid faces") for n in cells]))
    assert found.order == pytest.approx(3.0, abs=0.02)


@pytest.mark.parametrize(("name", "lost"), [("rigid faces", ()), ("grips", ("radiated",)), ("viscous", ("viscous",))])
def test_history_shows_the_losses_a_scene_has(name, lost):
    history = history_of(name, 2)
    balance = history.total("input") - sum(history.total(entry) for entry in ("friction", "stored", "radiated", "viscous"))
    assert abs(balance) < 1e-6 * history.total("input")
    assert {entry for entry in ("radiated", "viscous") if history.total(entry) > 0.0} == set(lost)


@pytest.mark.parametrize("ladder", [one for one in LADDERS if one.derived], ids=lambda one: one.model)
@pytest.mark.parametrize(("off", "outcome"), [(0.09, "pass"), (-0.09, "pass"), (0.3, "fail"), (-0.3, "fail")])
def test_the_order_of_a_ledger_is_judged_on_both_sides(ladder, off, outcome):
    assert ladder.derived == DERIVED[ladder.model]
    found = fit(CELLS, 1e-6 * (CELLS / 8.0) ** -(DERIVED[ladder.model] + off), 1e-9)
    assert order_verdict(ladder, found).outcome == outcome


@pytest.mark.parametrize(("off", "outcome"), [(0.9e-13, "pass"), (-3e-13, "fail"), (np.nan, "fail")])
def test_the_leapfrog_must_close(off, outcome):
    assert conserves(np.array([1e-15, off, 0.0])).outcome == outcome


@pytest.mark.parametrize(("name", "limit"), [("rigid faces", 1e-13), ("grips", 1e-13), ("viscous", 2e-12)])
def test_high_degrees_must_close(name, limit):
    outcomes = [closes(name, {"dg:4": 0.0, "dg:7": off}).outcome for off in (-0.9 * limit, -3.0 * limit)]
    assert outcomes == [Outcome.PASS, Outcome.FAIL]


def shown(friction=0.99):
    def one(radiated, viscous):
        parts = {"input": 9.0, "friction": 9.0 * friction, "stored": 0.0, "radiated": 9.0 * radiated, "viscous": 9.0 * viscous}
        return History(
            73.0, np.array([0.0, 1.0, 2.0]), {name: value * np.array([0.0, 0.4, 1.0]) for name, value in parts.items()}
        )

    return {"rigid faces": one(0.0, 0.0), "grips": one(0.008, 0.0), "viscous": one(0.0, 0.0025)}


def test_the_answer_tells_shares_and_orders():
    orders = {"dg:1": fit(CELLS, 1.0 * CELLS**-3.0), "dg:2": fit(CELLS, 1.0 * CELLS**-5.0)}
    told = energy._answer(shown(), np.array([-4e-15, 1e-15]), orders)
    assert told.startswith(
        "At least 99 % goes into friction: over two cycles grips absorb 0.8 % of the work and viscosity 0.25 %."
    )
    assert told.endswith(
        "The ledger of the leapfrog closes to 4 · 10^{−15}; the residuals of the other families fall at orders 3.0 to 5.0 in "
        "the cell."
    )
    assert energy._answer(shown(0.5), np.zeros(2), orders).startswith("At least 50 %")


def test_figures_show_entries_and_residuals():
    figure = histories(shown())
    above, below = figure.axes[0], figure.axes[3]
    assert [axes.get_ylabel() for axes in (above, below)] == [r"energy $/\sigma L$"] * 2
    assert below.get_xlabel() == "time (transits)"
    assert [line.get_ydata()[-1] for line in above.get_lines()] == pytest.approx([9.0, 8.91, 0.0])
    assert [line.get_ydata()[-1] for line in figure.axes[4].get_lines()] == pytest.approx([0.072, 0.0])
    axes = closure({"fd": (CELLS, 1e-15 * np.ones(6)), "dg:1": (CELLS, 1.0 / CELLS**3)}).axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("cells per slab", "residual")
    assert np.array_equal(axes.get_lines()[1].get_ydata(), 1.0 / CELLS**3)
