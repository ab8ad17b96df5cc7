"""A run of more than a day is refused before it begins, or as soon as its steps show it; costs are given, not timed."""

import json
import sys

import pytest

import slipwave
from fullwave.finite_difference import Leapfrog
from fullwave.lines.march import MethodOfLines
from reduced.delay.march import DelayMarch
from slipwave.errors import SceneError
from slipwave.solve.follow import DAY, require_time
from validation.cli import INPUT_WRONG, main
from validation.registry.build import build
from validation.registry.families import GRIDS, explicit_time
from validation.run.simulate import simulate


@pytest.mark.parametrize("family", GRIDS, ids=lambda family: family.name)
def test_a_run_of_a_day_goes_and_a_longer_one_does_not(family, monkeypatch):
    march = explicit_time(family.example)
    solver = build(family.example, slipwave.read("paper"), time=march)
    pieces = 4000.0 / solver.advance(1e-6).length[0]  # type: ignore[attr-defined]
    kind = Leapfrog if family.name == "fd" else MethodOfLines
    fresh = build(family.example, slipwave.read("paper"), time=march)
    monkeypatch.setattr(kind, "seconds_per_piece", 0.999 * DAY / pieces)
    require_time(fresh, 4000.0)
    monkeypatch.setattr(kind, "seconds_per_piece", 1.001 * DAY / pieces)
    with pytest.raises(SceneError, match=r"4000 transits would take about 1 days .*fewer cells or a larger cfl; --yes"):
        require_time(fresh, 4000.0)
    require_time(fresh, 4000.0, most=float("inf"))


@pytest.mark.parametrize("model", ["delay", "block8"])
def test_a_march_whose_steps_adapt_is_judged_by_those_it_took(model, monkeypatch):
    paper = slipwave.read("paper")
    solver = build(model, paper)
    with monkeypatch.context() as slow:
        slow.setattr(type(solver), "seconds_per_piece", DAY / 2e6)
        with pytest.raises(SceneError, match=r"4e\+07 transits would take about [\d.]+ days"):
            simulate(solver, 4e7)
    assert solver.time < 40_000.0
    simulate(build(model, paper), 3000.0)


def test_the_way_to_an_orbit_is_shown_and_judged(monkeypatch, capsys):
    monkeypatch.setattr("validation.run.progress.PATIENCE", -1.0)
    monkeypatch.setattr("validation.run.progress._LINE_INTERVAL", -1.0)
    words = ["run", "paper", "--model", "delay", "--until", "20", "--set", "start.kind=orbit"]
    assert main(words) == 0
    assert capsys.readouterr().err.startswith("paper, delay, on the way to an orbit: ")
    monkeypatch.setattr(sys.modules["slipwave.solve.follow"], "_ENOUGH", 1000)
    monkeypatch.setattr(DelayMarch, "seconds_per_piece", DAY)
    assert main(words) == INPUT_WRONG
    assert "model delay: 6000 transits would take about" in capsys.readouterr().err


@pytest.mark.parametrize(
    "words",
    [
        ["run", "paper", "--model", "fd", "--cells", "16"],
        ["compare", "paper", "--models", "fd", "--cells", "16", "--out", "x.png"],
    ],
    ids=lambda words: words[0],
)
def test_yes_runs_it_all_the_same(words, tmp_path, monkeypatch, printed, refused):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(Leapfrog, "seconds_per_piece", DAY)
    words = [*words, "--until", "30", "--json"]
    assert refused(*words).startswith("slipwave: model fd: 30 transits would take about")
    assert list(tmp_path.iterdir()) == []
    assert json.loads(printed(*words, "--yes"))["until"] == 30.0


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--model", "fd", "--cfl", "1e-300"], "cfl = 1e-300: must be at least 1e-09"),
        (["--model", "dg:7", "--cfl", "5e-324"], "cfl = 5e-324: must be at least 1e-09"),
        (["--model", "dg:7", "--cfl", "1e-9"], "model dg:7: 4000 transits would take about 36"),
        (["--model", "fd", "--cells", "200000", "--set", 'slab.viscosity={kind="kelvin-voigt", time=2e-5}'], "about 7.41 days"),
        (["--model", "fd", "--set", "start.kind=orbit", "--cfl", "1e-9"], "model fd: 6000 transits would take about"),
        (["--model", "dg", "--tol", "1e-6", "--cfl", "1e-9"], "model dg:6: 400 transits would take about"),
    ],
)
def test_what_was_endless_is_refused(words, told, refused):
    assert told in refused("run", "paper", *words)
