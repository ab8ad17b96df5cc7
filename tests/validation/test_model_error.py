import math

import pytest

from validation.studies import load
from validation.studies.model_error_runs import Run, error, states
from validation.studies.model_error_verdicts import target
from validation.study import Budget, Outcome

STUDY = load("model-error")


@pytest.fixture(scope="module")
def result():
    return STUDY.run(Budget(quick=True))


def test_every_verdict_holds(result):
    assert [v.claim for v in result.verdicts if v.outcome is not Outcome.PASS] == []
    assert len(result.verdicts) == 6


def test_errors_at_the_papers_r(result):
    known = {"kelvin-voigt": -3.7290e-2, "block8": 4.2715e-2, "modal:1": 5.809e-4, "modal:2": -5.53e-6}
    for model, value in known.items():
        assert result.numbers[f"{model} error of T"].value == pytest.approx(value, rel=2e-3)


def test_figure_draws(result):
    assert len(result.figures[0].draw().axes) == 2


@pytest.mark.parametrize(("model", "count"), [("quasidynamic", 2), ("block8", 3), ("kelvin-voigt", 4), ("modal:2", 7)])
def test_states(model, count):
    assert states(model) == count


def test_a_model_that_found_no_orbit_has_no_error():
    runs = {"delay": {-2.6: Run(80.0, 0.2, 1.0)}, "block8": {-2.6: None}}
    assert math.isnan(error(runs, "block8", -2.6, "period"))


def test_a_worse_model_turns_a_light_red(result):
    fine = {-2.68: Run(73.0, 0.17, 1.0)}
    verdict = target({"delay": fine, "modal:1": {-2.68: Run(73.2, 0.17, 1.0)}}, "modal:1")
    assert verdict.outcome is Outcome.FAIL
