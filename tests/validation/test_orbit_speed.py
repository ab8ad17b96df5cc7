"""The script that times orbits and branches: powers of costs, and what it says of a branch."""

from types import SimpleNamespace

import pytest

from reduced.orbit.approach import Guess
from tests.orbit_by_hand import SUPERCRITICAL, FlowByHand
from validation import orbit_speed


@pytest.mark.parametrize(("first", "last", "ratio", "power"), [(2.0, 8.0, 4.0, 1.0), (3.0, 48.0, 4.0, 2.0), (2.0, 2.0, 3.0, 0.0)])
def test_the_power_of_a_cost(first, last, ratio, power):
    assert orbit_speed._power(first, last, ratio) == pytest.approx(power)


def test_costs_are_compared_on_two_meshes_and_over_two_lengths(monkeypatch):
    """With a cost of steps^2 times the period^3."""
    flow = FlowByHand(SUPERCRITICAL, 0.3)
    guess = Guess(flow, SUPERCRITICAL.state(0.3), SUPERCRITICAL.period(0.3), True)
    monkeypatch.setattr(orbit_speed, "_cost", lambda flow, state, period: flow.steps**2 * period**3)
    assert orbit_speed._in_mesh(guess) == pytest.approx(2.0)
    assert orbit_speed._in_period(guess) == pytest.approx(3.0)


def test_a_branch_is_told_by_its_end_and_its_special_points(monkeypatch):
    end = SimpleNamespace(parameter=-2.614, closed=SimpleNamespace(cycle=SimpleNamespace(period=85.0)))
    monkeypatch.setattr(orbit_speed, "branch_of", lambda *_: SimpleNamespace(points=[end], special=[1, 2]))
    monkeypatch.setattr(orbit_speed, "find_orbit", lambda *_: None)
    monkeypatch.setattr(orbit_speed, "_guess", lambda _: (None, None, None))
    monkeypatch.setattr(orbit_speed, "periodic_orbit", lambda *_: None)
    for power in ("_in_mesh", "_in_period"):
        monkeypatch.setattr(orbit_speed, power, lambda _: 1.0)
    monkeypatch.setattr(orbit_speed, "timed", lambda work: (0.025, work()))
    found = {row.what: row for row in orbit_speed.rows()}
    assert len(found) == 9
    last = found["delay branch from the Hopf point to log10 r = -2.614, T = 85.00"]
    assert last[1:] == ("0.0 s, 3 special points",)
    assert found["delay: from the run's last cycle to errors of 1e-10"].measured == "25 ms"
