"""How often stated errors hold the truth: the kinds, the record of many computations, and what the report says of it."""

from pathlib import Path

import numpy as np
import pytest

from validation.coverage import kinds, record
from validation.coverage.kinds import KINDS, SLABS, Held, computation, random_scene
from validation.coverage.record import coverage_of, known_computations
from validation.studies import coverage
from validation.study import Budget, Outcome


def test_coverage_by_hand() -> None:
    computations = [[Held("period", 2e-9, 1e-9), Held("drop", 1e-9, 4e-9)], [], [Held("period", 8e-9, 1e-9)]]
    drop, period = coverage_of(computations)
    assert (drop.figure, drop.many, drop.share, drop.width) == ("drop", 1, 0.0, 0.25)
    assert period == ("period", 2, 1.0, pytest.approx(0.342, abs=1e-3), 1.0, pytest.approx(5.0))


@pytest.mark.parametrize("kind", SLABS)
def test_a_random_scene_is_of_its_kind_and_beyond_the_loss_of_stability(kind: str) -> None:
    scene = random_scene(kind, "sbp:6" if kind == "viscous" else "delay", np.random.default_rng(1))
    assert scene.alike is (kind != "unlike")
    assert scene.upper.is_plain is (kind in ("alike", "unlike"))
    critical, _ = kinds.critical_round_trip(scene, "delay")
    assert 1.009 < scene.transit / critical < 1.251


def test_the_stored_record_is_of_the_present_definition_and_long_enough() -> None:
    stored = known_computations()
    assert list(stored) == list(KINDS)
    for kind, found in stored.items():
        assert len(found) == KINDS[kind].recorded
        assert min(one.many for one in coverage_of(found)) >= (40 if kind == "chosen grids" else 100)  # minutes each
        assert min(one.share if KINDS[kind].exact else one.high for one in coverage_of(found)) >= 0.95


@pytest.mark.parametrize("kind", ["orbits", "tolerances", "default grids", "extrapolation"])
def test_a_computation_repeated_is_what_is_recorded(kind: str) -> None:
    number = coverage.chosen(known_computations(), kind, quick=True)[0]
    found = computation(kind, number)
    assert found
    assert coverage.agree(kind, found, known_computations()[kind][number])


def test_what_is_not_what_is_recorded_is_told() -> None:
    known = [Held("period", 1e-8, 1e-9)]
    assert coverage.agree("orbits", [Held("period", 1.01e-8, 1.2e-9)], known)
    assert not coverage.agree("orbits", [Held("period", 0.5e-8, 1e-9)], known)
    assert not coverage.agree("orbits", [Held("period", 1e-8, 2e-9)], known)
    assert not coverage.agree("orbits", [], known)
    parts = [Held("period", 1e-3, error) for error in (1e-4, 2e-4, 4e-4)]
    assert coverage.agree("means", [one._replace(error=1.5 * one.error) for one in parts], parts)
    assert not coverage.agree("means", [one._replace(bar=0.5 * one.bar) for one in parts], parts)
    assert not coverage.agree("means", [one._replace(error=5.0 * one.error) for one in parts], parts)


def test_a_kind_that_holds_less_than_95_of_100_is_red(monkeypatch: pytest.MonkeyPatch) -> None:
    """Bars half as wide as those recorded, in the record and in what is computed again."""
    stored = known_computations()
    narrow = {kind: [[one._replace(bar=0.5 * one.bar) for one in each] for each in found] for kind, found in stored.items()}
    monkeypatch.setattr(coverage, "known_computations", lambda: narrow)
    monkeypatch.setattr(coverage, "computation", lambda kind, number: narrow[kind][number])
    failed = {
        verdict.remark.partition(":")[0]
        for verdict in coverage.run(Budget(quick=True)).verdicts
        if verdict.outcome is Outcome.FAIL
    }
    assert failed >= {"means", "exponents", "default grids"}


def test_a_record_goes_on_where_it_was_interrupted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, asked = tmp_path / "record.json", []

    def compute(kind: str, number: int) -> list[Held]:
        asked.append((kind, number))
        if len(asked) == 4:
            raise KeyboardInterrupt
        return [Held("period", 1e-8 * number, 1e-9)]

    monkeypatch.setattr(record, "computation", compute)
    monkeypatch.setattr(record, "_AT_ONCE", 1)
    monkeypatch.setattr(record, "KINDS", {kind: KINDS[kind]._replace(recorded=3) for kind in ("orbits", "means")})
    with pytest.raises(KeyboardInterrupt):
        record.make_record(path)
    record.make_record(path)
    assert asked == [("orbits", 0), ("orbits", 1), ("orbits", 2), ("means", 0), ("means", 0), ("means", 1), ("means", 2)]
    assert known_computations(path)["means"][2] == [Held("period", 2e-8, 1e-9)]
    path.write_text(path.read_text().replace(record.definition(), "of something else"))
    assert known_computations(path) == {}


def test_of_parts_of_a_run_each_is_held_against_the_others() -> None:
    """Of 0, 0, 0, 4 the last lies 4 from the mean of the others, as far as 4 sqrt(3/4) from an exact one."""
    assert kinds._of_others(np.array([0.0, 0.0, 0.0, 4.0]))[3] == (0.0, pytest.approx(4.0 * np.sqrt(0.75)))
    assert kinds._of_others(np.array([0.0, 0.0, 0.0, 4.0]))[0] == (
        pytest.approx(4.0 / 3.0),
        pytest.approx(4.0 / 3.0 * np.sqrt(0.75)),
    )
