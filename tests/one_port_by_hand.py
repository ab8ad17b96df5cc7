"""Impedances and growth rates by hand: MODEL.md section 3 in plain complex arithmetic, with none of our code.

s is on the friction clock. A viscous slab has the modulus G g(s): its impedance is eps sqrt(g) and its travel time T/sqrt(g).
"""

import cmath

import numpy as np

from slipwave.scene.slab import GripFace, KelvinVoigtViscosity, MachineFace, ReflectingFace, StandardLinearViscosity


def modulus(slab, s):
    """g(s). Kelvin-Voigt: a dashpot beside the spring. Zener: a spring 1/(1 + ratio) beside a Maxwell element whose spring,
    ratio/(1 + ratio), makes up the unrelaxed modulus."""
    match slab.viscosity:
        case KelvinVoigtViscosity(time):
            return 1.0 + time * s
        case StandardLinearViscosity(time, ratio):
            return (1.0 + ratio * time * s / (1.0 + time * s)) / (1.0 + ratio)
    return 1.0 + 0.0 * s


def slab_impedance(slab, s):
    """Z_in = e (Z_top + e tanh x)/(e + Z_top tanh x), layer by layer from the outer face."""
    root = cmath.sqrt(modulus(slab, s))
    top = None  # None: rigid
    match slab.face:
        case GripFace(stiffness, dashpot):
            top = dashpot * slab.epsilon + stiffness * slab.epsilon / slab.round_trip / s
        case MachineFace(stiffness, dashpot, mass):
            top = slab.epsilon * (dashpot + stiffness / (slab.round_trip * s) + mass * slab.round_trip * s)
        case ReflectingFace(coefficient) if coefficient < 1.0:
            top = slab.epsilon * slab.layers[-1].impedance * (1.0 + coefficient) / (1.0 - coefficient)
    for layer in reversed(slab.layers):
        own = slab.epsilon * layer.impedance * root
        tanh = cmath.tanh(0.5 * s * slab.round_trip * layer.fraction / root)
        top = own / tanh if top is None else own * (top + own * tanh) / (own + top * tanh)
    assert top is not None
    return top


def pair_impedance(scene, s):
    return 1.0 / (1.0 / slab_impedance(scene.upper, s) + 1.0 / slab_impedance(scene.lower, s))


def friction_impedance(scene, s):
    """(F_v s + G_phi F_ss')/(s + G_phi) of the ageing and slip laws: F_v = a/V, G_phi = V, F_ss' = (a - b)/V."""
    law, v = scene.law, scene.drive.velocities[0]
    return (law.a / v * s + (law.a - law.b)) / (s + v)


def leading_root(scene, impedance=None):
    """Root s of H + Z = 0 near the critical frequency i V sqrt((b - a)/a), by secants; Z exact unless given."""
    law, v = scene.law, scene.drive.velocities[0]

    def total(s):
        return friction_impedance(scene, s) + (impedance(s) if impedance else pair_impedance(scene, s))

    before, here = 0.98j * v * np.sqrt((law.b - law.a) / law.a), 1.01j * v * np.sqrt((law.b - law.a) / law.a)
    last = total(before)
    for _ in range(100):
        value = total(here)
        if value == last or abs(here - before) < 1e-15 * abs(here):
            break
        before, here, last = here, here - value * (here - before) / (value - last), value
    assert abs(total(here)) < 1e-10 * abs(friction_impedance(scene, here))
    return complex(here)
