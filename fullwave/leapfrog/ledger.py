"""The energy that the leapfrog conserves, and the energy that has left it (per unit area, in units of sigma L, since t = 0).

With u at n + 1/2 and sigma at n the scheme conserves  sum m u^2/2 + sum dx sigma^n sigma^(n+1)/(2 eps)  exactly, so the ledger
closes to rounding. The kernel only adds up the powers of drive, friction, dashpots and viscosity; the stored energy is computed
here on request. Stresses are stored as deviations from steady sliding, whose stress enters separately, without cancellation.
"""

import numpy as np

from fullwave.leapfrog.faces import Grip
from fullwave.leapfrog.grid import LeapfrogGrid
from fullwave.leapfrog.kernel import FRICTION, INPUT
from fullwave.leapfrog.sides import Side
from fullwave.leapfrog.viscous import StandardLinear
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from slipwave.solve import Energy


def energy_of(scene: Scene, memory: Array, sides: list[tuple[Side, LeapfrogGrid]]) -> Energy:
    """Ledger of `sides`; the only side of alike slabs counts twice."""
    sums = [side_energy(side, grid, scene.steady_stress, 0.5 * scene.velocity) for side, grid in sides]
    copies = 2 if scene.alike else 1
    stored, radiated, viscous = (copies * sum(column) for column in zip(*sums, strict=True))
    unit = scene.transit
    spent = unit * sides[0][1].step
    return Energy(
        input=float(spent * memory[INPUT]),
        friction=float(spent * memory[FRICTION]),
        radiated=unit * radiated,
        viscous=unit * viscous,
        stored=unit * stored,
    )


def side_energy(side: Side, grid: LeapfrogGrid, steady_stress: float, velocity: float) -> tuple[float, float, float]:
    """(change of stored energy, radiated energy, energy lost to viscosity) of a slab, in units of sigma L / transit."""
    medium, face = side
    stretch = np.diff(medium.velocity)
    kinetic = 0.5 * float(grid.mass @ ((medium.velocity - velocity) * (medium.velocity + velocity)))
    relaxed, ahead, compliance = medium.stress, medium.stress + grid.stiffness * stretch, grid.width / (2.0 * grid.impedance)
    branch, viscous = 0.0, float(getattr(medium, "lost", np.zeros(1))[0]) * grid.step
    if isinstance(medium, StandardLinear):
        q, unrelaxed = medium.relaxing, medium.branch / grid.stiffness
        mean = (q + 0.5 * medium.branch * stretch) / (1.0 + medium.half_decay)
        q_ahead = 2.0 * mean - q
        branch = float((compliance / unrelaxed) @ (q * q_ahead))
        viscous += 0.5 * grid.step * float(medium.weight @ (q * mean))
        relaxed = medium.stress - q
        ahead = ahead - 2.0 * medium.half_decay * mean - q_ahead
        compliance = compliance / (1.0 - unrelaxed)
    elastic = float(compliance @ (relaxed * ahead + steady_stress * (relaxed + ahead)))
    spring, radiated = _face_energy(face, steady_stress, grid.step)
    return kinetic + elastic + branch + spring, radiated, viscous


def _face_energy(face: object, steady_stress: float, step: float) -> tuple[float, float]:
    if not isinstance(face, Grip):
        return 0.0, 0.0
    stiffness = 2.0 * face.half_spring / step
    load = float(face.memory[0])
    spring = load * (load + 2.0 * steady_stress) / (2.0 * stiffness) if stiffness > 0.0 else 0.0
    return spring, float(face.memory[1]) * step
