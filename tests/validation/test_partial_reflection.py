import math

import pytest

from validation.studies import load
from validation.studies.partial_reflection_runs import Pair, Point, locking_leak
from validation.studies.partial_reflection_verdicts import agreement, keeps, locks
from validation.study import Budget, Outcome

STUDY = load("partial-reflection")


@pytest.fixture(scope="module")
def result():
    return STUDY.run(Budget(quick=True))


def test_every_verdict_holds(result):
    assert [v.claim for v in result.verdicts if v.outcome is not Outcome.PASS] == []
    assert len(result.verdicts) == 4


def test_periods_at_matched_impedance(result):
    values = [number.value for number in result.numbers.values()]
    assert values == pytest.approx([185.5406, 114.2073], abs=1e-3)


@pytest.mark.parametrize("figure", range(2))
def test_figures_draw(result, figure):
    assert result.figures[figure].draw().axes


def test_where_the_interface_locks():
    assert locking_leak() == pytest.approx(2.0 / 11.0)


def test_a_lost_grip_and_a_wrong_end_turn_lights_red():
    points = [Point(77.0, 0.2, 5000.0), Point()]
    assert math.isnan(points[1].period)
    assert keeps((1e-3, 0.1), points).outcome is Outcome.FAIL
    assert locks({0.1: "steady", 0.5: "steady"}, 2.0 / 11.0).outcome is Outcome.FAIL
    pair = Pair(1.0, 1.0, Point(77.0, 0.2, 5000.0), Point(77.0, 0.2, 5000.1))
    assert agreement([pair]).outcome is Outcome.FAIL
