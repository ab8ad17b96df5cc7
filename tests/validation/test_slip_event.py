"""The picture of one slip event: its study passes, and its check of the characteristics can fail."""

from dataclasses import replace

import numpy as np
import pytest
from test_quick_studies import held

from validation.studies import slip_event
from validation.study import Outcome
from validation.study.drawing import styled


def test_study_draws():
    result = held("slip-event")
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


def test_an_event_that_never_ends_is_red(event):
    fast = replace(event.field.upper, velocity=np.full_like(event.field.upper.velocity, 1e3))
    endless = replace(event, field=replace(event.field, upper=fast))
    assert list(slip_event._verdicts(endless, 0.0))[-1].outcome is Outcome.FAIL
