import math

import pytest

from validation.studies.partial_reflection.measured import Pair, Point, agreement, dies, keeps, locking_leak, locks
from validation.study import Outcome


def test_where_the_interface_locks():
    assert locking_leak() == pytest.approx(2.0 / 11.0)


def test_a_lost_grip_and_a_wrong_end_turn_lights_red():
    points = [Point(77.0, 0.2, 5000.0), Point()]
    assert math.isnan(points[1].period)
    assert keeps((1e-3, 0.1), points).outcome is Outcome.FAIL
    assert keeps((1e-3, 0.1), points[:1] * 2).outcome is Outcome.PASS
    edge = 2.0 / 11.0
    assert locks({0.1: "steady", 0.15: "steady", 0.25: "locks"}, edge).outcome is Outcome.PASS
    for wrong in ({0.5: "steady"}, {0.1: "locks"}, {0.5: "still decaying"}):
        assert locks({0.1: "steady", 0.5: "locks"} | wrong, edge).outcome is Outcome.FAIL


@pytest.mark.parametrize("figure", range(3))
@pytest.mark.parametrize(("quick", "limit"), [(True, 5e-9), (False, 5e-10)])
def test_how_far_the_models_may_differ(figure, quick, limit):
    def outcome(off):
        exact = (77.0, 0.2, 5000.0)
        wave = tuple(value * (1.0 + off * (k == figure)) for k, value in enumerate(exact))
        return agreement([Pair(1.0, 1.0, Point(*exact), Point(*wave))], quick).outcome

    assert [outcome(0.9 * limit), outcome(-3.0 * limit)] == [Outcome.PASS, Outcome.FAIL]


ENDS = ["stick-slip", "stick-slip", "steady"]


@pytest.mark.parametrize(
    ("leaks", "outcome"),
    [((1e-5, 0.03, 0.045), "pass"), ((1e-5, 0.1, 0.2), "fail"), ((1e-5, 0.005, 0.006), "pass"), ((1e-5, 1e-3, 2e-3), "fail")],
)
def test_where_stick_slip_may_die(leaks, outcome):
    """(1 - R) T between 1/3 and 3, T = 77."""
    assert dies(leaks, ENDS, 77.0).outcome == outcome


def test_stick_slip_that_never_or_always_dies_is_red():
    assert dies((0.01, 0.02), ["stick-slip"] * 2, 77.0).outcome is Outcome.FAIL
    assert dies((0.01, 0.02), ["steady"] * 2, 77.0).outcome is Outcome.FAIL
