"""The picture of one slip event: its study passes, and its check of the characteristics can fail."""

from dataclasses import replace

import numpy as np
import pytest
from shown import quick

from validation.studies import slip_event
from validation.study import Outcome
from validation.study.drawing import styled


def test_study_draws():
    result = quick("slip-event")
    assert "slips at up to 4,412 V*, stays above 10 V for 1.7 transits and falls below V 1.03 transits" in result.answer
    with styled():
        velocity, *_ = result.figures[0].draw().axes
    assert velocity.get_xlim() == (-5.0, 7.0)
    assert np.abs(velocity.collections[0].get_array()).max() == pytest.approx(2206.0, rel=1e-3)  # half the slip rate, in V*


def test_characteristics_notice_a_wrong_wave_speed():
    field = slip_event._record(8).field
    stretched = replace(field, upper=replace(field.upper, depth=1.05 * field.upper.depth))
    assert slip_event.characteristics(field) < 1e-3
    assert slip_event.characteristics(stretched) > 1e-2


@pytest.fixture(scope="module")
def event():
    return slip_event._record(8)


@pytest.mark.parametrize(
    ("curved", "moved", "stretch", "outcomes"),
    [
        (0.9e-6, 0.9e-10, 1.0, "pass pass pass"),
        (3e-6, -3e-10, 1.3, "fail fail fail"),
        (0.9e-6, 0.0, 1.06, "pass pass pass"),
        (0.9e-6, 0.0, 0.7, "pass pass fail"),
        (0.9e-6, 0.0, 0.89, "pass pass pass"),
    ],
)
def test_waves_the_driven_face_and_the_end_of_the_event(event, curved, moved, stretch, outcomes):
    """v falls below V 1.03 transits after its fastest moment; time is stretched."""
    velocity = event.field.upper.velocity.copy()
    velocity[:, -1] = 50.0 * (1.0 + moved)
    upper = replace(event.field.upper, velocity=velocity)
    changed = replace(event, field=replace(event.field, upper=upper, time=stretch * event.field.time))
    assert [verdict.outcome for verdict in slip_event._verdicts(changed, curved)] == outcomes.split()


def test_an_event_that_never_ends_is_red(event):
    fast = replace(event.field.upper, velocity=np.full_like(event.field.upper.velocity, 1e3))
    endless = replace(event, field=replace(event.field, upper=fast))
    assert list(slip_event._verdicts(endless, 0.0))[-1].outcome is Outcome.FAIL
