"""What a run costs: time in proportion to cells times steps, twice for two slabs, nothing for a rigid face; memory of one grid.

Times are processor time, the least of several runs taken in turn, so that only ratios of neighbours in one test are compared.
"""

import dataclasses
import time
import tracemalloc

import numpy as np
import pytest

import scene
from scene.observe import follow
from scene.slab import GripFace, ReflectingFace
from validation.models import build

PAPER = scene.read("paper")
GRIDS = {"fd": 128, "sbp:4": 64, "fem:4": 16, "dg:7": 8}
"""Cells that make a transit cost some 0.1 ms or, in the method of lines, 0.3 ms."""
EVERY = pytest.mark.parametrize("model", GRIDS)


def seconds(model, runs, repeats=4):
    """Least time of each of `runs` (scene, cells, transits)."""
    times = np.full((repeats, len(runs)), np.inf)
    for repeat in range(repeats):
        for number, (what, cells, transits) in enumerate(runs):
            solver = build(model, what, cells=cells)
            follow(solver, 1.0)
            began = time.process_time()
            follow(solver, 1.0 + transits)
            times[repeat, number] = time.process_time() - began
    return times.min(axis=0)


def faced(face):
    """The paper's scene, both slabs held through `face`."""
    slab = dataclasses.replace(PAPER.upper, face=face)
    return dataclasses.replace(PAPER, upper=slab, lower=slab)


@EVERY
def test_time_is_proportional_to_cells_times_steps(model):
    """Twice the transits: twice the time. Four times the cells: four times the steps, so 16 times the time or less."""
    cells = GRIDS[model]
    base, longer, finer = seconds(model, [(PAPER, cells, 20.0), (PAPER, cells, 40.0), (PAPER, 4 * cells, 20.0)])
    print(f"{model}: {longer / base:.2f} for twice the transits, {finer / base:.1f} for four times the cells")
    assert 1.6 < longer / base < 2.4
    assert 4.0 < finer / base < 20.0


@EVERY
def test_unlike_slabs_cost_twice_what_alike_ones_do(model):
    """Equal round trips, so that both have the same cells and steps."""
    unlike = dataclasses.replace(PAPER, lower=dataclasses.replace(PAPER.lower, epsilon=1.001 * PAPER.lower.epsilon))
    alike, both = seconds(model, [(PAPER, 2 * GRIDS[model], 20.0), (unlike, 2 * GRIDS[model], 20.0)])
    print(f"{model}: unlike over alike {both / alike:.2f}")
    assert both / alike < 2.3


@EVERY
def test_a_rigid_face_costs_nothing(model):
    """No dearer than faces that do more, which themselves add no more than one node's worth."""
    faces = [PAPER, faced(GripFace(100.0, 10.0)), faced(ReflectingFace(0.999))]
    rigid, grip, reflecting = seconds(model, [(what, GRIDS[model], 20.0) for what in faces])
    print(f"{model}: grip over rigid {grip / rigid:.2f}, reflection over rigid {reflecting / rigid:.2f}")
    assert rigid < 1.1 * min(grip, reflecting)
    assert max(grip, reflecting) < 1.4 * rigid


def peak(model, cells, transits):
    """Most memory (bytes) that a run holds at once, the solver included, with everything compiled."""
    follow(build(model, PAPER, cells=cells), 0.1)
    tracemalloc.start()
    try:
        follow(build(model, PAPER, cells=cells), transits)
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


@EVERY
def test_memory_does_not_grow_with_the_run(model):
    """What a chunk of samples takes is all that a long run holds beside the grid.

    Some tens of kB of the interpreter's own come and go; keeping the samples would take ten times as much."""
    short, long = (peak(model, GRIDS[model], transits) for transits in (400.0, 1200.0))
    print(f"{model}: {short / 1e3:.0f} kB, {long / 1e3:.0f} kB for three times as long")
    assert long < 1.5 * short


@EVERY
def test_memory_is_one_grid(model):
    """Bytes per value of the fields: the stages of the time stepping (12 of them, and the leapfrog has none) and the operator."""
    cells = 8 * GRIDS[model]
    coarse, fine = peak(model, cells, 0.1), peak(model, 4 * cells, 0.1)
    per_cell = {"fd": 1, "sbp:4": 1, "fem:4": 4, "dg:7": 8}[model]
    values = 2 * 3 * cells * per_cell
    print(f"{model}: {(fine - coarse) / values / 8:.1f} grids, {fine / 1e6:.2f} MB")
    assert fine - coarse < (12 if model == "fd" else 50) * 8 * values
