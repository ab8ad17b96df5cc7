"""Scenes beyond the paper's: where they lie, what repeats them, and bias and scatter of a model over all of them."""

import math

import pytest

import slipwave
from validation.studies.beyond_one_scene import bias_and_scatter, bias_in_words, sight
from validation.study.compared import critical_r
from validation.study.model_table import Compared


@pytest.mark.parametrize("name", ["unlike", "grip", "rock"])
def test_the_settings_of_a_place_make_its_scene(name):
    """Both slabs scaled together, 1.1 times the onset; the row of a cell names the options that repeat it."""
    place = sight(name, 1.1)
    again = slipwave.read(name, [word for word in place.settings.split() if word != "--set"])
    for slab, other in zip(again.slabs, place.scene.slabs, strict=True):
        assert (slab.round_trip, slab.epsilon) == pytest.approx((other.round_trip, other.epsilon), rel=1e-5)
    assert again.start == place.scene.start
    assert place.scene.transit == pytest.approx(1.1 * critical_r("delay", again), rel=1e-4)
    assert place.title == ("1.10 (220 mm)" if name == "rock" else "1.10")


def test_bias_and_scatter_of_errors():
    errors = [Compared(70.0, off, bar) for off, bar in ((-0.03, 0.003), (-0.05, 0.004), (-0.04, 0.0))]
    assert bias_and_scatter(errors) == pytest.approx((-0.04, 0.01, math.sqrt(25e-6 / 3.0)))
    assert all(map(math.isnan, bias_and_scatter([])))
    assert bias_in_words(-0.0394, 0.0051) == "−3.9 ± 0.5 %"
    assert bias_in_words(-0.37, math.nan) == "−37.0 %"
