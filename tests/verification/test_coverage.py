"""How often stated errors hold the truth: the kinds, the record of many computations, and what the report says of it."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

from reduced.stability.critical import critical_round_trip
from slipwave.observe.events import Events
from slipwave.observe.statistics import margin_of_mean
from tests.verification import stated_errors
from tests.verification.stated_errors import (
    KINDS,
    SLABS,
    SUMMARY,
    Held,
    agree,
    chosen,
    computation,
    coverage_of,
    held_means,
    known_computations,
    random_scene,
    summary,
)
from validation.models.orbits import find_orbit


def test_coverage_by_hand():
    computations = [[Held("period", 2e-9, 1e-9), Held("drop", 1e-9, 4e-9)], [], [Held("period", 8e-9, 1e-9)]]
    drop, period = coverage_of(computations)
    assert (drop.figure, drop.many, drop.share, drop.width) == ("drop", 1, 0.0, 0.25)
    assert period == ("period", 2, 1.0, pytest.approx(0.342, abs=1e-3), 1.0, pytest.approx(5.0))


@pytest.mark.parametrize("kind", SLABS)
def test_a_random_scene_is_of_its_kind_and_beyond_the_loss_of_stability(kind):
    scene = random_scene(kind, "sbp:6" if kind == "viscous" else "delay", np.random.default_rng(1))
    assert scene.alike is (kind != "unlike")
    assert scene.upper.is_plain is (kind in ("alike", "unlike"))
    critical, _ = critical_round_trip(scene, "delay")
    assert 1.009 < scene.transit / critical < 1.251


def test_the_stored_record_is_long_enough():
    stored = known_computations()
    assert list(stored) == list(KINDS)
    for kind, found in stored.items():
        assert len(found) == KINDS[kind].recorded
        assert min(one.many for one in coverage_of(found)) >= 100
        assert min(one.share for one in coverage_of(found)) >= 0.95


def test_the_report_shows_the_stored_record():
    assert json.loads(SUMMARY.read_text(encoding="utf-8")) == summary(known_computations())


@pytest.mark.parametrize("kind", ["orbits", "tolerances", "default grids", "extrapolation"])
def test_a_computation_repeated_is_what_is_recorded(kind):
    number = chosen(known_computations(), kind)
    found = computation(kind, number)
    assert found
    assert agree(found, known_computations()[kind][number])


def test_what_is_not_what_is_recorded_is_told():
    known = [Held("period", 1e-8, 1e-9)]
    assert agree([Held("period", 1.01e-8, 1.02e-9)], known)
    assert not agree([Held("period", 0.5e-8, 1e-9)], known)
    assert not agree([Held("period", 1e-8, 0.0)], [Held("period", 1e-8, 3e-10)])  # held against itself
    assert not agree([], known)
    wrong = [Held("cycles", 0.043, float("inf"))]
    assert agree(wrong, wrong)
    assert not agree(wrong, [Held("cycles", 0.043, 0.04)])
    assert not agree([Held("cycles", 0.043, 0.04)], wrong)


def test_a_record_goes_on_where_it_was_interrupted(tmp_path, monkeypatch):
    path, asked = tmp_path / "record.json", []

    def compute(kind, number):
        asked.append((kind, number))
        if len(asked) == 4:
            raise KeyboardInterrupt
        return [Held("period", 1e-8 * number, 1e-9)]

    monkeypatch.setattr(stated_errors, "computation", compute)
    monkeypatch.setattr(stated_errors, "_AT_ONCE", 1)
    monkeypatch.setattr(stated_errors, "KINDS", {kind: KINDS[kind]._replace(recorded=3) for kind in ("orbits", "means")})
    with pytest.raises(KeyboardInterrupt):
        stated_errors.make_record(stated_errors.KINDS, path)
    stated_errors.make_record(stated_errors.KINDS, path)
    assert asked == [("orbits", 0), ("orbits", 1), ("orbits", 2), ("means", 0), ("means", 0), ("means", 1), ("means", 2)]
    assert known_computations(path)["means"][2] == [Held("period", 2e-8, 1e-9)]


def test_a_mean_is_held_against_that_of_later_cycles():
    """Means 2 of 8 cycles and 4 of the next 24: half as large, and as far as 0.5/sqrt(1 + 8/24) from an exact one."""
    column = np.concatenate([np.tile([1.0, 3.0], 4), np.full(24, 4.0)])
    period = held_means(Events(*[column] * 6), 8)[0]
    assert period == ("period", pytest.approx(margin_of_mean(column[:8]) / 4.0), pytest.approx(0.5 * np.sqrt(0.75)))


def test_the_truth_of_an_orbit_is_that_of_a_finer_mesh():
    """The error of an orbit to 1e-4 against a mesh three times finer is that against Newton's method to 1e-11."""
    scene = random_scene("alike", "delay", np.random.default_rng(4))
    drawn = SimpleNamespace(random=lambda: 0.9, uniform=lambda *limits: -4.0)
    coarse, fine = (find_orbit("delay", scene, tolerance).periodic.orbit.values() for tolerance in (1e-4, 1e-11))
    held = stated_errors.of_orbit("delay", scene, drawn)
    assert max(one.error for one in held) > 1e-9
    for one in held:
        assert one.error == pytest.approx(abs(coarse[one.figure] / fine[one.figure] - 1.0), rel=0.05, abs=2e-12)


def test_a_layered_slab_is_not_taken_for_resolved_by_its_coarsest_grid():
    """In this one sbp:6 with 16 cells and with 24 is one grid, of 16 in each layer: its error was stated 47 times too small."""
    [held] = computation("chosen grids", 38)
    assert 0.0 < held.error <= held.bar < 1e-5
