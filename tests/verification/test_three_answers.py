"""Run, count of roots and orbit on random scenes near their onset."""

import pytest

from tests.verification.three_answers import answers, contradiction, main, scene_of


@pytest.mark.parametrize("number", [0, 3, 4, 5, 7, 10, 13, 15, 17, 26, 28, 56])
def test_run_roots_and_orbit_do_not_contradict_each_other(number):
    assert contradiction(answers(*scene_of(number))) == ""


@pytest.mark.slow
def test_they_do_not_on_more_random_scenes():
    assert main(0, 120) == 0
