"""The answer for a sample of granite, from its data sheet alone, as docs/first-sample.md tells it."""

import pytest

import slipwave
from tests.granite import GRANITE

LONG_MEAN, ITS_MARGIN = 463.0, 0.2
"""Period [s] over 400 cycles, and half the width of its 95 % interval."""


@pytest.mark.slow
def test_granite_has_its_period_and_its_stress_drop_without_any_option():
    """The cycles are irregular, so that each machine finds its own: the mean holds within its margin (here twice that, so that
    it does on any machine). The first cycles are a transient with a mean of 431 s."""
    summary = slipwave.run(GRANITE).summary
    assert (summary["verdict"], summary["ended"]) == ("irregular", "settled")
    second = summary["si"]["transit_s"]
    margin = summary["margins"]["period"] * second
    assert margin < 2.0
    assert summary["si"]["period_s"] == pytest.approx(LONG_MEAN, abs=2.0 * margin + ITS_MARGIN)
    assert summary["si"]["stress_drop_Pa"] == pytest.approx(0.82e6, abs=0.01e6)
    assert summary["left_out"] > 0.9 * summary["until"]
