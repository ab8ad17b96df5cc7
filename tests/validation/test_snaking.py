"""The snake of the delay system's orbits: its verdicts from both sides, and the multiplier that a run shows."""

from types import SimpleNamespace

import numpy as np
import pytest
from roomy import too_roomy
from shown import quick

from validation.studies.snaking import verdicts
from validation.studies.snaking.runs import Run, multiplier_of
from validation.study import Outcome


@pytest.fixture(scope="module")
def result():
    return quick("snaking")


def test_every_verdict_holds(result, as_recorded):
    assert [v.claim for v in result.verdicts if v.outcome is not Outcome.PASS] == []
    assert len(result.verdicts) == 6
    as_recorded("snaking", result)
    assert too_roomy(result.verdicts) == []


def test_three_orbits_coexist(result):
    rows = result.tables[2].rows
    assert [row[1] for row in rows] == pytest.approx([77.46265115, 77.78897533, 78.08866464], abs=1e-7)
    assert [row[4] for row in rows] == [0.0, 1.0, 0.0]


def run(periods, settled=True):
    return Run(-2.66, np.array(periods), np.array(periods[-8:]), settled)


def orbit(period, multiplier=0.5 + 0.6j):
    parts = [[multiplier.real, -multiplier.imag, 0.0], [multiplier.imag, multiplier.real, 0.0], [0.0, 0.0, 1.0]]
    return SimpleNamespace(cycle=SimpleNamespace(period=period), monodromy=np.array(parts))


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


def special(kind, log10_r, period):
    closed = SimpleNamespace(cycle=SimpleNamespace(period=period), flow=SimpleNamespace(size=49))
    return SimpleNamespace(kind=kind, point=SimpleNamespace(parameter=log10_r, closed=closed))


def branch(*found):
    folds = [one for one in found if one.kind == "LP"]
    return SimpleNamespace(special=found, points=(special("", -2.6, 80.0).point,), of_kind=lambda kind: folds)


def test_two_meshes_must_find_the_same_points():
    first, second = special("LP", -2.7, 59.0), special("NS", -2.65, 78.0)
    moved = special("NS", -2.65 + 2e-8, 78.0)
    both = branch(first, second)
    assert [v.outcome for v in verdicts.meshes(both, both)] == [Outcome.PASS, Outcome.PASS]
    assert [v.outcome for v in verdicts.meshes(both, branch(first, moved))] == [Outcome.FAIL, Outcome.PASS]
    assert verdicts.meshes(both, branch(first))[1].outcome is Outcome.FAIL
    assert verdicts.meshes(branch(first), both)[1].outcome is Outcome.FAIL


@pytest.mark.parametrize(("growth", "outcome"), [(0.98, "pass"), (1.15, "pass"), (1.25, "fail"), (0.75, "fail")])
def test_a_pair_of_folds_for_each_transit(growth, outcome):
    turns = [74.0, 75.0, 75.0 + growth]
    folds = [special("LP", -2.7, period) for turn in turns for period in (turn, turn + 0.3)]
    assert verdicts.once_per_transit(branch(special("LP", -2.7, 59.0), *folds)).outcome == outcome
