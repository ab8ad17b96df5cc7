"""What a model does in a scene, in words; figures and means with their errors."""

import numpy as np
import pytest
from scipy.signal import lfilter

import slipwave
from slipwave.observe.events import Events
from slipwave.observe.statistics import autocorrelations, margin_of_mean, summarise
from tests.granite import GRANITE
from validation.fit.least_squares import _correlated_samples
from validation.measure.over_r import scene_at
from validation.measure.regimes import AWAY, STEADY, regime_of


@pytest.mark.parametrize(
    ("model", "log10_r", "words", "cycles"),
    [
        ("block8", -2.68, "periodic", 0),
        ("quasidynamic", -2.68, STEADY, 0),
        ("quasistatic", -2.6, AWAY, 0),
        ("kelvin-voigt", -2.5, "irregular", 26),
    ],
)
def test_the_regime_of_a_run(model, log10_r, words, cycles):
    found = regime_of(model, scene_at(log10_r), 4500.0)
    assert (found.words, found.cycles) == (words, pytest.approx(cycles, abs=2))
    assert (not found.figures) == (words in (STEADY, AWAY))


def test_an_orbit_is_refined_where_a_tolerance_is_given():
    """76.6102996 by another program."""
    run, refined = (regime_of("block8", scene_at(-2.68), 4000.0, None, tolerance) for tolerance in (None, 1e-9))
    assert run.figures["T"].value == pytest.approx(76.6102996396875, rel=1e-6)
    assert refined.figures["T"].value == pytest.approx(76.6102996396875, rel=1e-12)
    assert refined.ran["T"].value == pytest.approx(76.6102996396875, rel=3e-9)


def sequence(memory, count, seed):
    """x_n = memory x_(n - 1) + a normal number, about 5."""
    drawn = np.random.default_rng(seed).normal(size=count)
    drawn[0] /= np.sqrt(1.0 - memory**2)
    return 5.0 + lfilter([1.0], [1.0, -memory], drawn)


def test_samples_of_a_fit_fluctuate_together_as_cycles_of_a_run_do():
    """With memory 0.8 some (1 + 0.8)/(1 - 0.8) = 9 at a time."""
    values = [sequence(0.8, 4000, seed) - 5.0 for seed in range(20)]
    by_lag = [float(values[0][lag:] @ values[0][:-lag] / (values[0] @ values[0])) for lag in (1, 2, 7)]
    assert autocorrelations(values[0])[[0, 1, 2, 7]] == pytest.approx([1.0, *by_lag], rel=1e-10)
    assert np.mean([_correlated_samples(one) for one in values]) == pytest.approx(9.0, rel=0.1)
    by_means = [(0.5 * margin_of_mean(one) / 1.2) ** 2 * one.size / np.var(one) for one in values]
    assert np.mean(by_means) == pytest.approx(9.0, rel=0.25)


@pytest.mark.parametrize("memory", [0.0, 0.8])
def test_twice_the_error_of_a_median_is_a_margin_too_and_a_heavy_tail_does_not_matter(memory):
    """The median of a cubed exponential is that of the sequence, 5, mapped likewise; its mean is many times larger."""
    columns = [np.exp(3.0 * sequence(memory, 4000, seed)) for seed in range(40)]
    found = [summarise(Events(*[column] * 6), repeat=False) for column in columns]
    margins = [one.margins["v_max_median"] for one in found]
    assert np.mean([abs(one.v_max_median - np.exp(15.0)) <= margin for one, margin in zip(found, margins, strict=True)]) >= 0.9
    assert np.median(margins) < np.exp(15.0)


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
