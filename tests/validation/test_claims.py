"""The paper's claims on orbits and cycles of our own making: what is measured of them; `test_studies` has the verdicts."""

import numpy as np
import pytest

import slipwave
from slipwave.observe import Events
from slipwave.observe.statistics import Estimate, Orbit
from validation.measure.cycle import OneCycle
from validation.studies import claims as measured
from validation.studies.claims import Deep, loading_of, recurrence


def orbit(period=73.5, drop=0.17, elastic=0.15):
    return Orbit(*(Estimate(value, 0.0) for value in (period, drop, elastic, 4000.0, 3.0)))


def test_p1_needs_the_closed_forms(monkeypatch):
    assert [verdict.outcome for verdict in measured.onset_claims()] == ["pass"] * 3
    right = measured.onset_at
    monkeypatch.setattr(measured, "onset_at", lambda v: right(v)._replace(r_delay=right(v).r_delay * (1 + 3e-4)))
    assert next(measured.onset_claims()).outcome == "fail"


def deep(period=100.0, drop=0.35, share=0.93, spread=(0.02, 0.02, 0.02), v_max=1e4, cycles=60, seed=1):
    """Cycles whose period, drop and v_max scatter by `spread`, normal and without memory."""
    noise = np.random.default_rng(seed).standard_normal((3, cycles))
    noise = (noise - noise.mean(axis=1, keepdims=True)) / noise.std(axis=1, keepdims=True)
    T, drops, v = (value * (1.0 + size * z) for value, size, z in zip((period, drop, v_max), spread, noise, strict=True))
    events = Events(np.cumsum(T), T, drops, np.full(cycles, share * period * 2.8e-3), v, v)
    return Deep(events, np.arange(5.0), np.arange(5.0))


@pytest.mark.parametrize(("second", "share"), [(0.0, 0.0), (0.5, 0.2), (1.0, 0.5)])
def test_overtones_are_the_power_outside_the_sine(second, share):
    """On a rising stress, in each of two cycles that are shown whole; the third is not."""
    time = np.arange(0.0, 150.0, 0.005)
    ripple = np.sin(2.0 * np.pi * time / 1.3) + second * np.cos(4.0 * np.pi * time / 1.3)
    events = deep(cycles=3).events._replace(time=np.array([10.0, 70.0, 130.0]))
    found = measured.overtones(Deep(events, time, 1e-3 * ripple + 0.003 * time), 1.3)
    np.testing.assert_allclose(found, [share, share], atol=4e-3)


def test_the_parts_of_a_period_add_up():
    """v = 300 for 7 transits, 20 for 23, V = 100: y falls by eps (7 * 200), and rises by eps (23 * 80) less what does not fit."""
    scene = slipwave.read("paper")
    time = np.linspace(0.0, 30.0, 30001)[:-1]
    rate = np.where((time > 5.0) & (time < 12.0), 100.0 + 23.0 * 80.0 / 7.0, 20.0)
    y = 0.4 + scene.upper.epsilon * np.concatenate([[0.0], np.cumsum((100.0 - rate)[:-1] * 1e-3)])
    found = loading_of(orbit(30.0, 0.2, float(np.ptp(y))), OneCycle(time, rate, time, time, y, 30.0), scene)
    assert found == pytest.approx((30.0, 23.0 * 0.8, 7.0, 23.0 * 0.2), abs=0.01)


def test_recurrence_tells_periodic_from_irregular():
    random = np.random.default_rng(2)
    assert recurrence(np.tile([1.0, 3.0, 2.0, 7.0, 5.0], 20)) < 1e-12
    assert recurrence(np.tile(np.arange(12.0), 9) + 1e-3 * random.standard_normal(108)) < 0.01
    assert 0.8 < recurrence(random.standard_normal(200)) < 1.05
