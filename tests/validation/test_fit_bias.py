"""The study `bias`: its stored fits, its rule, and that counterfeit figures turn it red (`shown.quick`)."""

import pytest
from shown import quick

from validation.study import Outcome


@pytest.mark.slow
def test_waves_left_out_bias_a_quasi_dynamic_fit_most() -> None:
    result = quick("bias")
    assert [verdict.claim for verdict in result.verdicts if verdict.outcome is not Outcome.PASS] == []
    limits = {name.removesuffix(" share with 1 %"): number.value for name, number in result.numbers.items()}
    assert limits["quasidynamic"] < limits["quasistatic"] < limits["block12"]
    assert limits["quasidynamic"] == pytest.approx(10.0**-2.5)
    assert [row[0] for row in result.tables[1].rows] == ["delay", *limits]
