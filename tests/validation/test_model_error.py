import dataclasses
import math

import numpy as np
import pytest
from roomy import too_roomy
from shown import quick

from reduced.impedance import reduction_of
from validation.studies import load
from validation.studies.model_error import verdicts
from validation.studies.model_error.runs import ModelRun, error, states
from validation.studies.model_error.shown import errors_over_r
from validation.studies.model_error.verdicts import target
from validation.study import Outcome

STUDY = load("model-error")


@pytest.fixture(scope="module")
def result():
    return quick("model-error")


def test_every_verdict_holds(result, as_recorded):
    assert [v.claim for v in result.verdicts if v.outcome is not Outcome.PASS] == []
    assert len(result.verdicts) == 6
    as_recorded("model-error", result)
    assert too_roomy(result.verdicts) == []


def test_errors_at_the_papers_r(result):
    known = {"kelvin-voigt": -3.7290e-2, "block8": 4.2715e-2, "modal:1": 5.809e-4, "modal:2": -5.53e-6}
    for model, value in known.items():
        assert result.numbers[f"{model} error of T at -2.68"].value == pytest.approx(value, rel=2e-3)


@pytest.mark.parametrize(("model", "count"), [("quasidynamic", 2), ("block8", 3), ("kelvin-voigt", 4), ("modal:2", 7)])
def test_states(model, count):
    assert states(model) == count


def test_a_model_that_found_no_orbit_has_no_error():
    runs = {"delay": {-2.6: ModelRun(80.0, 0.2, 1.0)}, "block8": {-2.6: None}}
    assert math.isnan(error(runs, "block8", -2.6, "period"))


def test_a_worse_model_turns_a_light_red(result):
    fine = {-2.68: ModelRun(73.0, 0.17, 1.0)}
    verdict = target({"delay": fine, "modal:1": {-2.68: ModelRun(73.2, 0.17, 1.0)}}, "modal:1")
    assert verdict.outcome is Outcome.FAIL


def runs_with(**errors):
    """Periods 73 of the delay system at two r, of the others off by `errors` (drops by the same)."""
    models = {name.replace("_", ":").replace("kelvin:voigt", "kelvin-voigt"): off for name, off in errors.items()}
    grid = (-2.69, -2.68)
    return {"delay": {r: ModelRun(73.0, 0.17, 1.0) for r in grid}} | {
        model: {r: ModelRun(73.0 * (1.0 + off), 0.17 * (1.0 + off), 2.0) for r in grid} for model, off in models.items()
    }


@pytest.mark.parametrize(("model", "limit"), [("modal:1", 1e-3), ("modal:2", 1e-5)])
def test_what_the_modes_promise(model, limit):
    name = model.replace(":", "_")
    outcomes = [target(runs_with(**{name: off}), model).outcome for off in (0.9 * limit, -3.0 * limit)]
    assert outcomes == [Outcome.PASS, Outcome.FAIL]


@pytest.mark.parametrize(("short", "outcome"), [(0.0370, "pass"), (0.0384, "pass"), (0.0354, "fail"), (0.0400, "fail")])
def test_the_papers_period_as_printed(short, outcome):
    """1 - 70.73/73.5 = 0.0377; half of the last digits is 7.5e-4."""
    assert verdicts._paper(runs_with(kelvin_voigt=-short)).outcome == outcome


def test_more_modes_must_err_less():
    falling = {"modal_1": 1e-2, "modal_2": 1e-4, "modal_4": 2e-5, "modal_8": 3e-6}
    others = {"block12": 0.0, "block8": 0.0, "kelvin_voigt": 0.0}
    assert verdicts._modes(runs_with(**falling, **others)).outcome is Outcome.PASS
    assert verdicts._modes(runs_with(**falling | {"modal_4": 2e-4}, **others)).outcome is Outcome.FAIL


@pytest.mark.parametrize(
    ("field", "off", "outcome"),
    [("frequencies", 1e-13, "pass"), ("frequencies", 1e-12, "fail"), ("residues", 4e-12, "pass"), ("residues", -2e-11, "fail")],
)
def test_a_fit_must_find_the_modes(monkeypatch, field, off, outcome):
    """One mode displaced: a fit of the impedance knows nothing of it."""
    true = reduction_of(verdicts.scene_at(-2.68), "fitted:4")
    values = tuple(value * (1.0 + off * (k == 2)) for k, value in enumerate(getattr(true, field)))
    monkeypatch.setattr(verdicts, "reduction_of", lambda *args: dataclasses.replace(true, **{field: values}))
    assert verdicts.fitted_modes("fitted:4").outcome == outcome


def test_no_mode_is_the_block(monkeypatch):
    assert verdicts._no_modes().outcome is Outcome.PASS
    heavier = {
        "modal:0": reduction_of(verdicts.scene_at(-2.68), "block8"),
        "block12": reduction_of(verdicts.scene_at(-2.68), "block12"),
    }
    monkeypatch.setattr(verdicts, "reduction_of", lambda scene, model: heavier[model])
    assert verdicts._no_modes().outcome is Outcome.FAIL


def test_the_answer_and_the_note_follow_the_runs():
    off = {"kelvin_voigt": -0.04, "modal_1": 6e-4, "modal_2": 6e-6, "modal_8": 4e-7}
    told = STUDY._answer(runs_with(**off))
    assert "misses the period by 4 · 10^{−2}" in told
    assert told.endswith("by 6 · 10^{−4}, two by 6 · 10^{−6}, eight by 4 · 10^{−7}.")
    assert "take 1 ms with `delay`, 2 ms with `modal:1`, 2 ms with `modal:8`" in STUDY._note(runs_with(**off))


def test_the_figure_shows_errors_of_period_and_drop():
    grid = np.array([-2.69, -2.68, -2.66])
    curves = {
        "block8": (grid, np.array([1e-2, 2e-2, 3e-2]), np.array([1e-3, 2e-3, 3e-3])),
        "modal:4": (grid, 1e-5 * grid**2, 1e-6 * grid**2),
    }
    period, drop = errors_over_r(curves).axes
    assert [axes.get_title() for axes in (period, drop)] == ["period $T$", r"stress drop $\Delta\mu$"]
    assert period.get_ylabel() == "relative error"
    assert {axes.get_xlabel() for axes in (period, drop)} == {r"$\log_{10} r$"}
    assert np.array_equal(period.get_lines()[0].get_ydata(), curves["block8"][1])
    assert np.array_equal(drop.get_lines()[1].get_ydata(), curves["modal:4"][2])
