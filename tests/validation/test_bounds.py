"""Verdicts that bound a size, and what a study may say when one fails."""

import math

import pytest
from roomy import too_roomy

from slipwave.observe.statistics import Estimate
from validation.references.published import half_digit
from validation.study import PAPER, Evidence, Outcome, StudyResult, Verdict, claim
from validation.study.known import as_known


@pytest.mark.parametrize(
    ("size", "outcome"),
    [(0.0, "pass"), (0.99e-6, "pass"), (1e-6, "fail"), (3e-6, "fail"), (math.nan, "fail"), (math.inf, "fail")],
)
def test_a_size_beyond_its_limit_is_red(size, outcome):
    assert claim("c", Evidence.EXACT, size, 1e-6).outcome == outcome


def test_a_bound_tells_its_limit_and_its_room():
    verdict = claim("c", Evidence.EXACT, 1.0 - 2.0**-25, 1e-6, near=1.0)
    assert (verdict.expected, verdict.ours) == ("below 1 · 10^{−6}", "3.0 · 10^{−8}")
    assert (verdict.size, verdict.limit) == (2.0**-25, 1e-6)
    assert len(too_roomy([verdict, claim("c", Evidence.EXACT, 4e-8, 1e-6), claim("c", Evidence.EXACT, 1e-15, 1e-12)])) == 1
    assert claim("c", PAPER, 2e-6, 1e-6).outcome is Outcome.FINDING


def test_no_study_answers_yes_beside_a_red_light():
    held = Verdict("A holds", Evidence.EXACT, "1", "1", Outcome.PASS)
    qualified = Verdict("B holds", Evidence.PAPER, "1", "1", Outcome.FINDING)
    broken = Verdict("C holds", Evidence.EXACT, "1", "2", Outcome.FAIL)
    assert StudyResult("They do.", verdicts=(held, qualified)).conclusion == "They do."
    told = StudyResult("They do.", verdicts=(held, broken, qualified, broken)).conclusion
    assert told == "Not shown: 2 of 4 checks fail (C holds)."
    assert StudyResult(told, verdicts=(broken, held, qualified, broken)).conclusion == told


@pytest.mark.parametrize(("value", "half"), [(73.47, 0.005), (73.4721449443, 5e-11), (1.5e-07, 5e-9)])
def test_half_of_the_last_digit(value, half):
    assert half_digit(value) == pytest.approx(half)


@pytest.mark.parametrize(("evidence", "outcome"), [(Evidence.WITNESS, "fail"), (Evidence.EXACT, "pass")])
def test_a_witness_that_agrees_to_the_last_bit_is_none(evidence, outcome):
    assert claim("agree", evidence, 0.0, 1.0).outcome == outcome


@pytest.mark.parametrize(("share", "outcome"), [(0.9, "pass"), (1.2, "fail"), (70.0, "fail")])
def test_periods_are_held_against_the_digits_known(share, outcome):
    """Of the ODE 70.73234499 is known, by another program."""
    assert as_known({"kelvin-voigt": Estimate(70.73234499 + share * 5e-9, 0.0)}, -2.68).outcome == outcome
