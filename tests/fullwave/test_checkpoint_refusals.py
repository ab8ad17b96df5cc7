"""What a checkpoint must not be misread as: another setting of any family, another version, a damaged or inconsistent file."""

import dataclasses

import numpy as np
import pytest
from grid_scenes import PAPER, SCENES

import slipwave
from fullwave.discontinuous import DiscontinuousGalerkin
from fullwave.finite_difference import Leapfrog
from fullwave.finite_element import FiniteElement
from fullwave.summation_by_parts import SummationByParts
from slipwave.errors import SceneError
from slipwave.observe import EventObserver, HistoryObserver
from slipwave.solve import checkpoint, follow
from slipwave.solve.checkpoint import Checkpoints

FAST = slipwave.read("paper", ["drive.velocity=1e6"])  # friction's state limits the step: it says nothing of the cells
KINDS = {
    "fd": (Leapfrog, {"cells": 16, "cfl": 0.9}),
    "dg": (DiscontinuousGalerkin, {"number": 7, "cells": 9}),
    "sbp": (SummationByParts, {"number": 4, "cells": 24}),
    "fem": (FiniteElement, {"number": 4, "cells": 9}),
}
OTHERS = [(kind, option) for kind in KINDS for option in ("cells", "cfl", "number")]
OTHER = {"cells": 26, "cfl": 0.5, "number": 6}


def kept(path, solver, observers=None):
    return Checkpoints(solver, observers or {}, path, np.inf, 10.0)


@pytest.mark.parametrize(("kind", "option"), [o for o in OTHERS if o[1] in KINDS[o[0]][1] or o[1] in ("cfl", "cells")])
def test_every_other_setting_is_refused(tmp_path, kind, option):
    make, options = KINDS[kind]
    kept(tmp_path / "run.npz", make(FAST, **options)).save()
    with pytest.raises(SceneError, match=r"run.npz': (settings differ|model is)"):
        kept(tmp_path / "run.npz", make(FAST, **options | {option: OTHER[option]})).resume()


def test_sources_are_told_apart(tmp_path, monkeypatch):
    kept(tmp_path / "run.npz", FiniteElement(FAST)).save()
    monkeypatch.setattr(checkpoint, "source_digest", lambda: "0123")
    with pytest.raises(SceneError, match="another version of the solvers"):
        kept(tmp_path / "run.npz", FiniteElement(FAST)).resume()


def test_a_checkpoint_belongs_to_the_physics_of_one_scene(tmp_path):
    """Its digest is; the length of the run, its name and what it records may differ."""
    path = tmp_path / "run.npz"
    kept(path, Leapfrog(PAPER, 16, 0.9)).save()
    longer = dataclasses.replace(PAPER, until=9999.0, name="again", record=frozenset({"fields"}))
    kept(path, Leapfrog(longer, 16, 0.9)).resume()
    other = dataclasses.replace(PAPER, law=PAPER.law._replace(b=0.05))
    with pytest.raises(SceneError, match=r"npz': scene is '[0-9a-f]{12}'; this run needs '[0-9a-f]{12}'"):
        kept(path, Leapfrog(other, 16, 0.9)).resume()


def prepared(tmp_path, kind, chosen=PAPER):
    """Path and arrays of a run that has seen something, and a solver and observers that are to load it."""
    make, options = KINDS[kind]
    solvers = [make(chosen, **options) for _ in range(2)]
    observers = [{"e": EventObserver(chosen, one.nodes), "h": HistoryObserver(chosen.law, one.nodes)} for one in solvers]
    follow(solvers[0], 60.0, list(observers[0].values()))
    path = tmp_path / f"{kind}.npz"
    kept(path, solvers[0], observers[0]).save()
    return path, contents(path), (solvers[1], observers[1])


def contents(path):
    with np.load(path) as file:
        return {name: file[name] for name in file.files}


def refused(path, fresh):
    with pytest.raises(SceneError) as caught:
        kept(path, *fresh).resume()
    said = str(caught.value)
    assert (path.name in said, "\n" in said, "pickle" in said) == (True, False, False)
    return said


FACTS = ("[]", "{}", '{"format": 3}', '{"format": [2]}', "[" * 100_000, "")


def test_facts_that_are_none(tmp_path):
    path, arrays, fresh = prepared(tmp_path, "fd")
    for facts in FACTS:
        np.savez(path, **arrays | {"facts": np.array(facts)})
        refused(path, fresh)
    np.savez(path, **{name: array for name, array in arrays.items() if name != "facts"})
    assert "not a checkpoint, or damaged" in refused(path, fresh)


@pytest.mark.parametrize("kind", ["fd", "dg"])
@pytest.mark.parametrize("damage", ["array flipped", "byte flipped", "cut"])
def test_a_damaged_file_is_refused(tmp_path, kind, damage):
    path, whole, fresh = prepared(tmp_path, kind, SCENES["unlike"])
    kept(path, *fresh).resume()
    good = bytearray(path.read_bytes())
    if damage == "array flipped":
        name = max(whole, key=lambda name: whole[name].nbytes)
        flipped = whole[name].copy()
        flipped.view(np.uint8).ravel()[-1] ^= 0x40
        np.savez(path, **whole | {name: flipped})
    else:
        good[len(good) // 2] ^= 0x40
        path.write_bytes(good if damage == "byte flipped" else good[: len(good) // 2])
    refused(path, fresh)


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
