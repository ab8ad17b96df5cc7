"""The attacks' runs: steps past the limit stop, errors and messages are distinguished, advice is followed, noise stays."""

import math

import pytest

from validation.studies.stability_attacks.limits import _largest, stops_beyond
from validation.studies.stability_attacks.runs import CELLS, AttackOutcome, advised, attack, locked_noise


@pytest.mark.parametrize("model", CELLS)
def test_a_step_past_the_limit_ends_with_a_message(model):
    assert stops_beyond(model, 1.2)
    assert not stops_beyond(model, 0.9)


@pytest.mark.parametrize("name", ["epsilon 2", "V -6", "impedance", "jump"])
def test_attacks_end_right_or_with_a_message(name):
    found = attack(name)
    assert set(found) == set(CELLS)
    assert not any(outcome.silently_wrong(1e-4) for outcome in found.values())


@pytest.mark.parametrize("name", ["V 4", "jump back"])
def test_late_cycles_are_right(name):
    assert not any(outcome.silently_wrong(1e-2, 2e-2) for outcome in attack(name, late=True).values())


@pytest.mark.parametrize("model", ["sbp:4", "fem:4"])
def test_cells_that_the_message_asks_for_make_the_run_right(model):
    advice = advised(model)
    assert 0 < advice.stopped < advice.cells
    assert "relaxes at" in advice.message
    assert "more cells or a smaller cfl" in advice.message
    assert advice.error < 1e-6


@pytest.mark.parametrize("model", ["fd", "sbp:6", "dg:4"])
def test_noise_gains_no_energy(model):
    assert 0.0 < locked_noise(model, 200.0) <= 1.0 + 1e-4


def test_silence_is_what_counts():
    assert AttackOutcome(1.0).silently_wrong(0.1)
    assert AttackOutcome(math.nan).silently_wrong(0.1)
    assert AttackOutcome(0.0, 1.0).silently_wrong(0.1, 0.1)
    assert not AttackOutcome(math.nan, message="too stiff").silently_wrong(0.1)


@pytest.mark.parametrize(("edge", "found"), [(0.7, 0.0), (0.9, 0.9), (1.2, 1.2), (1.6, 1.5)])
def test_the_search_for_a_limit_says_where_it_ends(edge, found):
    """Between 0.8 and 1.5 to 1 per cent; beyond, 0 and 1.5."""
    assert _largest(lambda share: share < edge) == pytest.approx(found, rel=1e-2)
