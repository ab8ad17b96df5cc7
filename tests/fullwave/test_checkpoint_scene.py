"""A checkpoint belongs to one scene: every fact of the physics makes a difference, its length and its name do not."""

import dataclasses

import pytest

import slipwave
from fullwave.finite_difference import Leapfrog
from slipwave.errors import SceneError
from slipwave.friction.slip import Slip
from slipwave.scene.drive import Drive
from slipwave.scene.slab import GripFace, KelvinVoigtViscosity, Layer, ReflectingFace, StandardLinearViscosity
from slipwave.scene.start import Start, StartKind
from slipwave.solve.checkpoint import load_checkpoint, save_checkpoint

UNLIKE = slipwave.read("unlike")
SLABS = [
    {"epsilon": 8.5e-5},
    {"round_trip": 0.00489},
    {"face": GripFace(2.0, 1.0)},
    {"face": GripFace(2.0, 1.1)},
    {"face": GripFace(2.1, 1.0)},
    {"face": ReflectingFace(0.9)},
    {"viscosity": KelvinVoigtViscosity(1e-5)},
    {"viscosity": StandardLinearViscosity(1e-3, 0.5)},
    {"viscosity": StandardLinearViscosity(1e-3, 0.6)},
    {"layers": (Layer(0.5, 1.0), Layer(0.5, 2.0))},
    {"layers": (Layer(0.5, 1.0), Layer(0.5, 2.1))},
]
OTHERS = [
    {"law": UNLIKE.law._replace(b=0.05)},
    {"law": Slip(*UNLIKE.law)},
    {"drive": Drive((0.0,), (100.5,))},
    {"drive": Drive((0.0, 500.0), (100.0, 200.0))},
    {"drive": Drive((0.0, 501.0), (100.0, 200.0))},
    {"start": Start(StartKind.NUDGE, 0.4)},
    {"start": Start(StartKind.JUMP, 0.5)},
    *({side: dataclasses.replace(getattr(UNLIKE, side), **change)} for side in ("upper", "lower") for change in SLABS),
]


def test_no_two_scenes_share_a_checkpoint(tmp_path):
    scenes = [UNLIKE, *(dataclasses.replace(UNLIKE, **change) for change in OTHERS)]
    solvers = [Leapfrog(chosen, 16, 0.9) for chosen in scenes]
    for number, solver in enumerate(solvers):
        save_checkpoint(tmp_path / f"{number}.npz", solver)
    for number, solver in enumerate(solvers):
        load_checkpoint(tmp_path / f"{number}.npz", solver)
        with pytest.raises(SceneError, match=r"npz': (scene is|settings differ)"):
            load_checkpoint(tmp_path / f"{(number + 1) % len(solvers)}.npz", solver)
        if number:
            with pytest.raises(SceneError, match=r"npz': scene is '[0-9a-f]{12}'; this run needs '[0-9a-f]{12}'"):
                load_checkpoint(tmp_path / "0.npz", solver)


def test_a_longer_run_of_the_same_scene_goes_on(tmp_path):
    path = tmp_path / "run.npz"
    save_checkpoint(path, Leapfrog(UNLIKE, 16, 0.9))
    load_checkpoint(
        path, Leapfrog(dataclasses.replace(UNLIKE, until=9999.0, name="again", record=frozenset({"fields"})), 16, 0.9)
    )
