"""One slab on its staggered grid, in friction-free form: what the kernel asks of it.

Depth is measured as travel time (transits of the upper slab) from the interface, so that waves run at speed 1, and `u` is the
velocity away from steady rest in the slab's own direction of drive (u = w_1 above, u = -w_2 below): both slabs then obey

    eps u_t = sigma_s,   sigma_t = eps u_s,   u_1 + u_2 = v at the interface   (MODEL.md section 3),

with u at the n + 1 nodes at half times and sigma (less the stress of steady sliding) in the n cells at whole times. The end nodes
carry half a cell. Virieux (1986) describes the scheme in the plane; order 2, stable for dt <= dx.

    load        Z and S of  Z u + mu = S  at the interface, u the mean over the step: its half cell's momentum balance
    accelerate  velocities on to the next half step, once u is known; returns the powers of the outer face
    strain      stresses on to the next whole step
"""

from typing import NamedTuple

from fullwave.leapfrog.dispatch import dispatch
from fullwave.leapfrog.faces import Grip, Rigid, push, settle
from scene.observe.pieces import Array


class Uniform(NamedTuple):
    """Homogeneous elastic slab: u (n + 1,), sigma (n,), dt/(eps dx), eps dt/dx, grid impedance eps dx/dt."""

    velocity: Array
    stress: Array
    mobility: float
    stiffness: float
    impedance: float


def load(medium: Uniform, face: Rigid | Grip, mean: float, following: float) -> tuple[float, float]:
    """(Z, S) of the interface's half cell."""
    raise NotImplementedError(type(medium))


def accelerate(medium: Uniform, face: Rigid | Grip, rate: float, mean: float, following: float) -> tuple[float, float]:
    """Velocities on by one step, u = `rate` at the interface; (power of the drive, power radiated) less the steady stress's."""
    raise NotImplementedError(type(medium))


def strain(medium: Uniform) -> None:
    """Stresses on by one step."""
    raise NotImplementedError(type(medium))


def _load_uniform(medium, face, mean, following):  # type: ignore[no-untyped-def]
    return medium.impedance, medium.stress[0] + medium.impedance * medium.velocity[0]


def _accelerate_uniform(medium, face, rate, mean, following):  # type: ignore[no-untyped-def]
    velocity, stress = medium.velocity, medium.stress
    n = stress.size
    velocity[0] = 2.0 * rate - velocity[0]
    for j in range(1, n):
        velocity[j] += medium.mobility * (stress[j] - stress[j - 1])
    old = velocity[n]
    _, top = settle(face, medium.impedance, old, stress[n - 1], 0.0, mean, following)
    velocity[n] = 2.0 * top - old
    return push(face, stress[n - 1] + medium.impedance * (top - old), top, mean)


def _strain_uniform(medium):  # type: ignore[no-untyped-def]
    velocity, stress = medium.velocity, medium.stress
    for j in range(stress.size):
        stress[j] += medium.stiffness * (velocity[j + 1] - velocity[j])


dispatch(load, {Uniform: _load_uniform})
dispatch(accelerate, {Uniform: _accelerate_uniform})
dispatch(strain, {Uniform: _strain_uniform})
