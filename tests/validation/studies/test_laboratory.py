"""Others' experiments: a printed period, a known rise time, and friction that another program prints."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from shown import outcomes

from validation.studies.laboratory.measured import cycle_without_tuning, leeman_runs, printed_fits, rise_time
from validation.studies.laboratory.programs import fitted_to, on_programs, printed_rows


def test_the_plain_block_repeats_a_printed_period_and_slides_where_it_should() -> None:
    """14 and 8 MPa: 9.70 s and 15.3 mm/s by the third fit; steady sliding by the second."""
    found = cycle_without_tuning(leeman_runs()[6], printed_fits()[2][0])
    assert found
    assert (found.period, found.peak) == (pytest.approx(9.70, rel=2e-3), pytest.approx(15.3, rel=0.03))
    assert 0.035 < found.drop < 0.041
    assert cycle_without_tuning(leeman_runs()[1], printed_fits()[1][0]) is None


def test_the_rise_time_of_free_swinging_is_half_its_period() -> None:
    time = np.linspace(-1.0, 3.0, 4001)
    fall = np.where(time < 0.0, 1.0 + 1e-3 * time, np.where(time > 2.0, -1.0, np.cos(0.5 * math.pi * time)))
    assert rise_time(time, fall) == pytest.approx(2.0, rel=2e-3)


@pytest.mark.parametrize("row", printed_rows()[2:], ids=["step", "hold"])
def test_friction_that_another_program_prints_is_ours_and_gives_its_parameters_back(row: Mapping[str, Any]) -> None:
    found = fitted_to(row)
    assert 0.0 < found.apart < 1e-9  # nine digits are printed
    assert found.ratios == pytest.approx((1.0, 1.0, 1.0), abs=1e-6)
    friction = [value + 3e-9 * (k == 7) for k, value in enumerate(row["friction"])]
    wrong = fitted_to({**row, "friction": friction})
    assert outcomes([*on_programs([found]), *on_programs([wrong])]) == "pass pass fail pass"
    off = found._replace(ratios=found.ratios._replace(length=1.0 + 2e-5))
    assert outcomes([*on_programs([off])]) == "pass fail"
