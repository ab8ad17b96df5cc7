"""Verdicts that bound a size, and what a study may say when one fails."""

import math
import re

import pytest
from fake_studies import answered
from shown import too_roomy

from validation.measure.order_fit import Fit
from validation.report import (
    PAPER,
    WITNESS,
    Evidence,
    Outcome,
    StudyResult,
    Verdict,
    at_least,
    claim,
    every,
    in_range,
)
from validation.report.known import as_known, of_order
from validation.report.names import by_claim, with_names
from validation.studies import claims, cost_and_error

ORDER = Fit(3.91, 0.11, 1e-6, slice(0, 4), 3.9, 0.1)


@pytest.mark.parametrize(
    ("size", "outcome"),
    [(0.0, "pass"), (0.99e-6, "pass"), (1e-6, "fail"), (3e-6, "fail"), (math.nan, "fail"), (math.inf, "fail")],
)
def test_a_size_beyond_its_limit_is_red(size, outcome):
    assert claim("c", Evidence.EXACT, size, 1e-6).outcome == outcome


def test_a_bound_tells_its_limit_and_its_room():
    verdict = claim("c", Evidence.EXACT, 1.0 - 2.0**-25, 1e-6, near=1.0)
    assert (verdict.expected, verdict.ours) == ("1.0000000 ± 1 · 10^{−6}", "1.0000000")
    assert (verdict.found, verdict.limit, verdict.margin) == (2.0**-25, 1e-6, 2.0**-25 / 1e-6)
    assert len(too_roomy([verdict, claim("d", Evidence.EXACT, 4e-8, 1e-6), claim("e", Evidence.EXACT, 1e-15, 1e-12)])) == 1
    assert claim("c", PAPER, 2e-6, 1e-6).outcome is Outcome.FINDING


@pytest.mark.parametrize(
    ("verdict", "words", "outcome", "margin"),
    [
        (at_least("c", Evidence.EXACT, 8.88, 8.0), ("8 or more", "8.9"), "pass", 8.0 / 8.88),
        (at_least("c", Evidence.EXACT, 7.9996, 8.0), ("8 or more", "7.9996"), "fail", 8.0 / 7.9996),
        (in_range("c", Evidence.EXACT, (0.9, 1.1), [0.95, 1.02]), ("0.9 to 1.1", "0.95 to 1.02"), "pass", 0.5),
        (in_range("c", Evidence.EXACT, (0.9, 1.1), [1.0, 1.12]), ("0.9 to 1.1", "1 to 1.12"), "fail", 1.2),
        (in_range("c", Evidence.EXACT, (0.9, 1.1), [1.0, math.nan]), ("0.9 to 1.1", "1"), "fail", None),
        (every("c", Evidence.EXACT, 7, 7, what="runs"), ("7 of 7 runs", "7 of 7 runs"), "pass", 0.0),
        (of_order("c", WITNESS, ORDER, 4.0, above=True), ("3.89 or more", "3.91\xa0±\xa00.11"), "pass", 0.09 / 0.11),
        (of_order("c", WITNESS, ORDER, 4.2, above=True), ("4.09 or more", "3.91\xa0±\xa00.11"), "fail", 0.29 / 0.11),
    ],
)
def test_found_and_limit_of_other_claims(verdict, words, outcome, margin):
    assert (verdict.expected, verdict.ours, verdict.outcome) == (*words, outcome)
    assert verdict.margin == (margin if margin is None else pytest.approx(margin))


def test_each_verdict_has_a_name_that_stays():
    """Claim, and as much of evidence and remark as sets it apart; never what was measured."""
    told = [
        ("Ψ at 10^{-9}: *T*", "EXACT", ""),
        ("A", "PAPER", "`dg:7`; 1 e"),
        ("A", "PAPER", "√2 : 1"),
        ("A", "EXACT", ""),
        ("A", "EXACT", ""),
    ]
    verdicts = [Verdict(title, Evidence[kind], "", "", Outcome.PASS, remark) for title, kind, remark in told]
    names = ["psi-at-10-minus-9-t", "a.paper-dg-7", "a.paper-root-2", "a.exact", "a.exact-2"]
    assert [verdict.id for verdict in with_names("of-a", verdicts)] == [f"of-a.{name}" for name in names]
    assert [verdict.id for verdict in with_names("of-a", verdicts[:1])] == ["of-a.psi-at-10-minus-9-t"]


def test_the_cases_of_a_claim_are_one_verdict_as_bad_as_the_worst():
    """And each keeps its own name and outcome; a claim by two kinds of evidence is two verdicts."""
    sizes = {"dg:2": 0.2, "dg:4": 0.9, "fd": 0.5, "exact": 2.0}
    flat = [claim("Orders hold", Evidence.SELF, size, 1.0, name) for name, size in sizes.items()]
    flat += [claim("Orders hold", Evidence.EXACT, 0.1, 1.0), claim("Energy closes", Evidence.EXACT, 0.1, 1.0, "fd")]
    whole = by_claim("a", flat)
    assert [one.id for one in whole] == ["a.orders-hold.self", "a.orders-hold.exact", "a.energy-closes"]
    assert [row.id for row in whole[0].rows][:2] == ["a.orders-hold.self-dg-2", "a.orders-hold.self-dg-4"]
    assert (whole[0].outcome, whole[0].found, whole[0].remark) == (Outcome.FAIL, 2.0, "the worst of 4: exact")
    assert [row.outcome for row in whole[0].rows] == [Outcome.PASS] * 3 + [Outcome.FAIL]
    assert by_claim("a", flat[:3])[0].found == 0.9
    assert by_claim("a", flat[4:])[1].rows == by_claim("a", flat[4:])[1:]


def test_every_verdict_is_cited_and_what_is_cited_is_there():
    held = [claim(f"{name} holds", Evidence.EXACT, 0.1, 1.0, "dg:4") for name in "AAB"]
    broken = claim("B holds", Evidence.EXACT, 2.0, 1.0)
    both = {"A does.": ("A holds",), "B does.": ("B",)}
    found = StudyResult(both, verdicts=by_claim("a", [*held, broken]))
    assert [len(found.proofs(one)) for one in both] == [1, 1]
    assert found.conclusion == "A does. Not shown: 1 of 2 checks fail (B holds)."
    wrong = [({"A does.": ("A holds",)}, "no answer cites ['B holds']"), (both | {"C does.": ("C",)}, "rests on ['C']"),
             (both | {"D does.": ()}, "rests on nothing")]  # fmt: skip
    for answers, told in wrong:
        with pytest.raises(ValueError, match=re.escape(told)):
            StudyResult(answers, verdicts=tuple(held))
    assert (
        StudyResult(
            {
                "Not answered.": (),
            }
        ).conclusion
        == "Not answered."
    )


def test_the_answer_on_the_papers_claims_counts_the_verdicts_that_it_cites():
    """Three cases of P4 are one check, and Table 1 is another answer's."""
    told = [("P4 T", 0.1), ("P4 T", 0.2), ("P4 T", 0.3), ("P11 Drops", 2.0), ("Table 1’s paper material", 2.0)]
    said = next(iter(claims._answers(tuple(claim(title, PAPER, size, 1.0, f"{size}") for title, size in told))))
    assert said == "On onset, periods, ripples and irregular cycles 1 of 2 checks hold and 1 qualify a claim."


def test_the_cost_of_an_ode_goes_up_to_its_finest_setting():
    """The error of its period is the model's at every tolerance, by chance the least at the coarsest."""
    runs = {"delay": (6.0, 22.6), "fd": (9.0, 64.0), "dg:7": (49.0, 63.0), "kelvin-voigt": (8.6, 6.6, 14.9)}
    points = []
    for model, times in runs.items():
        for k, time in enumerate(times):
            options = {"cells": 16 * 2**k} if model in ("fd", "dg:7") else {"tol": 1e-3 * 10.0**-k}
            points.append(cost_and_error._SettingRun(model, options, None, -3.7e-2 - 1e-6 * k, 0.0, [time] * 3))
    assert cost_and_error._answer(points).endswith("the paper’s ODE ~{7 ms (4 · 10^{−2})} to ~{15 ms (4 · 10^{−2})}.")


def test_no_study_answers_yes_beside_a_red_light():
    held = Verdict("A holds", Evidence.EXACT, "1", "1", Outcome.PASS)
    qualified = Verdict("B holds", Evidence.PAPER, "1", "1", Outcome.FINDING)
    broken = Verdict("C holds", Evidence.EXACT, "1", "2", Outcome.FAIL)
    assert answered("They do.", (held, qualified)).conclusion == "They do."
    told = answered("They do.", (held, broken, qualified, broken)).conclusion
    assert told == "Not shown: 2 of 4 checks fail (C holds)."
    assert answered(told, (broken, held, qualified, broken)).conclusion == told


@pytest.mark.parametrize(("evidence", "outcome"), [(Evidence.WITNESS, "fail"), (Evidence.EXACT, "pass")])
def test_a_witness_that_agrees_to_the_last_bit_is_none(evidence, outcome):
    assert claim("agree", evidence, 0.0, 1.0).outcome == outcome


@pytest.mark.parametrize(("share", "outcome"), [(0.9, "pass"), (1.2, "fail"), (70.0, "fail")])
def test_periods_are_held_against_the_digits_known(share, outcome):
    """Of the ODE 70.73234499 is known, by another program."""
    (found,) = as_known("T is known", "kelvin-voigt", -2.68, {"period": 70.73234499 + share * 5e-9}, 0.0)
    assert found.outcome == outcome
    assert list(as_known("T is known", "kelvin-voigt", -2.1, {"period": 70.0})) == []
