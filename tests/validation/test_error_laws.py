import numpy as np
import pytest

import slipwave
from validation.studies.error_laws import MODELS, CycleErrors, _cycle_verdict, _onset_verdicts, measure_cycle, measure_onsets
from validation.study import Outcome


@pytest.fixture(scope="module")
def onsets():
    return measure_onsets(slipwave.read("paper"))


def test_onset_errors_fall_at_the_laws_power(onsets):
    for model, one in onsets.items():
        small = abs(one.error) > 1e-11  # below, the error of r_c itself is rounding
        index = int(small.nonzero()[0][-1])
        if model != "quasidynamic":
            assert one.ratio(index) == pytest.approx(1.0, abs=0.01)
    assert {verdict.outcome for verdict in _onset_verdicts(onsets)} == {Outcome.PASS}


def cycles(first, last):
    return [CycleErrors(theta, 7.0, {"kelvin-voigt": error}) for theta, error in ((0.2, first), (0.1, last))]


def test_the_cycles_error_does_not_fall():
    measured = [measure_cycle(slipwave.read("paper"), scale) for scale in (1.0, 0.5)]
    assert [one.errors["kelvin-voigt"] for one in measured] == pytest.approx([-0.0318, -0.0292], abs=2e-4)
    assert _cycle_verdict(measured).outcome is Outcome.FINDING


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_how_far_an_error_may_be_from_its_law(onsets, model, sign):
    """Half of theta^2, and twice theta for the quasi-dynamic law, at a quarter of the paper's epsilon (theta = 0.0316); and four
    units of rounding in the ratio of two critical r, 1.3e-3 of the error with eight modes."""
    one = onsets[model]
    law = np.array([one.law.at(float(theta)) for theta in one.theta])
    limit = (0.063 if model == "quasidynamic" else 5e-4) + 8.9e-16 / abs(law[abs(one.theta - 0.0316).argmin()])

    def outcome(off):
        return next(_onset_verdicts({model: one._replace(error=law * (1.0 + sign * off))})).outcome

    assert [outcome(0.9 * limit), outcome(3.0 * limit)] == [Outcome.PASS, Outcome.FAIL]


@pytest.mark.parametrize(("last", "outcome"), [(2.4e-3, "pass"), (2.6e-3, "finding"), (2e-2, "finding")])
def test_an_error_that_falls_with_theta_must_more_than_halve_beside_it(last, outcome):
    assert _cycle_verdict(cycles(-1e-2, last)).outcome == outcome
