"""Scenes for the tests of impedance and stability: one of every kind of slab."""

import math

from slipwave.friction.ageing import Ageing
from slipwave.scene import Scene
from slipwave.scene.drive import steady_drive
from slipwave.scene.slab import GripFace, KelvinVoigtViscosity, Layer, MachineFace, ReflectingFace, Slab, StandardLinearViscosity

PAPER = Ageing(0.369, 0.0349, 0.0489)
EPSILON, ROUND_TRIP = 2.8e-5, 10**-2.68
LAYERS = (Layer(0.3, 1.0), Layer(0.5, 2.0), Layer(0.2, 0.1))


def scene_of(upper, lower=None, velocity=100.0, law=PAPER):
    return Scene("test", law, upper, lower or upper, steady_drive(velocity))


def paper(round_trip=ROUND_TRIP, velocity=100.0, epsilon=EPSILON, law=PAPER):
    return scene_of(Slab(epsilon, round_trip), velocity=velocity, law=law)


def slab(**keys):
    return Slab(EPSILON, ROUND_TRIP, **keys)


LOSSLESS = {
    "plain": paper(),
    "ratio 2": scene_of(slab(), Slab(3.0 * EPSILON, 2.0 * ROUND_TRIP)),
    "ratio sqrt 2": scene_of(slab(), Slab(3.0 * EPSILON, math.sqrt(2.0) * ROUND_TRIP)),
    "same time": scene_of(slab(), Slab(3.0 * EPSILON, ROUND_TRIP)),
    "layered": scene_of(slab(layers=LAYERS), Slab(2.0 * EPSILON, 1.3 * ROUND_TRIP)),
}
LOSSY = {
    "grip": scene_of(slab(face=GripFace(2.0, 3.0))),
    "matched grip": scene_of(slab(face=GripFace(1.0, 1.0))),
    "grip below": scene_of(slab(), Slab(2.0 * EPSILON, 0.7 * ROUND_TRIP, GripFace(5.0, 0.3))),
    "machine": scene_of(slab(face=MachineFace(2.0, 0.5, 0.4))),
    "machine below": scene_of(slab(), Slab(2.0 * EPSILON, 0.7 * ROUND_TRIP, MachineFace(5.0, 1.2, 0.4))),
    "reflection": scene_of(slab(face=ReflectingFace(0.5))),
    "standard linear": scene_of(slab(viscosity=StandardLinearViscosity(3.0 * ROUND_TRIP, 0.5))),
    "kelvin-voigt solid": scene_of(slab(viscosity=KelvinVoigtViscosity(0.05 * ROUND_TRIP))),
}
EVERY = LOSSLESS | LOSSY
