"""Slabs whose impedances have a constant ratio move the interface as alike ones: one slab is marched."""

from dataclasses import astuple, replace

import numpy as np
import pytest

import slipwave
from reduced.delay.flow import DelayFlow
from reduced.delay.system import LeapingDelay, delay_system
from slipwave.observe import HistoryObserver
from slipwave.scene import Scene
from slipwave.scene.drive import Drive, Start, StartKind
from slipwave.scene.slab import GripFace, Layer, MachineFace, ReflectingFace, RigidFace
from slipwave.solve import follow
from validation.commands.wording import header
from validation.models.build import build

PAPER = slipwave.read("paper")
FACES = {
    "rigid": RigidFace(),
    "grip": GripFace(2.0, 0.7),
    "reflection": ReflectingFace(0.99),
    "machine": MachineFace(1.0, 0.5, 0.3),
}
DRIVES = {
    "constant": PAPER.drive,
    "step": Drive((20.0, 20.0), (100.0, 250.0)),
    "steps within steps": Drive((20.3, 20.3, 31.7), (100.0, 30.0, 80.0)),
    "ramp": Drive((10.0, 30.0), (100.0, 200.0)),
    "ramp from the start": Drive((0.0, 1.3), (100.0, 300.0)),
}


def in_ratio(ratio, scene=PAPER):
    """The scene's upper slab and one of `ratio` times its impedance, which are together as stiff as two of the upper one."""
    slab = replace(scene.upper, epsilon=0.5 * scene.upper.epsilon * (1.0 + 1.0 / ratio))
    return replace(scene, upper=slab, lower=replace(slab, epsilon=ratio * slab.epsilon))


@pytest.mark.parametrize("ratio", [3.0, 0.1])
def test_the_march_has_one_wave(ratio):
    scene = in_ratio(ratio)
    assert isinstance(delay_system(scene), LeapingDelay)
    assert DelayFlow(scene, 4.0).size == DelayFlow(PAPER, 4.0).size
    assert scene.equivalent is not None
    assert scene.equivalent.epsilon == pytest.approx(PAPER.upper.epsilon, rel=1e-15)
    assert any(line.startswith("both: to the interface as alike slabs of epsilon 2.8e-05") for line in header(scene))


@pytest.mark.parametrize(
    "change",
    [{"round_trip": 1.0001 * PAPER.transit}, {"face": GripFace(1.0, 1.0)}, {"layers": (Layer(0.5, 1.0), Layer(0.5, 2.0))}],
)
def test_slabs_that_differ_in_more_than_impedance_are_two(change):
    scene = in_ratio(3.0)
    other = replace(scene, lower=replace(scene.lower, **change))
    assert other.equivalent is None
    assert other.slabs == (other.upper, other.lower)
    assert DelayFlow(other, 4.0).size > 1.9 * DelayFlow(scene, 4.0).size


@pytest.mark.parametrize("layers", [(Layer(1.0, 1.0),), (Layer(0.5, 1.0), Layer(0.5, 2.0))], ids=["one", "two"])
@pytest.mark.parametrize("drive", DRIVES)
@pytest.mark.parametrize("face", FACES)
def test_one_slab_moves_as_two(face, drive, layers):
    """Against two slabs, the upper one written in layers of half the length, which are not recognised; from a jump of psi."""
    slab = replace(PAPER.upper, face=FACES[face], layers=layers)
    scene = replace(PAPER, upper=slab, drive=DRIVES[drive], start=Start(StartKind.JUMP, 0.1), until=40.0)
    one = in_ratio(3.0, scene)
    halves = tuple(Layer(0.5 * layer.fraction, layer.impedance) for layer in layers for _ in range(2))
    two = replace(one, upper=replace(one.upper, layers=halves))
    assert (len(one.slabs), len(two.slabs)) == (1, 2)
    times, found = np.linspace(0.5, 39.5, 157), []
    for each in (one, two):
        solver = delay_system(each, 1e-11)
        history = HistoryObserver(each.law, solver.nodes)
        follow(solver, 40.0, [history])
        found.append(history.at(times))
    for mine, other, scale in zip(*found, (1.0, 1.0, 1.0, 0.03, 0.03), strict=True):
        np.testing.assert_allclose(mine, other, rtol=0.0, atol=1e-9 * scale)


def test_a_branch_that_leaves_the_pair_begins_beside_it():
    branch = slipwave.branch(in_ratio(3.0), ("ratio_r", 1.0, 1.05), model="delay", most_points=2)
    first = branch.followed.points[0]
    assert first.value == pytest.approx(1.0 + 5e-8, abs=1e-12)
    assert first.period == pytest.approx(73.47214494430, rel=1e-5)


GRIDS = {"fd": {"cells": 24}, "dg:8": {"cells": 3}, "fem:4": {"cells": 4, "time": "explicit"}}
LAYERED = {"layers": (Layer(0.3, 1.0), Layer(0.7, 2.0))}


def seen(scene, model):
    """Fields of both slabs, the energy balance, the end of the interface's motion, and the number of values in the state."""
    solver = build(model, scene, **GRIDS[model])
    solver.keep_ledger()
    final = follow(solver, 90.0)
    shot = solver.snapshot()
    fields = [values for slab in (shot.upper, shot.lower) for values in (slab.depth, slab.velocity, slab.stress)]
    size = sum(values.size for values in solver.state().values())
    return fields, np.array(astuple(solver.energy())), np.array([final.ln_v, final.psi, final.mu]), size


@pytest.mark.parametrize("model", GRIDS)
@pytest.mark.parametrize("change", [*({"face": face} for face in FACES.values()), LAYERED], ids=[*FACES, "layers"])
def test_one_slab_gives_the_fields_and_energies_of_both(change, model, monkeypatch):
    scene = in_ratio(3.0, replace(PAPER, upper=replace(PAPER.upper, **change), start=Start(size=0.1), until=90.0))
    fields, energy, final, size = seen(scene, model)
    monkeypatch.setattr(Scene, "equivalent", None)
    fields_of_two, energy_of_two, final_of_two, size_of_two = seen(replace(scene), model)
    assert size < 0.75 * size_of_two
    np.testing.assert_allclose(final, final_of_two, atol=1e-9)
    np.testing.assert_allclose(energy, energy_of_two, rtol=1e-9, atol=1e-9 * abs(energy).max())
    assert np.abs(fields[1] - 0.5 * scene.velocity).max() > 1e-6
    for ours, theirs in zip(fields, fields_of_two, strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=1e-9, atol=1e-10 * np.abs(theirs).max())


def test_two_slabs_are_marched_where_v_changes():
    """They then swing together, too, which their interface does not feel."""
    scene = replace(in_ratio(0.5), drive=DRIVES["ramp"], until=40.0)
    assert scene.equivalent is not None
    solver = build("dg:8", scene, cells=2)
    follow(solver, 40.0)
    shot = solver.snapshot()
    assert np.abs(shot.upper.velocity + shot.lower.velocity[: shot.upper.velocity.size]).max() > 1e-3
