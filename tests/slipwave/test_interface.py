"""The one interface solve: right at every rate from 1e-30 to 1e15, from any start, and never silent about a failure."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipwave.compiled import njit
from slipwave.friction import LAWS, respond, steady_state, unknown_of
from slipwave.friction.interface import MAX_ITERATIONS, solve_interface

PAPER = (0.369, 0.0349, 0.0489)
LAW_NAMES = ("ageing", "slip", "ageing-regularised", "slip-regularised")


@njit
def solve(law, impedance, incoming, psi, start):
    """As the solvers call it: compiled, so that e^z overflows to infinity."""
    return solve_interface(law, impedance, incoming, psi, start)


def law_called(name):
    return LAWS[name].parameters(*PAPER)


def incoming_for(law, impedance, rate, psi):
    """The rate unknown of `rate` and the incoming stress of which it is the root."""
    z = unknown_of(law, rate)
    v, _, friction, *_ = respond(law, z, psi)
    return z, friction + impedance * v


@pytest.mark.parametrize("name", LAW_NAMES)
@pytest.mark.parametrize("impedance", [0.0, 1e-12, 1.4e-5, 1.0, 1e6])
def test_every_rate_is_found_again(name, impedance):
    law = law_called(name)
    for exponent in np.linspace(-30 if "regularised" not in name else -15, 15, 46):
        rate = 10.0**exponent
        psi = min(60.0, max(-60.0, steady_state(law, rate)))
        wanted, incoming = incoming_for(law, impedance, rate, psi)
        for start, most in (
            (wanted + 0.01, 5),
            (0.0, MAX_ITERATIONS),
            (wanted + 30.0, MAX_ITERATIONS),
            (wanted - 30.0, MAX_ITERATIONS),
        ):
            z, iterations = solve_interface(law, impedance, incoming, psi, start)
            assert 0 < iterations <= most
            # a root is as sharp as the rounding of the incoming stress over the slope of the balance
            v, v_z, _, friction_z, *_ = respond(law, wanted, psi)
            sharpness = 1e-15 * (abs(incoming) + impedance * v + 1.0) / (friction_z + impedance * v_z)
            assert z == pytest.approx(wanted, abs=8 * sharpness + 1e-14 * abs(wanted))


@given(
    st.sampled_from(LAW_NAMES),
    st.floats(-6, 3).map(lambda x: 10**x),
    st.floats(-2.0, 5.0),
    st.floats(-20.0, 20.0),
    st.floats(-60, 60),
)
def test_random_starts_end_at_a_root(name, impedance, incoming, psi, start):
    law = law_called(name)
    z, iterations = solve_interface(law, impedance, incoming, psi, start)
    assert iterations > 0
    v, v_z, friction, friction_z, *_ = respond(law, z, psi)
    residual = friction + impedance * v - incoming
    slack = (friction_z + impedance * v_z) * 1e-14 * (1.0 + abs(z)) + 1e-14 * (abs(friction) + impedance * abs(v) + 1.0)
    assert abs(residual) <= slack


@pytest.mark.parametrize("name", LAW_NAMES)
@pytest.mark.parametrize("impedance", [1.4e-5, 1.0])
@pytest.mark.parametrize("start", [390.0, 900.0, -390.0])
def test_a_start_hundreds_away_is_no_failure(name, impedance, start):
    """Newton gains one in z an iteration where v = e^z rules, and gains nothing where e^z overflows."""
    law = law_called(name)
    wanted, incoming = incoming_for(law, impedance, 100.0, -4.6)
    z, iterations = solve(law, impedance, incoming, -4.6, start)
    assert 0 < iterations < 120
    assert z == pytest.approx(wanted, rel=1e-12)


@pytest.mark.parametrize("name", LAW_NAMES)
@pytest.mark.parametrize("where", range(3))
def test_not_a_number_is_a_counted_failure(name, where):
    values = [0.4, 0.0, 1.0]
    values[where] = math.nan
    incoming, psi, start = values
    assert solve_interface(law_called(name), 1e-5, incoming, psi, start)[1] == 0
