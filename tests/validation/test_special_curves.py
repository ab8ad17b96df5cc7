"""Curves of special points: what is shown, and the verdicts from both sides."""

import math

import pytest

from validation.branches.points import CurvePoint
from validation.studies import special_curves


def point(log10_r=-2.7002517, log10_v=2.0):
    return CurvePoint(log10_r, log10_v, 59.1, 0.09, 0.09, 900.0, 20.0, 1e-12, 1, 0, 1.0, 0.0)


SHARE = math.log10(1.001)
KNOWN = -2.7002517033


@pytest.mark.parametrize(
    ("here", "shift", "beside", "outcomes"),
    [
        (KNOWN, 5e-11, KNOWN, "pass pass pass"),
        (KNOWN, 2e-10, KNOWN, "fail pass pass"),
        (-2.70025169, 0.0, KNOWN, "pass fail pass"),
        (KNOWN, 0.0, -2.6993, "pass pass finding"),
        (KNOWN, 0.0, -2.7045, "pass pass finding"),
    ],
)
def test_products_the_known_fold_and_p8(here, shift, beside, outcomes):
    """V larger and r smaller by a thousandth are one fold. At V = 100 the Hopf point lies at -2.6995497; one per cent of r
    is 0.0044."""
    end = point(KNOWN - SHARE, 2.0 + SHARE)
    folds = {("delay", "LP"): [point(here), end], ("kelvin-voigt", "LP"): [point(beside)], ("delay", "NS"): [point(-2.6)]}
    assert [verdict.outcome for verdict in special_curves.verdicts(folds, KNOWN + shift)] == outcomes.split()
