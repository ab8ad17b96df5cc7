"""Others' experiments: samples, bands and rise times are what they say; verdicts turn when the numbers do."""

import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import pytest

from validation.studies.laboratory import (
    LAWS,
    NAMES,
    Band,
    BlockWaves,
    Case,
    against_measured,
    band_of,
    measured_figure,
    on_rises,
    on_waves,
    over_stress,
    row_met,
)
from validation.studies.laboratory.measured import (
    MeasuredCycle,
    Rise,
    cycle_without_tuning,
    leeman_runs,
    printed_fits,
    rise_time,
    samples,
)
from validation.studies.laboratory.programs import fitted_to, on_programs, printed_rows
from validation.study import Verdict


def outcomes(verdicts: Iterable[Verdict]) -> list[str]:
    return [verdict.outcome.value for verdict in verdicts]


def test_the_plain_block_repeats_a_printed_period_and_slides_where_it_should() -> None:
    """14 and 8 MPa: 9.70 s and 15.3 mm/s by the third fit; steady sliding by the second."""
    found = cycle_without_tuning(leeman_runs()[6], printed_fits()[2][0])
    assert found
    assert (found.period, found.peak) == (pytest.approx(9.70, rel=2e-3), pytest.approx(15.3, rel=0.03))
    assert 0.035 < found.drop < 0.041
    assert cycle_without_tuning(leeman_runs()[1], printed_fits()[1][0]) is None


def test_samples_have_the_printed_means_and_deviations() -> None:
    drawn = samples(3000)
    for k, (mean, deviation) in enumerate(printed_fits()):
        own = np.array([fit for fit, _ in drawn[k::3]])
        np.testing.assert_allclose(own.mean(axis=0), mean, atol=0.15 * max(deviation), rtol=0.02)
        np.testing.assert_allclose(own.std(axis=0), deviation, rtol=0.1)
    assert np.std(np.log([factor for _, factor in drawn])) == pytest.approx(0.05, rel=0.1)
    assert samples(5) == drawn[:5]


def test_the_rise_time_of_free_swinging_is_half_its_period() -> None:
    time = np.linspace(-1.0, 3.0, 4001)
    fall = np.where(time < 0.0, 1.0 + 1e-3 * time, np.where(time > 2.0, -1.0, np.cos(0.5 * math.pi * time)))
    assert rise_time(time, fall) == pytest.approx(2.0, rel=2e-3)


def made(factor: dict[str, float], slips: float = 1.0, meets: int = 1) -> list[Case]:
    """Cases whose bands lie `factor` times the measured values."""

    def bands(row: Mapping[str, Any]) -> dict[str, Band]:
        middle = {name: measured_figure(row, name) * factor.get(name, 1.0) for name in NAMES}
        return {name: Band(0.9 * value, value, 1.1 * value) for name, value in middle.items()}

    return [Case(row, law, slips, bands(row), meets) for law in LAWS for row in leeman_runs()]


def test_verdicts_on_what_was_measured_turn_with_the_numbers() -> None:
    assert outcomes(against_measured(made({}))) == ["pass"] * 5
    for k, name in enumerate(NAMES, 1):
        assert outcomes(against_measured(made({name: 1.5})))[k] == "finding"
    assert outcomes(against_measured(made({}, slips=0.4)))[0] == "finding"
    assert outcomes(against_measured(made({}, meets=0)))[4] == "finding"
    assert row_met(made({}, meets=0)[:7] + made({})[7:]) == [True] * 7
    assert math.isnan(band_of([1.0, 2.0]).median)
    assert band_of([1.0, 2.0, 4.0]).median == 2.0


def test_verdicts_on_waves_and_rise_times_turn_with_the_numbers() -> None:
    block = MeasuredCycle(8.7, 0.0385, 8.5)
    measured = measured_figure(leeman_runs()[2], "peak")
    right = BlockWaves(block, block._replace(peak=8.6), block._replace(peak=1.5 * measured))
    assert outcomes(on_waves(right)) == ["pass", "pass"]
    assert outcomes(on_waves(BlockWaves(block, block._replace(period=9.5), block._replace(peak=230.0)))) == ["fail", "finding"]
    rises = [Rise(drop, 18.0 + 0.1 * drop) for drop in (0.1, 0.3)]
    assert outcomes([on_rises(rises), on_rises([rises[0], rises[1]._replace(time=54.0)])]) == ["pass", "fail"]


def test_the_figure_shows_what_was_measured() -> None:
    panels = over_stress(made({"peak": 5.0})).panels
    for panel, name in zip(panels, NAMES, strict=True):
        np.testing.assert_allclose(panel.traces[-1].y, [measured_figure(row, name) for row in leeman_runs()])
    np.testing.assert_allclose(panels[2].traces[1].y, [5.0 * row["peak_mm_s"] for row in leeman_runs()])


@pytest.mark.parametrize("row", printed_rows()[2:], ids=["step", "hold"])
def test_friction_that_another_program_prints_is_ours_and_gives_its_parameters_back(row: Mapping[str, Any]) -> None:
    found = fitted_to(row)
    assert 0.0 < found.apart < 1e-9  # nine digits are printed
    assert found.ratios == pytest.approx((1.0, 1.0, 1.0), abs=1e-6)
    friction = [value + 3e-9 * (k == 7) for k, value in enumerate(row["friction"])]
    wrong = fitted_to({**row, "friction": friction})
    assert outcomes([*on_programs([found]), *on_programs([wrong])]) == ["pass", "pass", "fail", "pass"]
    off = found._replace(ratios=found.ratios._replace(length=1.0 + 2e-5))
    assert outcomes([*on_programs([off])]) == ["pass", "fail"]
