"""The picture of one slip event: its study passes, and its check of the characteristics can fail."""

from dataclasses import replace

import numpy as np
import pytest
from roomy import too_roomy
from shown import quick

from validation.studies import slip_event
from validation.study import Outcome
from validation.study.drawing import styled


def test_study_passes_and_draws():
    result = quick("slip-event")
    assert {verdict.outcome for verdict in result.verdicts} == {Outcome.PASS}
    assert too_roomy(result.verdicts) == []
    assert "slips at up to 4,412 V*, stays above 10 V for 1.7 transits and falls below V 1.03 transits" in result.answer
    assert 4400.0 < result.numbers["largest slip rate"].value < 4420.0
    with styled():
        velocity, stress, *bars = result.figures[0].draw().axes
    assert stress.get_xlabel() == "time since the fastest slip (transits)"
    assert [bar.get_ylabel() for bar in bars] == ["velocity / V*", "shear stress / normal stress"]
    assert velocity.get_xlim() == (-5.0, 7.0)
    drawn = velocity.collections[0]
    assert np.abs(drawn.get_array()).max() == pytest.approx(2206.0, rel=1e-3)  # half the slip rate, in V*


def test_characteristics_notice_a_wrong_wave_speed():
    field = slip_event._record(8).field
    stretched = replace(field, upper=replace(field.upper, depth=1.05 * field.upper.depth))
    assert slip_event.characteristics(field) < 1e-3
    assert slip_event.characteristics(stretched) > 1e-2


@pytest.mark.parametrize(("off", "outcome"), [(0.9e-6, Outcome.PASS), (3e-6, Outcome.FAIL)])
def test_how_far_waves_may_change(off, outcome):
    assert slip_event._straight(off, 16).outcome is outcome


@pytest.fixture(scope="module")
def event():
    return slip_event._record(8)


@pytest.mark.parametrize(("off", "outcome"), [(0.0, Outcome.PASS), (0.9e-10, Outcome.PASS), (-3e-10, Outcome.FAIL)])
def test_how_far_the_driven_face_may_move(event, off, outcome):
    velocity = np.full_like(event.field.upper.velocity, 50.0 * (1.0 + off))
    moved = replace(event, field=replace(event.field, upper=replace(event.field.upper, velocity=velocity)))
    assert slip_event._driven_face(moved).outcome is outcome


@pytest.mark.parametrize(("stretch", "outcome"), [(1.0, "pass"), (1.06, "pass"), (1.3, "fail"), (0.7, "fail"), (0.89, "pass")])
def test_when_the_event_must_end(event, stretch, outcome):
    """v falls below V 1.03 transits after its fastest moment; time is stretched."""
    assert slip_event._stopped(replace(event, field=replace(event.field, time=stretch * event.field.time))).outcome == outcome


def test_an_event_that_never_ends_is_red(event):
    fast = replace(event.field.upper, velocity=np.full_like(event.field.upper.velocity, 1e3))
    assert slip_event._stopped(replace(event, field=replace(event.field, upper=fast))).outcome is Outcome.FAIL
