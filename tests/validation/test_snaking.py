"""Studies of branches and of the snake: their verdicts from both sides."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from shown import outcomes

import slipwave
from slipwave.observe.statistics import Estimate
from validation.studies import bifurcation as claims
from validation.studies.bifurcation import doubling
from validation.studies.bifurcation.doubling import bubble, doubled
from validation.studies.bifurcation.folds import fold_verdicts
from validation.studies.snaking import measured as snake
from validation.studies.snaking.measured import multiplier_seen, sides
from validation.study import Outcome
from validation.study.over_r import RANGE, branch_of, unaccounted


def run(periods, orbit=78.0, settled=True, log10_r=-2.66, size=0.5):
    return snake.DirectRun(log10_r, size, np.array(periods), settled, orbit)


def orbit(period, multiplier=0.5 + 0.6j):
    parts = [[multiplier.real, -multiplier.imag, 0.0], [multiplier.imag, multiplier.real, 0.0], [0.0, 0.0, 1.0]]
    flow = SimpleNamespace(idle=np.zeros((3, 0)))
    return SimpleNamespace(flow=flow, cycle=SimpleNamespace(period=period), monodromy=np.array(parts))


@pytest.mark.parametrize("multiplier", [-1.003, 0.4, 0.5 + 0.9j])
def test_the_multiplier_by_which_two_runs_part(multiplier):
    """The distance of each sample has a phase of its own."""
    phases = np.exp(1j * np.linspace(0.0, 6.0, 50))
    apart = np.real(multiplier ** np.arange(5)[:, None] * phases)
    assert multiplier_seen(apart, bool(np.imag(multiplier))) == pytest.approx(multiplier, abs=1e-12)


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


def test_a_run_is_compared_with_the_nearest_stable_orbit(monkeypatch):
    seen = SimpleNamespace(period=np.array([78.4] * 8))
    ended = SimpleNamespace(observer=SimpleNamespace(events=lambda after: seen), transits=100.0, settled=True)
    monkeypatch.setattr("validation.study.memo.settled", lambda *given: ended)
    orbits = [orbit(77.0), orbit(78.3, multiplier=1.2 + 0.1j), orbit(79.0)]
    assert snake.run_at(-2.66, 2.0, orbits).orbit == 79.0
    assert snake.run_at(-2.6565, 0.5, orbits[1:2]).orbit == 78.3


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


def branch(*found):
    return made("", *found, points=(point(-2.6, 0),))


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


SHARE = math.log10(1.001)
KNOWN = -2.7002517033


@pytest.fixture(scope="module")
def found():
    return doubled()


@pytest.fixture(scope="module")
def ode_branch():
    return branch_of("kelvin-voigt", -2.579, 200.0)


def test_the_doubled_orbit(found):
    assert found.double.orbit.period.value == pytest.approx(158.1976822682, abs=1e-8)
    assert found.double.multipliers.stable is True
    assert found.single.multipliers.stable is False


def longer(orbit, share):
    period = orbit.orbit.period.value * (1.0 + share)
    return replace(orbit, orbit=replace(orbit.orbit, period=Estimate(period, 0.0)))


def test_p10_the_run_and_the_bubble_from_both_sides(found, ode_branch):
    """P10 needs an unstable orbit beside a stable one; the bubble ends at a doubling."""
    stable = replace(found.single, multipliers=found.double.multipliers)
    double = replace(found.double, multipliers=found.single.multipliers)
    closed = bubble(*doubling.PAIRS[0])
    assert closed.born == pytest.approx(ode_branch.of_kind("PD")[0].point.parameter, abs=1e-10)
    for one, own, expected in (
        (found, closed, "pass pass pass pass pass"),
        (found._replace(single=longer(found.single, 1e-6)), closed, "fail pass pass pass pass"),
        (found._replace(single=longer(found.single, 1e-4)), closed, "fail pass finding pass pass"),
        (found._replace(double=double), closed, "pass pass finding pass pass"),
        (found._replace(single=stable), closed, "pass pass finding pass pass"),
        (found._replace(last_two=found.last_two * (1.0 + 2e-10)), closed, "pass fail pass pass pass"),
        (found, closed._replace(ends=closed.ends + 2e-5), "pass pass pass pass fail"),
    ):
        assert outcomes(doubling.doubling_verdicts(one, ode_branch, [own])) == expected


def test_the_doubled_orbit_has_two_peaks(found):
    """Those of the cycles of a run; an orbit taken twice has no two different ones, half of it no second one."""
    assert doubling.peaks(found.double) == pytest.approx((6572.745068, 6472.864768), rel=1e-5)
    half = doubling.twice_but_not_the_same(found._replace(double=found.single))
    assert (half.outcome, half.ours.endswith("in 1.000000 T")) == (Outcome.FINDING, True)


def ode(kinds, torus):
    return made("kelvin-voigt", *(special(kind, torus if kind == "NS" else -2.5) for kind in kinds.split()))


def folds(*growth, last=-2.7):
    """The first fold and pairs of folds that lie about a transit apart."""
    turns = (74.0, 75.0, *(75.0 + one for one in growth))
    pairs = [special("LP", -2.7, period=turn + shift) for turn in turns for shift in (0.0, 0.3)]
    pairs[-1].point.parameter = last
    return [special("LP", -2.7, period=59.0), *pairs]


def folds_over(shift=0.0, beside=KNOWN):
    """V larger and r smaller by a thousandth are one fold."""
    return {"delay": [(KNOWN, 100.0), (KNOWN - SHARE, 100.1)], "kelvin-voigt": [(beside, 100.0)]}, KNOWN - SHARE + shift


FOLD = made("delay", special("LP", -2.7007, 1, 0))
TORUS, DOUBLING = special("NS", -2.65, 0, 2), special("PD", -2.6, 0, 1)
BUBBLES = "LP PD PD LP LP PD PD LP LP PD PD NS"
JUDGED = [
    (snake.settles, ([run([78.0 + 1e-9] * 8), run([78.0 + 1e-6] * 8)],), "pass fail"),
    (snake.settles, ([run([78.0 + 1e-9] * 8, settled=False)],), "fail"),
    (snake.wanders, (run([77.9, 78.1], settled=False),), "pass"),
    (snake.wanders, (run([77.9, 78.1]),), "fail"),
    (snake.wanders, (run([78.01, 78.1], settled=False),), "fail"),
    (snake.wanders, (run([78.0, 78.0], settled=False),), "fail"),
    (snake.fold_claims, (branch(*folds(0.98)), branch(*folds(0.98))), "pass pass pass"),
    (snake.fold_claims, (branch(*folds(0.98)), branch(*folds(0.98, last=-2.7 + 2e-8))), "fail pass pass"),
    (snake.fold_claims, (branch(*folds(0.98)), branch(*folds(0.98)[:-1])), "pass fail pass"),
    (snake.fold_claims, (branch(*folds(0.98)[:-1]), branch(*folds(0.98))), "pass fail pass"),
    *((snake.fold_claims, (branch(*folds(n)),) * 2, f"pass pass {end}") for n, end in
      ((1.15, "pass"), (1.25, "fail"), (0.75, "fail"))),
    (snake.coexisting, ([run([], 77.0), run([], 78.0, size=2.0)],), "pass"),
    (snake.coexisting, ([run([], 77.0), run([], 77.0, size=2.0)],), "fail"),
    (snake.coexisting, ([run([], 77.0), run([], 78.0, log10_r=-2.65)],), "fail fail"),
    # P8 needs a fold below the onset that gives stability
    (claims.mildly_subcritical, (FOLD, made("kelvin-voigt", special("LP", -2.7007, 1, 0))), "pass"),
    (claims.mildly_subcritical, (FOLD, made("kelvin-voigt", special("LP", -2.6993, 1, 0))), "finding"),
    (claims.mildly_subcritical, (FOLD, made("kelvin-voigt", special("LP", -2.7007, 2, 1))), "finding"),
    (claims.mildly_subcritical, (FOLD, made("kelvin-voigt", special("PD", -2.7007, 1, 0))), "finding"),
    # P9 needs the order of the points and the place of the torus, P14 compares what takes stability first
    (claims.bubbles_of, (ode(BUBBLES, -2.4682),), "pass pass"),
    (claims.bubbles_of, (ode(BUBBLES, -2.469),), "pass finding"),
    (claims.bubbles_of, (ode("LP PD PD LP LP PD PD NS", -2.468),), "finding pass"),
    (claims.unlike, (made("delay", TORUS, DOUBLING), made("kelvin-voigt", DOUBLING, TORUS)), "finding"),
    (claims.unlike, (made("delay", DOUBLING, TORUS), made("kelvin-voigt", DOUBLING, TORUS)), "pass"),
    # at V = 100 the Hopf point lies at -2.6995497; one per cent of r is 0.0044
    (fold_verdicts, folds_over(shift=5e-12), "pass pass pass"),
    (fold_verdicts, folds_over(shift=2e-11), "fail pass pass"),
    (fold_verdicts, folds_over(beside=-2.6993), "pass pass finding"),
    (fold_verdicts, folds_over(beside=-2.7045), "pass pass finding"),
]  # fmt: skip


@pytest.mark.parametrize(("study", "given", "expected"), JUDGED)
def test_verdicts_from_both_sides(study, given, expected):
    assert outcomes(study(*given)) == expected
