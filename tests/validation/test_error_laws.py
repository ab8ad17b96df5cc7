import pytest

import scene
from validation.studies import load
from validation.studies.error_laws import Cycle, _cycle_verdict, measure_cycle, measure_onsets
from validation.studies.error_laws_figures import fall
from validation.study import Outcome


@pytest.fixture(scope="module")
def onsets():
    return measure_onsets(scene.read("paper"))


def test_onset_errors_fall_at_the_laws_power(onsets):
    for model, one in onsets.items():
        small = abs(one.error) > 1e-11  # below, the error of r_c itself is rounding
        index = int(small.nonzero()[0][-1])
        if model != "quasidynamic":
            assert one.ratio(index) == pytest.approx(1.0, abs=0.01)
    assert load("error-laws")._onset_verdicts(onsets)[0].outcome is Outcome.PASS
    assert {v.outcome for v in load("error-laws")._onset_verdicts(onsets)} == {Outcome.PASS}


def test_the_cycles_error_does_not_fall(onsets):
    paper = scene.read("paper")
    cycles = [measure_cycle(paper, scale) for scale in (1.0, 0.5)]
    assert cycles[0].errors["kelvin-voigt"] == pytest.approx(-0.0318, abs=2e-4)
    assert cycles[1].errors["kelvin-voigt"] == pytest.approx(-0.0292, abs=2e-4)
    assert _cycle_verdict(cycles).outcome is Outcome.FINDING
    assert fall(onsets, cycles).axes


def test_a_period_error_that_falls_would_pass():
    cycles = [Cycle(0.2, 7.0, {"kelvin-voigt": 1e-2}), Cycle(0.1, 7.0, {"kelvin-voigt": 2e-3})]
    assert _cycle_verdict(cycles).outcome is Outcome.PASS
