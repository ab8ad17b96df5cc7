"""Growth that a step cannot follow is never damped in silence: steps become short enough, or the run is refused.

An implicit step of growth z multiplies a disturbance by R(z), not by e^z; beyond the poles of R it damps what should grow, and a
run of smooth, wrong, steady sliding is the result. Here disturbances start far below what the test of resolution can see.
"""

import math

import numpy as np
import pytest
from reduction_equations import Equations

import slipwave
from fullwave.finite_difference import Leapfrog
from reduced.delay.system import delay_system
from reduced.impedance import reduction_of
from reduced.ode.slabs import ReducedModel
from slipwave.errors import NumericsError
from slipwave.solve import follow
from slipwave.step.collocation import growth_limit, radau

TINY = ['start.kind="jump"', "start.size=1e-10"]
"""A disturbance a hundred thousand times the rounding of psi, ten times below the resolution of a step."""


def amplification(stages, z):
    """R(z) = P/Q, the Pade approximation of e^z with degrees stages - 1 over stages (Hairer and Wanner II, IV.3)."""
    k, j = stages - 1, stages
    factorial = math.factorial
    top = sum(
        factorial(k) * factorial(j + k - i) / (factorial(i) * factorial(k - i) * factorial(j + k)) * z**i for i in range(k + 1)
    )
    bottom = sum(
        factorial(j) * factorial(j + k - i) / (factorial(i) * factorial(j - i) * factorial(j + k)) * (-z) ** i
        for i in range(j + 1)
    )
    return top / bottom


@pytest.mark.parametrize("stages", [5, 6, 8])
@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-9])
def test_the_limit_is_where_the_stability_function_leaves_the_exponential(stages, tolerance):
    limit = growth_limit(stages, tolerance)
    assert abs(amplification(stages, limit) * math.exp(-limit) - 1.0) <= tolerance * 1.01
    assert abs(amplification(stages, limit + 0.02) * math.exp(-limit - 0.02) - 1.0) > tolerance


def test_what_the_collocation_does_with_growth():
    for z in (1.0, 3.0, 70.0):
        ours = np.linalg.solve(np.eye(8) - z * radau(8).integral, np.ones(8))[-1]
        assert ours == pytest.approx(amplification(8, z), rel=1e-6)
    assert (growth_limit(8, 1e-9), growth_limit(6, 1e-9)) == (pytest.approx(3.15), pytest.approx(1.54))
    assert abs(amplification(8, 61.0)) > 1.0 > abs(amplification(8, 62.0))


@pytest.mark.parametrize(
    ("name", "settings", "model", "ends"),
    [
        ("paper", ["slab.r=10"], "kelvin-voigt", (0.06, 0.1, 0.5)),
        ("paper", ["slab.r=1000"], "kelvin-voigt", (0.0008, 0.01)),
        ("rock", ["slab.thickness=1000"], "quasidynamic", (0.1, 0.5)),
    ],
)
def test_reductions_leave_an_unstable_state(name, settings, model, ends):
    scene = slipwave.read(name, [*settings, *TINY])
    reduction = reduction_of(scene, model)
    solver = ReducedModel(scene, reduction)
    ours = [follow(solver, end).psi for end in ends]
    exact = Equations(scene, reduction).motion_at(ends, 3e-14, "DOP853")[:, 0]
    assert abs(ours[-1] - scene.steady_psi) > 1.0
    assert ours == pytest.approx(exact, abs=1e-3)  # rounding is 4e-6 of the disturbance, and grows with it: 1e-4 measured


def test_the_delay_system_leaves_an_unstable_state():
    """2252 roots grow, the leading one by 4634 nepers a transit; the leapfrog's error is second order in its step."""
    scene = slipwave.read("rock", ["slab.thickness=20000", *TINY])
    ours = follow(delay_system(scene), 0.1).psi
    coarse, fine = (follow(Leapfrog(scene, cells), 0.1).psi for cells in (8000, 16000))
    assert ours > scene.steady_psi + 5.0
    assert ours == pytest.approx(fine + (fine - coarse) / 3.0, abs=1e-3)


LAYERS = "slab.layers=[{fraction=0.4, impedance=1.0}, {fraction=0.6, impedance=2.0}]"


@pytest.mark.parametrize(
    "settings",
    [[], [LAYERS], ["drive.velocity=[[0, 100], [0.3, 100], [0.7, 110]]"], ["drive.velocity=[[0, 100], [5, 101]]", LAYERS]],
)
def test_the_delay_system_refuses_what_its_steps_cannot_follow(settings):
    scene = slipwave.read("paper", ["slab.r=1000", *settings])
    with pytest.raises(NumericsError) as refusal:
        follow(delay_system(scene), 3.0)
    words = str(refusal.value)
    assert "disturbances grow at 3.471e+04 per transit" in words
    steps = int(words.split(" steps per transit, the largest number")[0].rsplit(" ", 1)[1])
    most = 4096 / (0.4 if LAYERS in settings else 1.0)  # in the round trip of the thinner layer
    assert most / 2 < steps < 1.01 * most < 34711 / 3.15
    assert f"by e^{34710.7438 / steps:.3g} in one of {steps} steps" in words
    assert "a step can follow at most e^3.15" in words
    assert "fd with 34711 cells or more" in words
