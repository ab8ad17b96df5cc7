"""Stick-slip fitted with every wave: orbits over their period, known parameters in their intervals, and what is refused."""

import numpy as np
import pytest

import slipwave as sw
from slipwave.errors import NumericsError, SceneError
from slipwave.input.assemble import read
from slipwave.scene.drive import Drive
from tests.validation.records import assert_held, written
from validation.fit.cycles import FoldedRecord, disturbed, folded
from validation.fit.forward import OfSolver
from validation.fit.least_squares import BestValues
from validation.fit.orbits import CycleOfOrbit
from validation.fit.parameters import Variants, begun, schedule_of
from validation.models.own import load_families
from validation.models.parameter import Variation

HEADING = "time [transits],mu"
AWAY = ["interface.a=0.0349", "interface.b=0.0489"]


def seen(a, noise, seed, begin=2000.0):
    """16 cycles of the delay system in the scene `paper`, with noise, from a nudge."""
    scene = read("paper", {"interface.a": a})
    times = np.arange(begin, begin + 1200.0, 0.23)
    steady = Variants(Variation(scene), (), Drive((0.0,), (scene.velocity,)))
    friction = OfSolver(disturbed(steady), times, "delay", 1e-7).friction(np.empty(0))
    return times - begin, friction + noise * np.random.default_rng(seed).standard_normal(times.size)


@pytest.mark.parametrize(("a", "noise", "away"), [(0.0349, 1e-3, (1.02, 0.985)), (0.0347, 1e-4, (0.87, 1.12))])
def test_stick_slip_of_the_delay_system_gives_a_and_b_back_from_near_and_far(a, noise, away, tmp_path):
    file = written(tmp_path / "paper.csv", HEADING, *seen(a, noise, 14))
    start = [f"interface.a={a * away[0]}", f"interface.b={0.0489 * away[1]}"]
    found = sw.fit("paper", "delay", data=[file], free=["a", "b"], settings=start)
    assert_held(found, {"interface.a": a, "interface.b": 0.0489}, 5.0 * noise)
    assert found.residual["over_noise"] == pytest.approx(1.0, abs=0.1)
    assert found.residual["rms"] == pytest.approx(noise, rel=0.1)


@pytest.fixture(scope="module")
def followed():
    """An orbit of the delay system, seen at some places of its cycle."""
    scene = read("paper")
    variants = disturbed(Variants(Variation(scene), begun(Variation(scene), ["a", "b"])[1], schedule_of(scene)))
    times = np.linspace(2.0, 71.0, 40)
    made = CycleOfOrbit(variants, FoldedRecord(times, np.zeros(40), np.zeros(40), 73.47214494, 1.0), "delay")
    made.begin(np.array([one.inner(one.start) for one in variants.free]))
    return made


def test_an_orbit_is_that_of_the_run_and_its_derivative_that_of_differences(followed):
    inner = np.log([0.0349, 0.0489])
    here = followed.friction(inner)
    assert here[0] == pytest.approx(73.47214494, abs=1e-5)
    exact, step = followed.slopes(inner), 1e-5
    for k, shift in enumerate(step * np.eye(2)):
        plus, minus = followed.friction(inner + shift), followed.friction(inner - shift)
        difference = (plus - minus) / (2.0 * step)
        assert exact[0, k] == pytest.approx(difference[0], rel=2e-3)
        assert np.abs(exact[1:, k] - difference[1:]).max() < 2e-3 * np.abs(difference[1:]).max()
    followed.friction(inner)


def test_what_does_not_repeat_or_is_of_another_model_has_no_interval(tmp_path):
    times, friction = seen(0.0349, 1e-4, 5)
    settling = written(tmp_path / "settling.csv", HEADING, *seen(0.0340, 1e-4, 5, 1000.0))
    with pytest.raises(NumericsError, match="no interval holds") as refused:
        sw.fit("paper", "delay", data=[settling], free=["a", "b"], settings=["interface.a=0.034"])
    assert refused.value.result.parameters["interface.a"]["value"] == pytest.approx(0.034, rel=0.03)
    late = times + np.sin(times / 150.0)
    with pytest.raises(SceneError, match="transits off equal cycles"):
        folded("late", late, friction, None, 1.0)
    bent = written(tmp_path / "bent.csv", HEADING, times, 0.3 + 1.1 * (friction - 0.3))
    with pytest.raises(NumericsError, match="no orbit of the model is the record's"):
        sw.fit("paper", "delay", data=[bent], free=["b"], settings=AWAY)


def test_an_orbit_that_one_mesh_calls_unstable_is_fitted_if_orbit_does_not(tmp_path, monkeypatch):
    """Behind faces that leak, the eigenvalues of a single mesh near the essential radius may lie outside the unit circle."""
    monkeypatch.setattr("validation.fit.by_orbits.count_unstable", lambda closed: 1)
    file = written(tmp_path / "paper.csv", HEADING, *seen(0.0349, 1e-3, 14))
    assert sw.orbit("paper").summary["stable"]
    assert "interface.a" in sw.fit("paper", "delay", data=[file], free=["a"]).parameters


def test_reductions_that_ring_are_fitted_in_the_same_way(tmp_path):
    file = written(tmp_path / "paper.csv", HEADING, *seen(0.0349, 1e-3, 5))
    found = sw.fit("paper", "modal:2", data=[file], free=["a"], settings=AWAY)
    assert found.parameters["interface.a"]["value"] == pytest.approx(0.0349, rel=5e-3)
    other = written(tmp_path / "other.csv", HEADING, *seen(0.0349, 1e-3, 6))
    with pytest.raises(SceneError, match="one record of stick-slip at a time"):
        sw.fit("paper", "delay", data=[file, other], free=["a"])
    with pytest.raises(SceneError, match="needs a parameter that changes the period"):
        sw.fit("paper", "delay", data=[file], free=["a_star"])


OWN = """
from dataclasses import replace
from reduced.impedance.reduction import reduction
from slipwave.family import Family
COPY = Family("my-copy", f"{__name__}:copy", "modal:2")
DAMPED = Family("my-damped", f"{__name__}:damped", "an oscillator that is slowly damped")
def copy(scene, name):
    return replace(reduction("modal:2"), name=name)
def damped(scene, name):
    return replace(reduction("kelvin-voigt"), name=name, decays=(0.001,))
"""


def test_the_same_reduction_under_another_name_is_fitted_in_the_same_way(tmp_path):
    """Before, only those named kelvin-voigt and modal were; the others had another answer, or a traceback."""
    file = written(tmp_path / "paper.csv", HEADING, *seen(0.0349, 1e-3, 5))
    (tmp_path / "own.py").write_text(OWN)
    load_families(tmp_path / "own.py")
    ours, *same = (sw.fit("paper", model, data=[file], free=["a"], settings=AWAY) for model in ("modal:2", "my-copy", "fitted:2"))
    for one in same:
        assert one.parameters["interface.a"]["value"] == pytest.approx(ours.parameters["interface.a"]["value"], rel=1e-9)
        assert one.data[0]["samples"] == ours.data[0]["samples"]
    damped = sw.fit("paper", "my-damped", data=[file], free=["a", "b"], settings=["interface.a=0.0345"])
    assert 1.2 < damped.residual["over_noise"] < 3.0


@pytest.mark.parametrize(("scene", "work", "line"), [("paper", 3e6, "after 3[0-9] orbits"), ("unlike", 1e4, "after 0 orbits")])
def test_a_search_without_an_answer_ends_and_says_where_it_is(scene, work, line, tmp_path, monkeypatch, caplog):
    times, friction = seen(0.0349, 1e-4, 5)
    file = written(tmp_path / "record.csv", HEADING, times, friction if scene == "unlike" else 0.2 + 2.0 * friction)
    monkeypatch.setattr("validation.fit.orbits._WORK", work)
    monkeypatch.setattr("validation.models.progress._LINE_INTERVAL", 0.0)
    with caplog.at_level("INFO", "slipwave"), pytest.raises(NumericsError, match=f"the search ends {line}.*quasidynamic"):
        sw.fit(scene, "delay", data=[file], free=["a", "b"], settings=AWAY)
    assert scene == "unlike" or any("orbits closed or tried" in line for line in caplog.messages)


def test_a_fit_says_how_far_it_is(monkeypatch, caplog):
    monkeypatch.setattr("validation.models.progress._LINE_INTERVAL", 0.0)
    best = BestValues(np.zeros(1))
    with caplog.at_level("INFO", "slipwave"):
        best.see(np.zeros(1), np.full(9, 3.0))
        best.see(np.zeros(1), np.full(9, 5.0))
    assert caplog.messages[-1] == "fit: 2 evaluations, the best residual is 3 times the noise"
