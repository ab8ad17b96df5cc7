"""Turns a scene into the structures that the kernel marches."""

import numpy as np

from fullwave.leapfrog.faces import compiled_face
from fullwave.leapfrog.grid import LeapfrogGrid
from fullwave.leapfrog.kernel import DRIVE, ELASTIC, MEMORY, PSI, STATE, STRESS, Z
from fullwave.leapfrog.media import Medium, elastic_medium
from fullwave.leapfrog.sides import Side
from fullwave.leapfrog.viscous import kelvin_voigt_medium, standard_linear_medium
from slipwave.friction import unknown_of
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from slipwave.scene.slab import KelvinVoigtViscosity, Slab, StandardLinearViscosity


def steady_side(scene: Scene, slab: Slab, grid: LeapfrogGrid) -> Side:
    """A slab in steady sliding at the scene's initial velocity."""
    face = compiled_face(slab.termination.in_transits(scene.transit), grid.step, scene.steady_stress)
    velocity = 0.5 * scene.velocity
    medium: Medium
    if isinstance(slab.viscosity, KelvinVoigtViscosity) and slab.viscosity.time > 0.0:
        medium = kelvin_voigt_medium(grid, velocity, slab.viscosity.time / scene.transit, face)
    elif isinstance(slab.viscosity, StandardLinearViscosity) and slab.viscosity.ratio > 0.0:
        medium = standard_linear_medium(grid, velocity, slab.viscosity.time / scene.transit, slab.viscosity.ratio)
    else:
        medium = elastic_medium(grid, velocity)
    return Side(medium, face)


def steady_memory(scene: Scene) -> Array:
    """Interface memory of steady sliding half a step before t = 0, psi shifted if the start is a jump."""
    memory = np.zeros(MEMORY)
    psi = scene.steady_psi + scene.start.jump_size
    memory[STATE] = psi
    memory[Z:PSI] = unknown_of(scene.law, scene.velocity)
    memory[PSI : PSI + 5] = psi
    memory[[STRESS, ELASTIC]] = scene.steady_stress
    memory[DRIVE] = scene.drive.initial
    return memory
