"""Exact solutions in slabs whose friction depends on the rate alone (ageing law with b = 0, so F = a ln v).

Deviations from steady sliding at V = 1 with zero stress; depth x is travel time from the interface, one transit the clock,
the outer face at x = 1/2.
"""

import dataclasses

import numpy as np
import scipy.sparse

import slipwave
from fullwave.lines.explicit import STEPS_PER_PIECE
from slipwave.friction.ageing import Ageing
from slipwave.observe.pieces import SAME
from slipwave.scene.drive import Start, steady_drive
from slipwave.scene.slab import Slab

EPSILON = 0.02
SLAB = Slab(EPSILON, 1e-3)
LOCKED = 1e15
"""Direct effect a so large that no wave changes the slip rate."""


def rate_scene(direct, upper=None, lower=None, **changes):
    """Two slabs on an interface with F = `direct` ln v, sliding steadily at V = 1."""
    upper = SLAB if upper is None else dataclasses.replace(SLAB, **upper)
    lower = upper if lower is None else dataclasses.replace(SLAB, **lower)
    changes |= {"law": Ageing(0.0, direct, 0.0), "drive": steady_drive(1.0), "start": Start(size=0.0)}
    return dataclasses.replace(slipwave.read("paper"), upper=upper, lower=lower, **changes)


def tiling(make, scene, time):
    """The solver that `make` builds for `scene`, with steps shortened so that whole pieces tile `time`."""
    usual = make(scene)
    pieces = np.ceil(time / (STEPS_PER_PIECE * usual.step) - 1e-9)
    return make(scene, cfl=usual.cfl * time / (STEPS_PER_PIECE * pieces * usual.step))


def step_to(solver, time):
    """March to exactly `time`, which whole pieces tile."""
    while solver.time < time - SAME:
        solver.advance(time)


def fields(solver, slab=0):
    """Depth, deviations of velocity (own direction) and of stress over the impedance, by blocks, and the norm, sparse."""
    blocks = [block for block in solver.grid.blocks if block.section.slab == slab]
    state = solver.state()["state"]
    joined = [
        np.concatenate(parts) for parts in zip(*((b.depth, state[b.velocity], state[b.stress]) for b in blocks), strict=True)
    ]
    norms = [scipy.sparse.diags_array(b.norm) if isinstance(b.norm, np.ndarray) else b.norm for b in blocks]
    return (*joined, scipy.sparse.block_diag(norms, format="csr"))


def impose(solver, velocity, stress):
    """Set the fields of the upper slab: deviations, as in `fields`, as functions of depth."""
    state = solver.state()
    for block in solver.grid.blocks:
        if block.section.slab == 0:
            state["state"][block.velocity], state["state"][block.stress] = velocity(block.depth), stress(block.depth)
    solver.restore(state)


def squared(norm, *errors):
    """Sum of e.H e, twice the energy of the fields `errors` over the impedance."""
    return float(sum(error @ (norm @ error) for error in errors))


def standing_error(make, waves=3, time=1.3):
    """L2 error of both fields of the standing wave w = cos(k t) sin(k x), s = sin(k t) cos(k x), the interface locked: root mean
    square over the pieces from t = 0.8 to `time`, since errors of the wave's phase and of its shape take turns."""
    solver = tiling(make, rate_scene(LOCKED), 0.8)
    k = 2.0 * np.pi * waves
    impose(solver, lambda x: np.sin(k * x), np.zeros_like)
    step_to(solver, 0.8)
    squares = []
    while solver.time < time:
        solver.advance(solver.time + STEPS_PER_PIECE * solver.step)
        x, w, s, norm = fields(solver)
        exact_w, exact_s = np.cos(k * solver.time) * np.sin(k * x), np.sin(k * solver.time) * np.cos(k * x)
        squares.append(squared(norm, w - exact_w, s - exact_s))
    return float(np.sqrt(np.mean(squares)))
