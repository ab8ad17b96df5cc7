"""The snake of the delay system's orbits: its verdicts from both sides, and the multiplier that a run shows."""

from types import SimpleNamespace

import numpy as np
import pytest

from validation.studies.snaking import measured as verdicts
from validation.studies.snaking.measured import (
    Attractor,
    Run,
    attractor,
    in_thicker_slabs,
    multiplier_of,
    multiplier_seen,
    passages,
    sides,
)
from validation.study.memo import own_orbit
from validation.study.over_r import branch_of, scene_at


def run(periods, settled=True):
    return Run(-2.66, np.array(periods), np.array(periods[-8:]), settled)


def orbit(period, multiplier=0.5 + 0.6j):
    parts = [[multiplier.real, -multiplier.imag, 0.0], [multiplier.imag, multiplier.real, 0.0], [0.0, 0.0, 1.0]]
    flow = SimpleNamespace(idle=np.zeros((3, 0)))
    return SimpleNamespace(flow=flow, cycle=SimpleNamespace(period=period), monodromy=np.array(parts))


def spiral(multiplier, count=80):
    return 78.0 + np.real(0.7j * multiplier ** np.arange(count))


@pytest.mark.parametrize("multiplier", [-0.06 + 0.81j, 0.5 + 0.6j, -0.7 + 0.1j])
def test_the_multiplier_of_a_spiral(multiplier):
    assert multiplier_of(run(spiral(multiplier)), 78.0) == pytest.approx(multiplier, abs=1e-9)


@pytest.mark.parametrize(
    ("period", "multiplier", "settled", "outcomes"),
    [
        (78.0, 0.5 + 0.6j, True, ["pass", "pass"]),
        (78.0, 0.5 - 0.6j, True, ["pass", "pass"]),
        (78.0, 0.5 + 0.602j, True, ["pass", "fail"]),
        (78.0, 0.5 + 0.6j, False, ["fail", "pass"]),
        (78.0 + 1e-6, 0.5 + 0.6j, True, ["fail", "fail"]),
    ],
)
def test_a_run_and_the_orbit_it_settles_on(period, multiplier, settled, outcomes):
    found = verdicts.settles(run(spiral(0.5 + 0.6j), settled), orbit(period, multiplier))
    assert [verdict.outcome for verdict in found] == outcomes


@pytest.mark.parametrize(
    ("periods", "settled", "outcome"),
    [([77.9, 78.1], False, "pass"), ([77.9, 78.1], True, "fail"), ([78.01, 78.1], False, "fail"), ([78.0, 78.0], False, "fail")],
)
def test_a_run_beyond_the_torus_point_stays_around_the_orbit(periods, settled, outcome):
    assert verdicts.wanders(run(periods, settled), orbit(78.0)).outcome == outcome


@pytest.mark.parametrize("multiplier", [-1.003, 0.4, 0.5 + 0.9j])
def test_the_multiplier_by_which_two_runs_part(multiplier):
    """The distance of each sample has a phase of its own."""
    phases = np.exp(1j * np.linspace(0.0, 6.0, 50))
    apart = np.real(multiplier ** np.arange(5)[:, None] * phases)
    assert multiplier_seen(apart, bool(np.imag(multiplier))) == pytest.approx(multiplier, abs=1e-12)


def test_a_run_beside_a_special_point_shows_the_multiplier_that_passes():
    """Beside the first fold: on the stable side and on the unstable one."""
    branch = branch_of("delay", -2.69, 60.0)
    ((fold, before, beyond),) = sides(branch)
    assert (fold.kind, before.log10_r < -2.69, beyond.log10_r < -2.69) == ("LP", True, True)
    assert before.orbit.real > 1.0 > beyond.orbit.real
    assert before.seen == pytest.approx(before.orbit, abs=1e-6)
    assert beyond.seen == pytest.approx(beyond.orbit, abs=1e-6)


def special(kind, log10_r, period):
    closed = SimpleNamespace(cycle=SimpleNamespace(period=period), flow=SimpleNamespace(size=49))
    return SimpleNamespace(kind=kind, point=SimpleNamespace(parameter=log10_r, closed=closed))


def branch(*found):
    folds = [one for one in found if one.kind == "LP"]
    return SimpleNamespace(special=found, points=(special("", -2.6, 80.0).point,), of_kind=lambda kind: folds)


FOLDS = [special("LP", -2.7, 59.0), *(special("LP", -2.7, turn + shift) for turn in (74.0, 75.0, 75.98) for shift in (0.0, 0.3))]


@pytest.mark.parametrize(
    ("found", "finer", "outcomes"),
    [
        (FOLDS, FOLDS, ["pass", "pass"]),
        (FOLDS, [*FOLDS[:-1], special("LP", -2.7 + 2e-8, 76.28)], ["fail", "pass"]),
        (FOLDS, FOLDS[:-1], ["pass", "fail"]),
        (FOLDS[:-1], FOLDS, ["pass", "fail"]),
    ],
)
def test_two_meshes_must_find_the_same_points(found, finer, outcomes):
    told = verdicts.branch_claims(branch(*found), branch(*finer))
    assert [next(told).outcome, next(told).outcome] == outcomes


@pytest.mark.parametrize(("growth", "outcome"), [(0.98, "pass"), (1.15, "pass"), (1.25, "fail"), (0.75, "fail")])
def test_a_pair_of_folds_for_each_transit(growth, outcome):
    turns = [special("LP", -2.7, period) for turn in (74.0, 75.0, 75.0 + growth) for period in (turn, turn + 0.3)]
    both = branch(special("LP", -2.7, 59.0), *turns)
    assert list(verdicts.branch_claims(both, both))[2].outcome == outcome


@pytest.fixture(scope="module")
def exact():
    return own_orbit("delay", scene_at(-2.68), 1e-11).closed


@pytest.mark.parametrize("turns", [0, 1, 2, 3])
def test_an_orbit_is_one_of_much_thicker_slabs_too(exact, turns):
    """r only sets the delay of the waves on the clock of friction: the motion of an orbit of T transits at r is that of one of
    T/(1 + k T) transits at r (1 + k T), where waves are late by k periods more. Measured: 6e-12;
    an error of the period enters k times."""
    period = exact.cycle.period
    assert in_thicker_slabs(exact, turns, period) < 1e-10
    wrong = [in_thicker_slabs(exact, turns, period * (1.0 + change)) for change in (1e-8, 1e-7)]
    assert wrong == pytest.approx([5.304e-6 * turns, 5.304e-5 * turns], rel=0.01, abs=1e-10)


def attracted(last, period, settled=True, log10_r=-2.66):
    return Attractor(0.5, run([last * (1.0 + 1e-12)] * 8, settled)._replace(log10_r=log10_r), period)


@pytest.mark.parametrize(
    ("second", "outcomes"),
    [
        (attracted(78.0, 78.0), ["pass", "pass"]),
        (attracted(77.0, 77.0), ["pass", "fail"]),
        (attracted(78.0 + 5e-7, 78.0), ["fail", "pass"]),
        (attracted(78.0, 78.0, settled=False), ["fail", "pass"]),
        (attracted(78.0, 78.0, log10_r=-2.65), ["pass", "fail"]),
    ],
)
def test_two_orbits_must_attract_runs_at_one_r(second, outcomes):
    assert [verdict.outcome for verdict in verdicts.coexisting([attracted(77.0, 77.0), second])] == outcomes


def test_a_run_is_compared_with_the_nearest_stable_orbit(monkeypatch):
    monkeypatch.setattr("validation.studies.snaking.measured.run_at", lambda log10_r, size: run([78.4] * 8))
    orbits = [orbit(77.0), orbit(78.3, multiplier=1.2 + 0.1j), orbit(79.0)]
    assert attractor(-2.66, 2.0, orbits).orbit == 79.0


def test_passages_of_a_level():
    """Upwards, and once in a cycle though the motion ripples about the level."""
    time = np.linspace(0.0, 320.0, 320001)
    pulses = 2.0 * np.exp(-(((time % 80.0) - 40.0) ** 2) / 20.0)
    ripples = 0.4 * np.sin(2.0 * np.pi * time) * (np.abs(pulses - 1.0) < 0.9)
    found = passages(time, pulses + ripples - 3.0, -2.0)
    assert (np.diff(np.sign(pulses + ripples - 1.0)) > 0).sum() > 4
    assert found == pytest.approx(40.0 - np.sqrt(20.0 * np.log(2.0)) + 80.0 * np.arange(4), abs=1.5)
    assert np.diff(found) == pytest.approx([80.0] * 3, abs=1e-6)
