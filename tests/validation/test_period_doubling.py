"""The ODE's orbit of T = 79.09 and its doubled one: verdicts from both sides."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from slipwave.observe.statistics import Estimate
from validation.studies.period_doubling import bubble_table
from validation.studies.period_doubling import measured as verdicts
from validation.studies.period_doubling.measured import Bubble, doubled, end
from validation.study import Outcome


@pytest.fixture(scope="module")
def found():
    return doubled()


def test_the_doubled_orbit(found):
    assert found.double.orbit.period.value == pytest.approx(158.1976822682, abs=1e-8)
    assert found.double.multipliers.stable is True
    assert found.single.multipliers.stable is False
    assert all(left.parameter < right.parameter for left, right in zip(found.bubble, found.bubble[1:], strict=False))
    assert {point.unstable for point in found.bubble} == {0}


def longer(orbit, share):
    period = orbit.orbit.period.value * (1.0 + share)
    return replace(orbit, orbit=replace(orbit.orbit, period=Estimate(period, 0.0)))


def changes(found):
    stable = replace(found.single, multipliers=found.double.multipliers)
    return {
        "none": found,
        "period": found._replace(single=longer(found.single, 1e-6)),
        "digits": found._replace(single=longer(found.single, 1e-4)),
        "unstable": found._replace(double=replace(found.double, multipliers=found.single.multipliers)),
        "stable": found._replace(single=stable),
        "run": found._replace(last_two=found.last_two * (1.0 + 2e-10)),
        "short": found._replace(bubble=found.bubble[4:]),
        "open": found._replace(special=found.special[:1]),
    }


@pytest.mark.parametrize(
    ("change", "outcomes"),
    [
        ("none", "pass pass pass pass pass"),
        ("period", "fail pass pass pass pass"),
        ("digits", "fail pass finding pass pass"),
        ("unstable", "pass pass finding pass pass"),
        ("stable", "pass pass finding pass pass"),
        ("run", "pass fail pass pass pass"),
        ("short", "pass pass pass pass fail"),
        ("open", "pass pass pass pass fail"),
    ],
)
def test_p10_the_run_and_the_bubble_from_both_sides(found, change, outcomes):
    """P10 needs an unstable orbit beside a stable one; each end of the bubble is at a doubling."""
    assert [verdict.outcome for verdict in verdicts.all_verdicts(changes(found)[change])] == outcomes.split()


def test_the_doubled_orbit_has_two_peaks(found):
    """Those of the cycles of a run; an orbit taken twice has no two different ones, half of it no second one."""
    assert verdicts.peaks(found.double) == pytest.approx((6572.745068, 6472.864768), rel=1e-5)
    half = verdicts.twice_but_not_the_same(found._replace(double=found.single))
    assert (half.outcome, half.ours.endswith("in 1.000000 T")) == (Outcome.FINDING, True)


def test_the_end_of_a_line():
    near, nearest = (SimpleNamespace(parameter=r, multipliers=[complex(m)]) for r, m in ((-2.5, 0.9), (-2.4, 0.95)))
    assert end(near, nearest) == pytest.approx(-2.3)


@pytest.mark.parametrize(("multiplier", "outcome"), [(-1.02, "pass"), (-0.98, "pass"), (-1.05, "fail"), (0.3, "fail")])
def test_a_bubble_must_end_at_a_doubling(multiplier, outcome):
    one = Bubble(-2.57, -2.54, multiplier, [], [("PD", -2.56), ("LP", -2.55), ("PD", -2.545)])
    assert verdicts.ends_simple(one).outcome == outcome
    assert bubble_table([one]).rows[0][2:] == ("−2.5600000, −2.5450000", "−2.5500000")
