"""The exact delay system and the full wave share no code: they must agree on every lossless arrangement."""

import pytest

import slipwave
from slipwave.solve import follow
from validation.registry.build import build

SMOOTH = ("paper-2.6", "unlike", "unlike-irrational", "grip", "reflection", "layered", "slip-law", "regularised")


@pytest.mark.parametrize("name", SMOOTH)
def test_discontinuous_galerkin_agrees_with_the_delay_system(name: str) -> None:
    arrangement = slipwave.read(name, ['start.kind="nudge"', "start.size=0.5"])
    wave = follow(build("dg:7", arrangement, cells=8, time="explicit"), 150.0)
    delay = follow(build("delay", arrangement, tolerance=1e-11), 150.0)
    assert wave.psi == pytest.approx(delay.psi, abs=5e-11)  # measured: 3e-12
    assert wave.mu == pytest.approx(delay.mu, abs=1e-12)  # 5e-14
