"""Slabs that differ in epsilon alone are marched as one by full waves too: fields and energies of each against two slabs."""

from dataclasses import astuple

import numpy as np
import pytest

import slipwave
from slipwave.scene import Scene
from slipwave.solve import follow
from validation.compute.build import build

LAYERS = "slab.layers=[{fraction=0.3,impedance=1.0},{fraction=0.7,impedance=2.0}]"
FACES = {
    "rigid": [],
    "layers": [LAYERS],
    "grip": ["slab.face={kind='grip', stiffness=10.0, impedance=19.0}"],
    "reflection": ["slab.face={kind='reflection', coefficient=0.9}"],
    "machine": ["slab.face={kind='machine', stiffness=10.0, impedance=2.0, mass=0.01}"],
}
MODELS = {"fd": {"cells": 24}, "dg:8": {"cells": 3}, "fem:4": {"cells": 4, "time": "explicit"}}


def pair(name: str, ratio: float = 3.0) -> Scene:
    """The paper's slabs with the impedances 1 : ratio, of the same Z."""
    settings = [*FACES[name], "start.size=0.1", "run.until=90"]
    scene = slipwave.read("paper", settings)
    epsilon = scene.upper.epsilon
    epsilons = [0.5 * epsilon * (1.0 + ratio) / ratio, 0.5 * epsilon * (1.0 + ratio)]
    return slipwave.read("paper", [*settings, *(f"{k}.epsilon={x!r}" for k, x in zip(("upper", "lower"), epsilons, strict=True))])


def seen(scene: Scene, model: str) -> tuple[list[np.ndarray], np.ndarray, np.ndarray, int]:
    """Fields of both slabs, the energy balance, the end of the interface's motion, and the number of values in the state."""
    solver = build(model, scene, **MODELS[model])
    solver.keep_ledger()
    final = follow(solver, 90.0)
    shot = solver.snapshot()
    fields = [values for slab in (shot.upper, shot.lower) for values in (slab.depth, slab.velocity, slab.stress)]
    energy = solver.energy()
    assert energy is not None
    size = sum(values.size for values in solver.state().values())
    return fields, np.array(astuple(energy)), np.array([final.ln_v, final.psi, final.mu]), size


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("name", FACES)
def test_one_slab_gives_the_fields_and_energies_of_both(name: str, model: str, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = pair(name)
    assert scene.upper.epsilon != scene.lower.epsilon
    fields, energy, final, size = seen(scene, model)
    monkeypatch.setattr(Scene, "equivalent", None)
    fields_of_two, energy_of_two, final_of_two, size_of_two = seen(pair(name), model)
    assert size < 0.75 * size_of_two
    np.testing.assert_allclose(final, final_of_two, atol=1e-9)
    np.testing.assert_allclose(energy, energy_of_two, rtol=1e-9, atol=1e-9 * abs(energy).max())
    moved = [np.abs(fields[k] - 0.5 * scene.velocity).max() for k in (1,)]
    assert moved[0] > 1e-6
    for ours, theirs in zip(fields, fields_of_two, strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=1e-9, atol=1e-10 * np.abs(theirs).max())


def test_two_slabs_are_marched_where_v_changes() -> None:
    """They then swing together, too, which their interface does not feel."""
    words = ["drive.velocity=[[0,100],[10,100],[20,110]]", "upper.epsilon=2e-5", "lower.epsilon=1e-5", "run.until=40"]
    scene = slipwave.read("paper", words)
    assert scene.equivalent is not None
    solver = build("dg:8", scene, cells=2)
    follow(solver, 40.0)
    shot = solver.snapshot()
    assert np.abs(shot.upper.velocity + shot.lower.velocity[: shot.upper.velocity.size]).max() > 1e-3
