"""Noise at the scale of the grid in slabs that are locked by friction."""

import math

import numpy as np

import slipwave
from slipwave.errors import NumericsError
from slipwave.observe.statistics import Estimate
from slipwave.scene import Scene
from slipwave.solve import FieldSolver, follow
from validation.measure.grids.limits import few_cells
from validation.models.build import build_full_wave


def locked() -> Scene:
    """The slabs of the paper locked by friction: where hardly anything slides, a wave hardly changes the slip rate."""
    return slipwave.read("paper", ["drive.velocity=1e-6", "start.size=0"])


def noise_left(transits: float) -> Estimate:
    """What friction leaves of the energy of waves in a locked slab after `transits`. A wave of velocity u makes slip at a rate of
    4 Z u V/a, which takes a share 4 Z V/a of the energy in every transit; a/v is not constant, by that slip over V: the error."""
    scene = locked()
    share = 4.0 * scene.impedance * scene.velocity / scene.law.a
    left = math.exp(-share * transits)
    return Estimate(left, (1.0 - left) * share / scene.velocity)


def locked_noise(model: str, transits: float) -> float:
    """Energy left of noise in a locked slab after `transits`, over its mean in the first ten; infinite if the run broke down."""
    scene = locked()
    solver = build_full_wave(model, scene, cells=few_cells(model), cfl=1.0)
    solver.disturb(np.random.default_rng(1).standard_normal, stressed=False)
    try:
        first = np.mean([_energy(solver, moment) for moment in 2.0 * np.arange(1.0, 6.0)])
        last = np.mean([_energy(solver, moment) for moment in transits + 2.0 * np.arange(1.0, 6.0)])
    except NumericsError:
        return math.inf
    return float(last / first)


def _energy(solver: FieldSolver, moment: float) -> float:
    follow(solver, moment)
    return solver.deviation_energy()
