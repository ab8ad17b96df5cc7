"""The leapfrog's friction over one step: a known root is found from any start, by Newton's method from a near one."""

from typing import NamedTuple

import numpy as np
import pytest

from fullwave.leapfrog import kernel
from fullwave.leapfrog.friction import solve_friction
from slipwave.compiled import njit
from slipwave.friction import LAWS, Law, respond, steady_state, unknown_of

LAW_NAMES = ("ageing", "slip", "ageing-regularised", "slip-regularised")


class Step(NamedTuple):
    """The data of a step, and its root."""

    law: Law
    impedance: float
    incoming: float
    old: float
    half: float
    push: float
    z: float
    psi: float
    v: float

    def solved(self, off):
        return solve_friction(*self[:6], self.z + off, self.psi - 0.5 * off)


def step(name, rate, half, lag=0.3, push=1e-3):
    """That ends at `rate` with psi above its steady value by `lag`."""
    law = LAWS[name].parameters(0.369, 0.0349, 0.0489)
    z, psi, impedance = unknown_of(law, rate), steady_state(law, rate) + lag, 1.4e-5
    v, _, mu, _, _, psi_rate, *_ = respond(law, z, psi)
    return Step(law, impedance, mu + impedance * v, psi - half * psi_rate - push, half, push, z, psi, v)


def steps(name):
    """With steps of up to a tenth of the time in which the state evolves."""
    return [step(name, rate, share / rate, lag) for rate in (1e-2, 1.0, 1e2, 1e4) for share in (1e-3, 0.1) for lag in (-0.5, 0.3)]


@pytest.mark.parametrize("name", LAW_NAMES)
@pytest.mark.parametrize("off", [0.0, 1e-3, 0.3, -0.3, 3.0, -3.0, 20.0, -20.0, 300.0, -300.0])
def test_the_root_is_found_from_anywhere(name, off):
    for one in steps(name):
        z, psi, v, converged = one.solved(off)
        assert converged
        assert (z, psi) == pytest.approx((one.z, one.psi), abs=2e-12)
        assert v == pytest.approx(one.v, rel=1e-11)


@njit
def extrapolated(memory, slot):
    """As the kernel compiles it."""
    return kernel._extrapolated(memory, slot)


def test_newtons_start_is_exact_for_a_quartic():
    memory = np.zeros(16)
    quartic = np.array([0.3, -1.0, 2.0, 0.5, 4.0])
    memory[6:11] = np.polyval(quartic, -np.arange(5.0))
    assert extrapolated(memory, 6) == pytest.approx(np.polyval(quartic, 1.0), rel=1e-12)
