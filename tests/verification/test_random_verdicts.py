"""Verdicts on random scenes against a judge that reads the state alone."""

import pytest

from tests.verification.random_verdicts import case_of, judged, main

FOUND = {
    5003: "decaying",
    5014: "growing",
    5017: "periodic 1",
    5020: "periodic 3",
    5027: "torus",
    5001: "irregular",
}


def test_verdicts_on_random_scenes_are_right():
    found = {number: judged(case_of(number)) for number in FOUND}
    assert {number: answer.verdict for number, answer in found.items()} == FOUND
    assert [answer.judge for answer in found.values()] == ["right"] * len(FOUND)


@pytest.mark.slow
def test_verdicts_on_more_random_scenes_are_right():
    assert main(9000, 9024) == 0
