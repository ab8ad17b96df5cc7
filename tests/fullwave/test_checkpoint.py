"""A run killed at a random moment and resumed equals the uninterrupted one to the bit; wrong files are refused."""

import os
import random
import time
from multiprocessing import get_context

import pytest
from grid_scenes import PAPER

from fullwave.finite_difference import Leapfrog
from slipwave.errors import SceneError
from slipwave.observe import EventObserver
from slipwave.solve import follow
from slipwave.solve.checkpoint import Checkpoints, load_checkpoint, save_checkpoint


def run_for_ever(path):
    solver = Leapfrog(PAPER, 32, 0.9)
    events = EventObserver(PAPER, solver.nodes)
    marks = Checkpoints(solver, {"events": events}, path, 1e9, 20.0)
    if path.exists():
        marks.resume()
    follow(solver, 1e9, [events], marks=[marks])


def outcome(solver, events):
    return [solver.state(), events.state(), solver.energy(), solver.time]


def assert_same_bits(ours, theirs):
    for mine, other in zip(ours[:2], theirs[:2], strict=True):
        assert mine.keys() == other.keys()
        for name in mine:
            assert mine[name].tobytes() == other[name].tobytes(), name
    assert ours[2:] == theirs[2:]


def test_killed_and_resumed_equals_uninterrupted(tmp_path):
    path = tmp_path / "run.npz"
    for _ in range(3):
        process = get_context("fork").Process(target=run_for_ever, args=(path,))
        process.start()
        while not path.exists() and process.is_alive():
            time.sleep(0.005)
        time.sleep(random.uniform(0.0, 0.1))
        process.kill()
        process.join()
        assert path.exists()
    solver = Leapfrog(PAPER, 32, 0.9)
    events = EventObserver(PAPER, solver.nodes)
    load_checkpoint(path, solver, {"events": events})
    reached = solver.time
    assert reached >= 20.0
    end = reached + 500.0
    final = follow(solver, end, [events], marks=[Checkpoints(solver, {"events": events}, path, end, 130.0)])
    straight = Leapfrog(PAPER, 32, 0.9)
    watching = EventObserver(PAPER, straight.nodes)
    assert follow(straight, end, [watching]) == final
    assert_same_bits(outcome(solver, events), outcome(straight, watching))


@pytest.mark.parametrize("beyond", [0.0, 0.01, 0.05, 0.1])
def test_a_mark_just_before_the_end(tmp_path, beyond):
    """A mark's last piece must not run past the end of the run."""
    end = 40.0 + beyond
    solver, straight = Leapfrog(PAPER, 32, 0.9), Leapfrog(PAPER, 32, 0.9)
    path = tmp_path / "run.npz"
    assert follow(solver, end, marks=[Checkpoints(solver, {}, path, end, 10.0)]) == follow(straight, end)
    with pytest.raises(SceneError, match="already at"):
        Checkpoints(solver, {}, path, 10.0, 10.0).resume()
    Checkpoints(solver, {}, path, end, 10.0).resume()
    assert solver.time < end


def test_a_failed_save_leaves_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "run.npz"
    solver = Leapfrog(PAPER, 16)
    save_checkpoint(path, solver)
    before = path.read_bytes()

    def full(*arguments):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full)
    with pytest.raises(SceneError, match="no space left"):
        save_checkpoint(path, solver)
    assert path.read_bytes() == before
    assert [entry.name for entry in tmp_path.iterdir()] == ["run.npz"]
    with pytest.raises(SceneError, match="cannot be written"):
        save_checkpoint(tmp_path / "absent" / "run.npz", solver)
