import numpy as np
import pytest
from roomy import too_roomy
from shown import quick

import slipwave
from reduced import closed_forms
from validation.studies.stability_boundaries.measured import closed_form_verdicts, critical_over_velocity
from validation.study import Outcome


@pytest.fixture(scope="module")
def result():
    return quick("stability-boundaries")


def test_every_verdict_holds(result):
    assert [v.claim for v in result.verdicts if v.outcome is not Outcome.PASS] == []
    assert len(result.verdicts) == 10
    assert too_roomy(result.verdicts) == []


def test_numbers(result):
    assert result.numbers["log10 r_c, quasistatic"].value == pytest.approx(-2.698970004336, abs=1e-11)
    assert result.numbers["error of (27) at V = 1e4"].value == pytest.approx(-0.07672436, rel=1e-6)


def test_a_wrong_closed_form_turns_a_light_red(monkeypatch):
    paper = slipwave.read("paper")
    measured = critical_over_velocity(paper, np.array([1.0, 1e4]))
    right = closed_forms.kelvin_voigt_r
    monkeypatch.setattr(closed_forms, "kelvin_voigt_r", lambda slopes, epsilon: 1.000001 * right(slopes, epsilon))
    outcomes = [verdict.outcome for verdict in closed_form_verdicts(paper, measured)]
    assert outcomes.count(Outcome.FAIL) == 2
