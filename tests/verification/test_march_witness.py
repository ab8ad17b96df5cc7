"""Witnesses: method of lines against the delay system, the leapfrog against discontinuous Galerkin."""

import pytest

import slipwave
from fullwave.discontinuous import DiscontinuousGalerkin
from reduced.delay.system import delay_system
from slipwave.scene.slab import GripFace, Layer, MachineFace, ReflectingFace
from slipwave.solve import follow
from tests.fullwave.grid_scenes import SLAB, of

SCENES = {
    "twice as thick": of({}, {"round_trip": 2 * SLAB.round_trip, "epsilon": 3 * SLAB.epsilon}),
    "incommensurate": of({}, {"round_trip": 2**0.5 * SLAB.round_trip, "epsilon": 3 * SLAB.epsilon}),
    "grips": of({"face": GripFace(2.0, 1.5)}),
    "one grip": of({"face": GripFace(2.0, 1.5)}, {"round_trip": 2**0.5 * SLAB.round_trip}),
    "grip below": of({}, {"face": GripFace(2.0, 1.5), "round_trip": 2**0.5 * SLAB.round_trip, "epsilon": 3 * SLAB.epsilon}),
    "layers below, on a grip": of(
        {}, {"layers": (Layer(0.4, 1.0), Layer(0.6, 2.0)), "face": GripFace(2.0, 1.5), "round_trip": 1.5 * SLAB.round_trip}
    ),
    "machines": of({"face": MachineFace(2.0, 0.5, 0.4)}),
    "machine below": of(
        {}, {"face": MachineFace(2.0, 1.5, 0.05), "round_trip": 2**0.5 * SLAB.round_trip, "epsilon": 3 * SLAB.epsilon}
    ),
    "machine on layers": of({"layers": (Layer(0.4, 1.0), Layer(0.6, 2.0)), "face": MachineFace(2.0, 0.0, 0.3)}),
    "masses under a dead load": of({"face": MachineFace(0.0, 0.5, 0.4)}, {"face": MachineFace(0.0, 0.0, 2.0)}),
    "reflecting": of({"face": ReflectingFace(0.9)}),
    "one absorbing": of({"face": ReflectingFace(0.0)}, {}),
    "layers": of({"layers": (Layer(0.4, 1.0), Layer(0.6, 2.0))}, {}),
    "three layers": of({"layers": (Layer(0.2, 1.0), Layer(0.3, 2.0), Layer(0.5, 0.6))}),
    "four layers below": of({}, {"layers": tuple(Layer(0.25, z) for z in (1.0, 3.0, 0.5, 2.0)), "epsilon": 2 * SLAB.epsilon}),
    **{law: slipwave.read(law, ["start.kind=nudge", "start.size=0.5"]) for law in ("slip-law", "regularised")},
    "grip on layers": of({"layers": (Layer(0.4, 1.0), Layer(0.6, 2.0)), "face": GripFace(2.0, 1.5)}),
}


@pytest.mark.parametrize("name", SCENES)
def test_final_state_agrees_with_the_delay_system(name):
    """Measured: 7e-13 in psi and ln v, 2e-14 in mu."""
    exact = follow(delay_system(SCENES[name], tolerance=1e-11), 150.0)
    final = follow(DiscontinuousGalerkin(SCENES[name], number=9, cells=6, time="explicit"), 150.0)
    assert (final.psi, final.ln_v) == (pytest.approx(exact.psi, abs=1e-11), pytest.approx(exact.ln_v, abs=1e-11))
    assert final.mu == pytest.approx(exact.mu, abs=4e-13)
