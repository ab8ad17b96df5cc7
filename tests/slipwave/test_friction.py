"""The friction laws: derivatives, steady states, limits; and the one interface solve, from any start at any rate."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipwave.compiled import njit
from slipwave.friction import LAWS, rate_of, respond, steady_state, unknown_of
from slipwave.friction.interface import MAX_ITERATIONS, solve_interface

PAPER = (0.369, 0.0349, 0.0489)
CUT, SATURATED = 40.0, 0.02
OWN = {"cutoff_velocity": CUT, "saturation_velocity": SATURATED}
REGULARISED = ("ageing-regularised", "slip-regularised")
STEP = 1e-6

rates = st.floats(-12.0, 12.0).map(math.exp)
offsets = st.floats(-3.0, 3.0)
names = st.sampled_from(sorted(LAWS))


def law_called(name, **own):
    """With the paper's parameters; `own` are those that only some laws have."""
    made = LAWS[name].parameters
    return made(*PAPER, **{key: value for key, value in (OWN | own).items() if key in made._fields})


def plainness(rate, psi):
    """How far v is above the range where regularisation matters (small: far above)."""
    return 2.0 * math.exp(-(0.369 + 0.0489 * psi) / 0.0349) / rate


@given(names, rates, offsets)
def test_derivatives_are_those_of_finite_differences(name, rate, offset):
    law = law_called(name)
    z, psi = unknown_of(law, rate), steady_state(law, rate) + offset
    v, v_z, _, f_z, f_psi, g, g_z, g_psi = respond(law, z, psi)
    ahead, behind = respond(law, z + STEP, psi), respond(law, z - STEP, psi)
    up, down = respond(law, z, psi + STEP), respond(law, z, psi - STEP)
    scale = v + abs(g) + math.exp(-psi) + 1.0
    for given_one, pair, place, size in (
        (v_z, (ahead, behind), 0, v),
        (f_z, (ahead, behind), 2, 1.0),
        (f_psi, (up, down), 2, 1.0),
        (g_z, (ahead, behind), 5, scale),
        (g_psi, (up, down), 5, scale),
    ):
        measured = (pair[0][place] - pair[1][place]) / (2 * STEP)
        assert given_one == pytest.approx(measured, rel=1e-6, abs=1e-7 * size)


@given(st.sampled_from(sorted(name for name in LAWS if name != "spinodal")), rates)
def test_steady_sliding_is_steady_and_weakens_as_b_exceeds_a(name, rate):
    law = law_called(name, cutoff_velocity=1e300)
    psi = steady_state(law, rate)
    answer = respond(law, unknown_of(law, rate), psi)
    assert psi == pytest.approx(-math.log(rate), abs=1e-14)
    assert answer[0] == pytest.approx(rate, rel=1e-13)
    assert abs(answer[5]) <= 1e-12 * rate
    slack = 0.0349 * plainness(rate, psi) ** 2 if name in REGULARISED else 0.0
    assert answer[2] == pytest.approx(0.369 + (0.0349 - 0.0489) * math.log(rate), abs=slack + 1e-13)


@given(st.sampled_from(REGULARISED), rates, offsets)
def test_a_regularised_law_equals_its_plain_one_at_forward_rates(name, rate, offset):
    regularised, plain = law_called(name), law_called(name.removesuffix("-regularised"))
    psi = steady_state(plain, rate) + offset
    smooth, sharp = (respond(law, unknown_of(law, rate), psi) for law in (regularised, plain))
    ratio = plainness(rate, psi)
    assert abs(smooth[2] - sharp[2]) <= 0.0349 * ratio**2 + 1e-14
    assert smooth[5] == pytest.approx(sharp[5], rel=1e-9, abs=1e-9 * rate)
    assert smooth[4] == pytest.approx(sharp[4], rel=ratio**2 + 1e-12)


@pytest.mark.parametrize("name", REGULARISED)
def test_a_regularised_law_is_odd_in_v_and_finite_at_rest(name):
    law = law_called(name)
    for rate in (0.0, 1e-30, 1e-12, 1.0, 1e6):
        forward, backward = (respond(law, unknown_of(law, v), 0.7) for v in (rate, -rate))
        assert all(map(math.isfinite, forward + backward))
        assert backward[2] == pytest.approx(-forward[2], rel=1e-12, abs=1e-30)
        assert backward[5] == pytest.approx(forward[5], rel=1e-12)
        assert backward[3] > 0.0
    assert respond(law, unknown_of(law, 0.0), 0.7)[2] == 0.0


@pytest.mark.parametrize("name", REGULARISED)
def test_a_regularised_law_keeps_its_digits_near_rest_and_where_the_exponential_would_overflow(name):
    law = law_called(name)
    growth = math.exp((0.369 + 0.0489 * 0.7) / 0.0349)
    for rate in (1e-25, 1e-18, 1e-12):
        assert respond(law, unknown_of(law, rate), 0.7)[2] == pytest.approx(0.0349 * math.asinh(0.5 * rate * growth), rel=1e-13)
    weak = LAWS[name].parameters(0.6, 1e-3, 1e-3)  # (a_* + b psi)/a = 600
    assert respond(weak, unknown_of(weak, 2.0), 0.0)[2] == pytest.approx(0.6 + 1e-3 * math.log(2.0), rel=1e-13)


@given(st.sampled_from(["ageing-cutoff", "slip-cutoff"]), rates, offsets)
def test_a_law_with_a_cutoff_is_its_plain_one_but_for_young_contacts(name, rate, offset):
    """a_* means the same; the state effect is b ln(phi v_c + 1), but for a constant; 1/v_c = 0 is the plain law."""
    law, plain = law_called(name), law_called(name.removesuffix("-cutoff"))
    psi = offset - math.log(rate)
    cut, sharp = (respond(one, math.log(rate), psi) for one in (law, plain))
    assert cut[2] - sharp[2] == pytest.approx(0.0489 * math.log1p(math.exp(-psi) / CUT), rel=1e-9, abs=1e-14)
    assert cut[2] == pytest.approx(
        0.369 - 0.0489 * math.log(CUT) + 0.0349 * math.log(rate) + 0.0489 * math.log(math.exp(psi) * CUT + 1.0), abs=1e-13
    )
    assert (*cut[:2], cut[3], *cut[5:]) == pytest.approx((*sharp[:2], sharp[3], *sharp[5:]), rel=1e-14)
    far = respond(law_called(name, cutoff_velocity=1e300), math.log(rate), psi)
    assert far == pytest.approx(sharp, rel=1e-14)


@given(rates, offsets)
def test_the_spinodal_law_is_the_regularised_ageing_law_between_its_two_rates(rate, offset):
    law = law_called("spinodal", cutoff_velocity=1e200, saturation_velocity=1e-200)
    plain = law_called("ageing-regularised")
    z, psi = unknown_of(plain, rate), offset - math.log(rate)
    assert steady_state(law, rate) == pytest.approx(-math.log(rate), abs=1e-14)
    assert respond(law, z, psi) == pytest.approx(respond(plain, z, psi), rel=1e-13)


def test_steady_friction_of_the_spinodal_law_rises_falls_and_rises():
    low, high = 1e-6, 1e8
    law = law_called("spinodal", cutoff_velocity=high, saturation_velocity=low)

    def steady(v):
        return respond(law, unknown_of(law, v), steady_state(law, v))[2]

    a, b = PAPER[1:]
    for place, sign in ((low * math.sqrt(a / (b - a)), 1.0), (high * (b - a) / a, -1.0)):
        assert sign * steady(place) > max(sign * steady(place * 1.1), sign * steady(place / 1.1))
        near = [steady(place * factor) for factor in (1.0 / 1.001, 1.001)]
        assert abs(near[1] - near[0]) < 1e-3 * a * 0.002
    assert (steady(0.0), steady(-3.0)) == (0.0, pytest.approx(-steady(3.0), rel=1e-12))
    assert 0.0 < steady(1e-12) < steady(1e-7) < steady(low * 1.5)


@pytest.mark.parametrize("name", sorted(LAWS))
def test_compiled_and_plain_answers_are_the_same(name):
    @njit
    def compiled(law, z, psi, v):
        return respond(law, z, psi), steady_state(law, v), rate_of(law, z), unknown_of(law, v)

    law = law_called(name)
    z = unknown_of(law, 3.7)
    answer, steady, rate, unknown = compiled(law, z, 0.3, 3.7)
    assert answer == pytest.approx(respond(law, z, 0.3), rel=1e-14)
    assert (steady, rate, unknown) == pytest.approx((steady_state(law, 3.7), rate_of(law, z), z), rel=1e-14)


LAW_NAMES = ("ageing", "slip", "ageing-regularised", "slip-regularised")


@njit
def solve(law, impedance, incoming, psi, start):
    """As the solvers call it: compiled, so that e^z overflows to infinity."""
    return solve_interface(law, impedance, incoming, psi, start)


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
