"""The attacks' runs: limits are found where they are, errors are told from messages, noise stays."""

import math

import pytest

from validation.studies.attack_runs import CELLS, Outcome, attack, limit_at, locked_noise, stops_beyond


@pytest.mark.parametrize("model", ["fd", "sbp:4", "fem:4", "dg:7"])
def test_limit_is_the_declared_one_and_does_not_move(model):
    assert limit_at(model, 0) == pytest.approx(1.0, abs=0.06)
    assert limit_at(model, 8) == pytest.approx(1.0, abs=0.06)
    assert stops_beyond(model, 1.2)
    assert not stops_beyond(model, 0.9)


@pytest.mark.parametrize("name", ["epsilon 2", "V -6", "impedance", "jump"])
def test_attacks_end_right_or_with_a_message(name):
    found = attack(name)
    assert set(found) == set(CELLS)
    assert not any(outcome.silently_wrong(1e-4) for outcome in found.values())


@pytest.mark.parametrize("model", ["fd", "sbp:6", "dg:4"])
def test_noise_gains_no_energy(model):
    assert 0.0 < locked_noise(model, 200.0) <= 1.001


def test_silence_is_what_counts():
    assert Outcome(1.0, 0).silently_wrong(0.1)
    assert Outcome(math.nan, 0).silently_wrong(0.1)
    assert not Outcome(1.0, 3).silently_wrong(0.1)
    assert not Outcome(math.nan, 0, "too stiff").silently_wrong(0.1)
