import numpy as np
import pytest
from shown import quick, too_roomy

from validation.studies.unlike_slabs import cost_verdicts
from validation.study import Outcome


@pytest.fixture(scope="module")
def result():
    return quick("unlike-slabs")


def test_every_agreement_holds(result):
    agreements = [v for v in result.verdicts if not v.claim.startswith("Cost")]
    assert [v.claim for v in agreements if v.outcome is not Outcome.PASS] == []
    assert too_roomy(agreements) == []
    assert len(agreements) == 5


def test_states(result):
    assert result.numbers["unlike: ψ(600)"].value == pytest.approx(-5.25812015405, abs=2e-11)
    assert result.numbers["unlike-irrational: ψ(600)"].value == pytest.approx(-3.22732303547, abs=2e-11)


def test_cost_verdicts_look_at_ratios():
    alike = {"alike": 5.0, "commensurate": 10.0, "irrational": 51.0}
    outcomes = [v.outcome for v in cost_verdicts(dict.fromkeys(("delay", "dg:7", "dg:7, finer", "fd"), alike))]
    assert np.array_equal(outcomes, [Outcome.PASS, Outcome.FINDING, *[Outcome.PASS] * 3])
