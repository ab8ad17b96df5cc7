import json

import pytest

from validation import cli
from validation.cli import main


def answer(capsys: pytest.CaptureFixture[str], *words: str) -> dict:
    assert main(["stability", *words, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_json_of_the_paper_scene(capsys: pytest.CaptureFixture[str]) -> None:
    found = answer(capsys, "paper")
    assert found["log10_r_c"] == pytest.approx(-2.6995497159, abs=1e-10)
    assert found["omega_c"] == pytest.approx(63.3360980646, rel=1e-11)
    assert found["epsilon_c"] == pytest.approx(2.92929031601e-05, rel=1e-11)
    assert found["stable"] is False
    assert found["leading_roots"][0][0] > 0.0
    assert len(found["leading_roots"][0]) == 2


def test_settings_and_model(capsys: pytest.CaptureFixture[str]) -> None:
    found = answer(capsys, "paper", "--model", "kelvin-voigt", "--set", "slab.log10_r=-2.71")
    assert found["stable"] is True
    assert found["log10_r_c"] == pytest.approx(-2.69954994745, abs=1e-11)
    assert found["essential_abscissa"] is None


@pytest.mark.parametrize(
    "scene", ["unlike", "unlike-irrational", "grip", "layered", "viscous", "reflection", "rock", "slip-law", "regularised"]
)
def test_every_kind_of_scene(capsys: pytest.CaptureFixture[str], scene: str) -> None:
    found = answer(capsys, scene)
    assert found["stable"] == (found["leading_roots"][0][0] < 0.0)
    assert found["omega_c"] > 0.0
    assert main(["stability", scene]) == 0
    assert "leading roots" in capsys.readouterr().out


@pytest.mark.parametrize("model", ["modal:99", "nonsense", "block8:3"])
def test_a_wrong_model_is_refused_in_one_line(capsys: pytest.CaptureFixture[str], model: str) -> None:
    assert main(["stability", "paper", "--model", model]) == cli.INPUT_WRONG
    assert len(capsys.readouterr().err.splitlines()) == 1


def test_taylor_is_shown_to_be_unusable(capsys: pytest.CaptureFixture[str]) -> None:
    found = answer(capsys, "paper", "--model", "taylor", "--set", "slab.log10_r=-3.5")
    assert found["stable"] is False
    assert found["unstable_roots"] == 2
