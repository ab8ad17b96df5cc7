"""The leapfrog's friction over one step: a known root is found from any start, by Newton's method from a near one."""

import math
from typing import NamedTuple

import numpy as np
import pytest

from fullwave.leapfrog import friction, kernel
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

    def solved(self, off: float) -> tuple[float, float, float, bool]:
        return solve_friction(*self[:6], self.z + off, self.psi - 0.5 * off)


def step(name: str, rate: float, half: float, lag: float = 0.3, push: float = 1e-3) -> Step:
    """That ends at `rate` with psi above its steady value by `lag`."""
    law = LAWS[name].parameters(0.369, 0.0349, 0.0489)
    z, psi, impedance = unknown_of(law, rate), steady_state(law, rate) + lag, 1.4e-5
    v, _, mu, _, _, psi_rate, *_ = respond(law, z, psi)
    return Step(law, impedance, mu + impedance * v, psi - half * psi_rate - push, half, push, z, psi, v)


def steps(name: str) -> list[Step]:
    """With steps of up to a tenth of the time in which the state evolves."""
    return [step(name, rate, share / rate, lag) for rate in (1e-2, 1.0, 1e2, 1e4) for share in (1e-3, 0.1) for lag in (-0.5, 0.3)]


@pytest.mark.parametrize("name", LAW_NAMES)
@pytest.mark.parametrize("off", [0.0, 1e-3, 0.3, -0.3, 3.0, -3.0, 20.0, -20.0])
def test_the_root_is_found_from_anywhere(name: str, off: float) -> None:
    for one in steps(name):
        z, psi, v, converged = one.solved(off)
        assert converged
        assert (z, psi) == pytest.approx((one.z, one.psi), abs=2e-12)
        assert v == pytest.approx(one.v, rel=1e-11)


@pytest.mark.parametrize("name", LAW_NAMES)
def test_newtons_method_does_it_alone_from_near_and_not_at_all_from_far(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Within six evaluations of the law; a step of 2 or more is not believed."""
    evaluations, bracketed = [0], (0.0, 0.0, 0.0, False)

    def counted(*arguments: float) -> tuple[float, ...]:
        evaluations[0] += 1
        return respond(*arguments)

    monkeypatch.setattr(friction, "respond", counted)
    monkeypatch.setattr(friction, "_bracketed", lambda *_: bracketed)
    for one in steps(name):
        evaluations[0] = 0
        z, psi, _, converged = solve_friction.py_func(*one[:6], one.z + 0.1, one.psi - 0.1)  # type: ignore[attr-defined]
        assert converged
        assert (z, psi) == pytest.approx((one.z, one.psi), abs=2e-12)
        assert 2 <= evaluations[0] <= 6
        assert solve_friction.py_func(*one[:6], one.z - 4.0, one.psi) == bracketed  # type: ignore[attr-defined]


@pytest.mark.parametrize("z", [math.nan, math.inf])
def test_a_start_that_is_no_number_is_survived(z: float) -> None:
    one = step("ageing", 1.0, 0.05)
    assert solve_friction(*one[:6], z, one.psi)[:2] == pytest.approx((one.z, one.psi), abs=2e-12)


@njit
def extrapolated(memory: np.ndarray, slot: int) -> float:
    """As the kernel compiles it."""
    return kernel._extrapolated(memory, slot)


def test_newtons_start_is_exact_for_a_quartic() -> None:
    memory = np.zeros(16)
    quartic = np.array([0.3, -1.0, 2.0, 0.5, 4.0])
    memory[6:11] = np.polyval(quartic, -np.arange(5.0))
    assert extrapolated(memory, 6) == pytest.approx(np.polyval(quartic, 1.0), rel=1e-12)
