"""Studies of branches and of the snake: what they measure."""

from dataclasses import replace
from types import SimpleNamespace

import pytest
from shown import outcomes

import slipwave
from validation.measure.over_r import RANGE, branch_of, unaccounted
from validation.report import Outcome
from validation.studies import bifurcation as claims
from validation.studies.bifurcation.doubling import doubled
from validation.studies.snaking.measured import sides


def test_the_branch_of_the_studies_is_that_of_the_command():
    branch = branch_of("kelvin-voigt", -2.3, 61.0, 1e-6)
    found = slipwave.branch("paper", ("log10_r", *RANGE), model="kelvin-voigt", tol=1e-6, longest_period=61.0).summary
    ours = [("HB", branch.onset.parameter), *((one.kind, one.point.parameter) for one in branch.special)]
    assert [(one["type"], one["log10_r"]) for one in found["special"]] == ours
    assert [point["period"] for point in found["points"]] == [
        point.closed.cycle.period for point in branch.points if all(point is not one.point for one in branch.special)
    ]


def test_a_run_beside_a_special_point_shows_the_multiplier_that_passes():
    """Beside the first fold: on the stable side and on the unstable one."""
    branch = branch_of("delay", -2.69, 60.0)
    before, beyond = sides(branch)
    assert ([one.kind for one in branch.special], before.log10_r < -2.69, beyond.log10_r < -2.69) == (["LP"], True, True)
    assert before.orbit.real > 1.0 > beyond.orbit.real
    assert before.seen == pytest.approx(before.orbit, abs=1e-6)
    assert beyond.seen == pytest.approx(beyond.orbit, abs=1e-6)


def special(kind, log10_r, before=0, after=1, period=80.0):
    return SimpleNamespace(kind=kind, point=point(log10_r, after, period), unstable_before=before, unstable_after=after)


def point(log10_r, unstable, period=80.0):
    closed = SimpleNamespace(cycle=SimpleNamespace(period=period), flow=SimpleNamespace(size=49))
    return SimpleNamespace(parameter=log10_r, unstable=unstable, closed=closed)


def made(model, *found, points=()):
    """A branch of given special points."""
    return SimpleNamespace(
        model=model,
        onset=SimpleNamespace(parameter=-2.7),
        points=points or tuple(one.point for one in found),
        special=found,
        of_kind=lambda *kinds: [one for one in found if one.kind in kinds],
    )


def test_the_index_counts_what_no_point_explains():
    fold, torus = special("LP", -2.71, 1, 0), special("NS", -2.6, 0, 2)
    whole = (point(-2.7, 1), fold.point, point(-2.65, 0), torus.point, point(-2.5, 2))
    assert unaccounted(made("delay", fold, torus, points=whole)) == 0
    assert claims.index([made("delay", fold, torus, points=whole)]).outcome is Outcome.PASS
    missed = (*whole[:2], point(-2.65, 1), *whole[3:])
    assert unaccounted(made("delay", fold, torus, points=missed)) == 1
    assert claims.index([made("delay", fold, torus, points=missed)]).outcome is Outcome.FAIL
    wrong = special("PD", -2.6, 0, 2)
    assert unaccounted(made("delay", wrong, points=(point(-2.7, 0), wrong.point))) == 1


def test_coexisting_orbits_are_all_found():
    branch = branch_of("kelvin-voigt", -2.3, 61.0)
    periods = [orbit.cycle.period for orbit in branch.orbits_at(-2.7)]
    assert periods == pytest.approx([55.082257, 60.584973], abs=1e-5)
    assert branch.orbits_at(-2.69) == []
    shifted = replace(branch, onset=branch.onset._replace(parameter=branch.onset.parameter + 1e-8))
    assert outcomes(claims.published([branch, shifted])) == "pass fail"


@pytest.fixture(scope="module")
def found():
    return doubled()


def test_the_doubled_orbit(found):
    assert found.double.orbit.period.value == pytest.approx(158.1976822682, abs=1e-8)
    assert found.double.multipliers.stable is True
    assert found.single.multipliers.stable is False
