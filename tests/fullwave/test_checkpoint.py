"""A run killed at a random moment and resumed equals the uninterrupted one to the bit; wrong files are refused."""

import os
import random
import signal
import subprocess
import sys
import time

import pytest
from grid_scenes import PAPER

from fullwave.finite_difference import Leapfrog
from slipwave.errors import SceneError
from slipwave.observe import EventObserver
from slipwave.solve import follow
from slipwave.solve.checkpoint import Checkpoints, load_checkpoint, save_checkpoint

UNTIL = 3000.0
SCRIPT = """
import sys
from pathlib import Path
import slipwave
from fullwave.finite_difference import Leapfrog
from slipwave.observe import EventObserver
from slipwave.solve import follow
from slipwave.solve.checkpoint import Checkpoints
chosen = slipwave.read("paper")
solver = Leapfrog(chosen, 32, 0.9)
print("go", flush=True)
events, path, until = EventObserver(chosen, solver.nodes), Path(sys.argv[1]), float(sys.argv[2])
marks = Checkpoints(solver, {"events": events}, path, until, 20.0)
if path.exists():
    marks.resume()
follow(solver, until, [events], marks=[marks])
"""


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
        process = subprocess.Popen([sys.executable, "-c", SCRIPT, str(path), "1e9"], stdout=subprocess.PIPE)
        process.stdout.readline()
        while not path.exists() and process.poll() is None:
            time.sleep(0.005)
        time.sleep(random.uniform(0.0, 0.1))
        process.send_signal(signal.SIGKILL)
        process.wait()
        process.stdout.close()
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
