"""`slipwave verify` on schemes: the members that are shipped and correct schemes of others keep every row, one mistake is red."""

from pathlib import Path

import pytest
import vertex_volumes

import slipwave as sw
from slipwave.errors import NumericsError
from validation.measure.grid_ladders import LADDERS

SOURCE = Path(vertex_volumes.__file__).read_text(encoding="utf-8")
MISTAKES = {
    "a derivative 1 % off": ("0.5 * scale", "0.505 * scale", "psi"),
    "a derivative 1e-4 off": ("0.5 * scale", "0.50005 * scale", "psi"),
    "half a penalty": ("(2 / h, 2 / h)", "(1 / h, 1 / h)", "Noise at the grid scale"),
    "a lift of 1.01": ("(2 / h, 2 / h)", "(2.02 / h, 2 / h)", "The energy balance"),
    "the wrong sign of damping": ("half, 0.0)", "half, -0.001)", "The energy balance"),
    "dissipation of first order": ("half, 0.0)", "half, 0.01)", "The energy balance"),
    "one end row of order 0": ("rates[to + begin] = scale", "rates[to + begin] = 0.9 * scale", "psi"),
    "an order one too high": ("order_interface=lambda p: 2", "order_interface=lambda p: 3", "psi"),
    "a step limit 10 % long": ("return longest", "return 1.1 * longest", "The step limit"),
    "energy that is not conserved": ("conserves=False", "conserves=True", "The energy balance"),
    "a wrong norm": ("= h / 2", "= h", "The energy balance"),
}


def missed(tmp_path, old="", new=""):
    """The claims that a copy with a mistake misses, and what is said."""
    assert old in SOURCE
    (tmp_path / "mine.py").write_text(SOURCE.replace(old, new) if old else SOURCE)
    try:
        rows, said = sw.verify(family=tmp_path / "mine.py").rows, ""
    except NumericsError as error:
        rows, said = error.result.rows, str(error)
    assert bool(said) == any(row.outcome == "fail" for row in rows)
    return [row.claim for row in rows if row.outcome == "fail"], said


@pytest.mark.slow
@pytest.mark.parametrize("limit", ["n = 40", "n = 120"])
def test_a_correct_scheme_of_somebody_else_keeps_every_row(tmp_path, limit):
    assert missed(tmp_path, "n = 40", limit) == ([], "")


@pytest.mark.slow
@pytest.mark.parametrize("mistake", MISTAKES)
def test_one_mistake_is_red_where_it_shows_and_is_named(tmp_path, mistake):
    old, new, claim = MISTAKES[mistake]
    red, said = missed(tmp_path, old, new)
    assert any(one.startswith(claim) for one in red)
    assert "(vertex" in said


FAST = ("fd", "sbp:2", "dg:1")


@pytest.mark.parametrize("model", [pytest.param(model, marks=[pytest.mark.slow] * (model not in FAST)) for model in LADDERS])
def test_every_member_that_is_shipped_keeps_every_row(model):
    assert {row.outcome for row in sw.verify(model=model).rows} == {"pass"}


@pytest.mark.slow
@pytest.mark.parametrize("model", ["fem:10", "dg:12"])
def test_members_that_are_at_rounding_on_too_few_grids_are_not_judged_by_their_order(model):
    """They have no ladder of their own."""
    found = sw.verify(model=model)
    assert found.summary["missed"] == 0
    assert (found.summary["not_decided"] == 1) == (found.rows[0].outcome == "not decided")
