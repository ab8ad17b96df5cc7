"""A run resumed from a checkpoint equals the uninterrupted one to the bit: every model, and every march of the delay system.
Every model on other scenes: `test_pairs.py`."""

import numpy as np
import pytest

import slipwave
from reduced.delay.alike import Delay
from slipwave.errors import SceneError
from slipwave.observe import EventObserver, HistoryObserver
from slipwave.solve import follow
from slipwave.solve.checkpoint import load_checkpoint, save_checkpoint
from validation.models.build import build
from validation.models.by_name import FAMILIES

RAMP = ["drive.velocity=[[0.0, 100.0], [20.3, 100.0], [41.17, 200.0]]"]
JUMP = ["start.kind=jump", "start.size=0.05"]
NOT_COMMENSURATE = ["lower.r=0.0013731"]
SCENES = {
    "paper": ("paper", []),
    "ramp": ("paper", RAMP),
    "jump": ("paper", JUMP),
    "unlike": ("unlike", []),
    "unlike ramp": ("unlike", RAMP),
    "machine": ("machine", []),
    "no common divisor": ("unlike", NOT_COMMENSURATE),
    "break points": ("unlike", [*NOT_COMMENSURATE, *JUMP]),
}
CASES = [(family.example, "ramp") for family in FAMILIES] + [("delay", scene) for scene in SCENES if scene != "ramp"]
LENGTH = {"break points": 20.0}  # transits of this run, which looks back at each arrival of the jump


def solver_of(model, name):
    gallery, changes = SCENES[name]
    model, _, time = model.partition(" ")
    return build(model, slipwave.read(gallery, changes), time=time or None)


def watched(solver):
    return {"events": EventObserver(solver.scene, solver.nodes), "history": HistoryObserver(solver.scene.law, solver.nodes)}


def assert_same_bits(ours, theirs):
    assert ours.keys() == theirs.keys()
    for name, array in ours.items():
        assert array.tobytes() == theirs[name].tobytes(), name


@pytest.mark.parametrize(("model", "name"), CASES)
def test_a_resumed_run_equals_the_uninterrupted_one(tmp_path, model, name):
    """Stopped within a step and within the ramp."""
    end = LENGTH.get(name, 90.0)
    mark = 0.36 * end
    straight, first, resumed = (solver_of(model, name) for _ in range(3))
    kept, begun, again = watched(straight), watched(first), watched(resumed)
    follow(first, mark, list(begun.values()))
    save_checkpoint(tmp_path / "run.npz", first, begun)
    load_checkpoint(tmp_path / "run.npz", resumed, again)
    assert resumed.time == first.time
    assert follow(resumed, end, list(again.values())) == follow(straight, end, list(kept.values()))
    assert_same_bits(resumed.state(), straight.state())
    assert {array.dtype for array in straight.state().values()} == {np.dtype(np.float64)}
    for label, observer in again.items():
        assert_same_bits(observer.state(), kept[label].state())


@pytest.mark.parametrize(
    ("model", "name"),
    [("delay", scene) for scene in SCENES] + [("modal:2", "paper"), ("block8", "ramp"), ("dg:7 exact", "unlike")],
)
def test_a_state_that_does_not_fit_is_refused_and_changes_nothing(model, name):
    solver, other = solver_of(model, name), solver_of(model, name)
    follow(solver, 30.2)
    follow(other, 31.7)
    kept, given = solver.state(), other.state()
    for label, array in given.items():
        wrong = [array.astype(complex), array[None], array.ravel()[:-1]] + ([np.full(array.shape, np.nan)] if array.size else [])
        for one in (given | {label: each} for each in wrong):
            with pytest.raises(SceneError):
                solver.restore(one)
        with pytest.raises(SceneError):
            solver.restore({key: value for key, value in given.items() if key != label})
    assert_same_bits(solver.state(), kept)
    solver.restore(given)
    assert_same_bits(solver.state(), given)
    assert follow(solver, 40.0) == follow(other, 40.0)


def refining(emit):
    """Three steps a transit are too few from the first event on."""
    return Delay(slipwave.read("paper", ["slab.log10_r=-2.3", *JUMP]), steps=3, emit=emit)


@pytest.mark.parametrize("emit", [True, False])
def test_steps_that_become_too_long_after_a_restart_are_refined_as_without_it(emit):
    straight, first, resumed = refining(emit), refining(emit), refining(emit)
    follow(first, 1.5)
    before = first.steps
    resumed.restore(first.state())
    assert follow(resumed, 300.0) == follow(straight, 300.0)
    assert resumed.steps > before
    assert_same_bits(resumed.state(), straight.state())
