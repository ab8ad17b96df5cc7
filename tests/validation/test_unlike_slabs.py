import numpy as np
import pytest

from validation.studies import load
from validation.studies.unlike_slabs_cost import cost_verdicts
from validation.study import Budget, Outcome

STUDY = load("unlike-slabs")


@pytest.fixture(scope="module")
def result():
    return STUDY.run(Budget(quick=True))


def test_every_agreement_holds(result):
    agreements = [v for v in result.verdicts if not v.claim.startswith("Cost")]
    assert [v.claim for v in agreements if v.outcome is not Outcome.PASS] == []
    assert len(agreements) == 6


def test_states(result):
    assert result.numbers["unlike: ψ(600)"].value == pytest.approx(-5.25812015405, abs=2e-11)
    assert result.numbers["unlike-irrational: ψ(600)"].value == pytest.approx(-3.22732303547, abs=2e-11)


def test_figure_draws(result):
    assert len(result.figures[0].draw().axes) == 4


def test_a_wrong_state_turns_a_light_red():
    def one(model, psi):
        return STUDY.Run(model, 4, {"psi": psi, "period": 50.0}, None)

    runs = {"unlike": [one("delay", -5.0), one("dg:7", -5.0 + 2e-9), one("sbp:6", -5.0), one("fem:4", -5.0)]}
    assert STUDY._agreements(runs)[0].outcome is Outcome.FAIL
    assert STUDY._families(runs)[0].outcome is Outcome.PASS


def test_cost_verdicts_look_at_ratios():
    alike = {"alike": 5.0, "commensurate": 10.0, "irrational": 51.0}
    outcomes = [v.outcome for v in cost_verdicts(dict.fromkeys(("delay", "dg:7", "dg:7, finer", "fd"), alike))]
    assert np.array_equal(outcomes, [Outcome.PASS, Outcome.FINDING, *[Outcome.PASS] * 3])
