"""What a model does in a scene, in words, and figures with their errors."""

import numpy as np
import pytest

from validation.measure.correlated import mean_of
from validation.study.over_r import begun_at, scene_at
from validation.study.regimes import AWAY, STEADY, UNDECIDED, Regime, regime_of


@pytest.mark.parametrize(
    ("model", "log10_r", "words", "cycles"),
    [
        ("block8", -2.68, "periodic", 0),
        ("quasidynamic", -2.68, STEADY, 0),
        ("quasistatic", -2.6, AWAY, 0),
        ("kelvin-voigt", -2.5, "irregular", 37),
    ],
)
def test_the_regime_of_a_run(model, log10_r, words, cycles):
    found = regime_of(model, scene_at(log10_r), 4500.0)
    assert (found.words, found.cycles) == (words, pytest.approx(cycles, abs=2))
    assert (found.figures is None) == (words in (STEADY, AWAY))


def test_an_orbit_is_refined_where_a_tolerance_is_given():
    """76.6102996 by another program."""
    run, refined = (regime_of("block8", begun_at(-2.68), 4000.0, None, tolerance).figures for tolerance in (None, 1e-9))
    assert run.period.value == pytest.approx(76.6102996396875, rel=3e-9)
    assert refined.period.value == pytest.approx(76.6102996396875, rel=1e-12)


def test_what_is_undecided_agrees_with_everything():
    assert Regime("torus").agrees(Regime("torus"))
    assert not Regime("torus").agrees(Regime("irregular"))
    assert Regime(UNDECIDED).agrees(Regime("irregular"))


def test_cycles_that_alternate_have_an_error_all_the_same():
    """Autocorrelations of -1, 1, ... leave none of it, but the level wanders by a hundredth."""
    level = np.repeat(np.random.default_rng(1).normal(size=8), 10)
    found = mean_of(np.tile([1.0, 3.0], 40) + 0.01 * level)
    assert found.error > 0.001
    assert found.value == pytest.approx(2.0, abs=4.0 * found.error)
