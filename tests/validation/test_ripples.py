"""The period of a ripple that is known."""

import numpy as np
import pytest

from validation.measure.cycle import Cycle, ripple_period


def cycle(period, amplitude=0.01):
    time = np.sort(np.concatenate([np.arange(0.0, 70.0, 0.031), np.arange(0.0, 70.0, 0.047)]))
    time = np.unique(time)
    stress = 0.2 + 0.002 * time + 1e-5 * time**2 + amplitude * np.cos(2 * np.pi * time / period)
    return Cycle(time, np.ones_like(time), time * 0, stress, stress, np.ptp(time))


@pytest.mark.parametrize("period", [1.0, 1.2825498])
def test_known_ripple(period):
    assert ripple_period(cycle(period)) == pytest.approx(period, rel=2e-4)


def test_no_ripple():
    with pytest.raises(ValueError, match="ripples between"):
        ripple_period(cycle(40.0))
