"""The echo train of a layered slab: every reflection at the jump of impedance, at the locked interface and at the rigid face,
for three and a half round trips, against the lattice of pulses that two layers of equal travel time make by d'Alembert."""

from functools import partial

import numpy as np
import pytest
from exact_waves import LOCKED, fields, pulse, rate_scene, send, squared, step_to, tiling

from fullwave.discontinuous import DiscontinuousGalerkin
from fullwave.finite_element import FiniteElement
from fullwave.summation_by_parts import SummationByParts
from slipwave.scene.slab import Layer

RATIO = 2.5


def layered(ratio):
    """Two layers of equal travel time on a locked interface; impedance of the far one over the near one's."""
    return rate_scene(LOCKED, {"layers": (Layer(0.5, 1.0), Layer(0.5, ratio))})


HOP = 0.25
"""Travel time of a layer: after every hop all pulses are in the middle of a layer."""

FAMILIES = {
    "dg:7": partial(DiscontinuousGalerkin, number=7, cells=16, time="explicit"),
    "fem:6": partial(FiniteElement, number=6, cells=24, time="explicit"),
    "fem:5 consistent": partial(FiniteElement, number=5, cells=36, mass="consistent", time="explicit"),
    "sbp:6": partial(SummationByParts, number=6, cells=192, time="explicit"),
}


def lattice(hops, ratio=RATIO):
    """Velocities of the pulses in the middle of the layers after `hops`, starting with 1 outwards in the near one; indices: layer
    (near, far), direction (outwards, inwards). Behind a jump of impedance by k come (1 - k)/(1 + k) back and 2/(1 + k) on."""
    pulses = np.array([[1.0, 0.0], [0.0, 0.0]])
    back, on = (1.0 - ratio) / (1.0 + ratio), 2.0 / (1.0 + ratio)
    for _ in range(hops):
        (near_out, near_in), (far_out, far_in) = pulses
        near = (-near_in, back * near_out + ratio * on * far_in)
        far = (on * near_out - back * far_in, -far_out)
        pulses = np.array([near, far])
    return pulses


def echo_error(make, ratio=RATIO, hops=14):
    """L2 error of velocity and stress over impedance after `hops`."""
    solver = tiling(make, layered(ratio), hops * HOP)
    send(solver, lambda x: pulse(x, 0.125, 0.025) * (x <= 0.25), +1)
    step_to(solver, hops * HOP)
    x, w, s, norm = fields(solver)
    shape = np.stack([pulse(x, middle, 0.025) for middle in (0.125, 0.375)])
    outwards, inwards = lattice(hops, ratio).T @ shape
    return np.sqrt(squared(norm, w - outwards - inwards, s + outwards - inwards))


def test_the_lattice_keeps_the_energy():
    """eps w^2 summed over the layers; each layer is left with one sum of many echoes."""
    pulses = lattice(14)
    assert (pulses**2).sum(axis=1) @ [1.0, RATIO] == pytest.approx(1.0, rel=1e-12)
    assert (np.abs(pulses).max(axis=1) > 0.2).all()


@pytest.mark.parametrize("family", FAMILIES)
def test_echo_train(family):
    assert echo_error(FAMILIES[family]) < 1e-5


@pytest.mark.parametrize("cells", [12, 24, 48])
def test_a_jump_of_impedance_costs_no_accuracy(cells):
    """The error is that of as long a way through a uniform slab, coarse or fine."""
    jumped, plain = (echo_error(partial(DiscontinuousGalerkin, number=4, cells=cells, time="explicit"), k) for k in (RATIO, 1.0))
    assert jumped < 1.5 * plain
