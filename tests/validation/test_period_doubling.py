"""The ODE's orbit of T = 79.09 and its doubled one: verdicts from both sides."""

from dataclasses import replace
from types import SimpleNamespace

import pytest
from roomy import too_roomy
from shown import quick

from slipwave.observe.statistics import Estimate
from validation.studies.period_doubling import bubble_table
from validation.studies.period_doubling import measured as verdicts
from validation.studies.period_doubling.measured import Bubble, bubble, doubled, end
from validation.study import Outcome


@pytest.fixture(scope="module")
def result():
    return quick("period-doubling")


@pytest.fixture(scope="module")
def found():
    return doubled()


def test_every_verdict_holds(result):
    assert [v.claim for v in result.verdicts if v.outcome is not Outcome.PASS] == []
    assert len(result.verdicts) == 4
    assert too_roomy(result.verdicts) == []


def test_the_doubled_orbit(found):
    assert found.double.orbit.period.value == pytest.approx(158.1976822682, abs=1e-8)
    assert found.double.multipliers.stable is True
    assert found.single.multipliers.stable is False
    assert all(left.parameter < right.parameter for left, right in zip(found.bubble, found.bubble[1:], strict=False))
    assert {point.unstable for point in found.bubble} == {0}


def longer(orbit, share):
    period = orbit.orbit.period.value * (1.0 + share)
    return replace(orbit, orbit=replace(orbit.orbit, period=Estimate(period, 0.0)))


@pytest.mark.parametrize(("share", "outcomes"), [(0.0, ["pass", "pass"]), (1e-6, ["fail", "pass"]), (1e-4, ["fail", "finding"])])
def test_another_period_is_seen(found, share, outcomes):
    changed = found._replace(single=longer(found.single, share))
    assert [verdicts.published(changed).outcome, verdicts.p10(changed).outcome] == outcomes


def test_p10_needs_an_unstable_orbit_beside_a_stable_one(found):
    assert verdicts.p10(found._replace(double=found.single)).outcome is Outcome.FINDING
    stable = replace(found.single, multipliers=found.double.multipliers)
    assert verdicts.p10(found._replace(single=stable)).outcome is Outcome.FINDING


def test_a_run_that_ends_elsewhere_fails(found):
    assert verdicts.as_run(found._replace(last_two=found.last_two * (1.0 + 2e-10))).outcome is Outcome.FAIL


def test_a_bubble_that_ends_elsewhere_fails(found):
    assert verdicts.closes(found).outcome is Outcome.PASS
    assert verdicts.closes(found._replace(bubble=found.bubble[4:])).outcome is Outcome.FAIL
    assert verdicts.closes(found._replace(special=found.special[:1])).outcome is Outcome.FAIL


def test_the_end_of_a_line():
    near, nearest = (SimpleNamespace(parameter=r, multipliers=[complex(m)]) for r, m in ((-2.5, 0.9), (-2.4, 0.95)))
    assert end(near, nearest) == pytest.approx(-2.3)


def test_a_bubble_ends_where_its_halves_become_the_same():
    """The first pair, which ends at log10 r = -2.579381814: a line takes the square of the halves' difference to zero."""
    found = bubble(-2.6, -2.57)
    assert found.born == pytest.approx(-2.595727667, abs=1e-8)
    assert found.ends == pytest.approx(-2.579381814, abs=3e-5)
    assert found.multiplier == pytest.approx(-1.0, abs=0.03)
    assert found.special == []
    assert verdicts.ends_simple(found).outcome is Outcome.PASS


@pytest.mark.parametrize(("multiplier", "outcome"), [(-1.02, "pass"), (-0.98, "pass"), (-1.05, "fail"), (0.3, "fail")])
def test_a_bubble_must_end_at_a_doubling(multiplier, outcome):
    one = Bubble(-2.57, -2.54, multiplier, [], [("PD", -2.56), ("LP", -2.55), ("PD", -2.545)])
    assert verdicts.ends_simple(one).outcome == outcome
    assert bubble_table([one]).rows[0][2:] == ("−2.5600000, −2.5450000", "−2.5500000")
