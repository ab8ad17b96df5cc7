"""Margins of means over cycles that depend on each other, against signals whose mean is known."""

from dataclasses import asdict

import numpy as np
import pytest

from slipwave.observe.events import Events
from slipwave.observe.statistics import BATCHES, margin_of_mean, summarise

RUNS = 400


def autoregressive(memory: float, count: int) -> np.ndarray:
    """Rows with mean 0 and correlation memory^k between values k apart."""
    noise = np.random.default_rng(11).standard_normal((RUNS, count + 100))
    rows = noise.copy()
    for k in range(1, count + 100):
        rows[:, k] += memory * rows[:, k - 1]
    return rows[:, 100:]


def covered(rows: np.ndarray) -> float:
    """The share of rows whose mean differs from 0 by no more than its margin."""
    return float(np.mean([abs(row.mean()) <= margin_of_mean(row) for row in rows]))


@pytest.mark.parametrize("memory", [-0.7, 0.0, 0.5])
@pytest.mark.parametrize("count", [64, 256])
def test_the_true_mean_is_within_the_margin_in_95_of_100_runs(memory: float, count: int) -> None:
    assert 0.90 <= covered(autoregressive(memory, count)) <= 0.99


def test_few_cycles_that_resemble_each_other() -> None:
    """Of 24 values with memory 0.5, 92 of 100 means lie within the margin; by batches alone 89."""
    assert covered(autoregressive(0.5, 24)) >= 0.91


def test_by_hand() -> None:
    """Batches of two with means 1, 2, ..., 8, in an order without memory: their deviation is sqrt(6)."""
    values = np.repeat([1.0, 8.0, 3.0, 6.0, 5.0, 4.0, 7.0, 2.0], 2) + np.tile([0.25, -0.25], BATCHES)
    assert margin_of_mean(values) == pytest.approx(2.364624251 * np.sqrt(6.0) / np.sqrt(8.0), rel=1e-9)
    assert np.isnan(margin_of_mean(values[: BATCHES - 1]))


def test_only_cycles_that_never_repeat_have_margins() -> None:
    column = np.linspace(1.0, 2.0, 16)
    events = Events(*[column] * 6)
    assert all(np.isnan(margin) for margin in asdict(summarise(events).margins).values())
    assert asdict(summarise(events, repeat=False).margins) == dict.fromkeys(
        ("period", "stress_drop", "elastic_stress_drop"), margin_of_mean(column)
    )
