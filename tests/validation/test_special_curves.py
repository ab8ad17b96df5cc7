"""Curves of special points: what is shown, and the verdicts from both sides."""

import math

import pytest
from roomy import too_roomy
from shown import quick

from validation.branches.points import CurvePoint
from validation.studies import special_curves
from validation.study import Outcome


@pytest.fixture(scope="module")
def result():
    return quick("special-curves")


def test_every_verdict_holds(result):
    assert [v.claim for v in result.verdicts if v.outcome is not Outcome.PASS] == []
    assert len(result.verdicts) == 3
    assert too_roomy(result.verdicts) == []


def test_the_curve_passes_the_known_fold(result):
    assert result.numbers["delay LP at V = 100"].value == pytest.approx(-2.7002517033, abs=5e-9)
    rows = [row for row in result.tables[0].rows if row[1] == pytest.approx(100.0, abs=1e-9)]
    assert [row[3] for row in rows] in ([], [pytest.approx(59.1074327, abs=1e-5)])


def point(log10_r=-2.7002517, log10_v=2.0):
    return CurvePoint(log10_r, log10_v, 59.1, 0.09, 0.09, 900.0, 20.0, 1e-12, 1, 0, 1.0, 0.0)


@pytest.mark.parametrize(("shift", "outcome"), [(0.0, "pass"), (5e-11, "pass"), (2e-10, "fail")])
def test_only_products_matter(shift, outcome):
    """V larger by a tenth and r smaller by a tenth are one fold."""
    share = math.log10(1.1)
    assert special_curves._same(point(-2.7002517 - share, 2.0 + share), -2.7002517 + shift).outcome == outcome


@pytest.mark.parametrize(("log10_r", "outcome"), [(-2.7002517031, "pass"), (-2.70025169, "fail")])
def test_a_curve_beside_the_known_fold_fails(log10_r, outcome):
    assert special_curves._known([point(-2.71, 1.9), point(log10_r), point(-2.69, 2.1)]).outcome == outcome


@pytest.mark.parametrize(("log10_r", "outcome"), [(-2.7002517, "pass"), (-2.6993, "finding"), (-2.7045, "finding")])
def test_p8_needs_folds_just_below_the_hopf_point(log10_r, outcome):
    """At V = 100 it lies at -2.6995497; one per cent of r is 0.0044."""
    folds = {("delay", "LP"): [point(), point(log10_r)], ("delay", "NS"): [point(-2.6)]}
    assert special_curves._subcritical(folds).outcome == outcome
