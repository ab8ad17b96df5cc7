"""Orbits, special points and onsets of the delay system and of reductions against AUTO-07p, DDE-BIFTOOL and themselves."""

from contextlib import suppress
from functools import lru_cache

import numpy as np
import pytest

from reduced.continuation.branch import follow_branch
from reduced.continuation.point import FlowFamily
from reduced.continuation.start import from_orbit, metric_for
from reduced.delay.network import DelayNetwork
from reduced.impedance import reduction_of
from reduced.ode.slabs import STAGES, ReducedModel, ReducedSlabs
from reduced.orbit import periodic_orbit
from reduced.orbit.approach import approach, guesses
from reduced.orbit.closing import close
from reduced.orbit.multipliers import floquet
from reduced.orbit.periodic import figures_of, repeats_sooner
from reduced.stability.onsets import _bracket, onsets
from slipwave import read
from slipwave.errors import NumericsError
from slipwave.step.port_flow import flow_near
from tests.differences import largest


def scene_at(log10_r):
    return read("paper", {"slab.log10_r": log10_r})


def run_of(model, log10_r):
    scene = scene_at(log10_r)
    return DelayNetwork(scene, tolerance=1e-6) if model == "delay" else ReducedModel(scene, reduction_of(scene, model), 1e-6)


def guessed(model, log10_r, tolerance=1e-9):
    return approach(run_of(model, log10_r), 1e-6 if model == "delay" else tolerance)


@lru_cache
def found(model, log10_r, tolerance=1e-9):
    return periodic_orbit(*guessed(model, log10_r, tolerance)[:3], tolerance)


def test_a_settled_run_is_near_its_orbit():
    guess = guessed("delay", -2.68)
    assert guess.settled
    assert guess.period == pytest.approx(73.47214494, rel=1e-3)
    cycle = guess.flow.march(guess.state, guess.period)
    assert largest(cycle.end - guess.state) < 0.05
    z = cycle.pieces.z.max(axis=1)
    assert 0.3 < z.argmax() / z.size < 0.7  # it begins and ends between slip events


def returns(model, log10_r, near=None):
    """Orbits from the run's closest returns, those of Newton's failures left out."""
    for guess in guesses(run_of(model, log10_r), 1e-6 if model == "delay" else 1e-9, near=near):
        with suppress(NumericsError):
            yield close(*guess[:3]), guess.cycles


@pytest.mark.slow
def test_an_irregular_run_comes_near_to_unstable_orbits():
    """At log10 r = -2.5 the mean of its cycles leads to none; the run's periods lie between 90 and 99."""
    one, cycles = next(returns("delay", -2.5, near=91.0))
    assert cycles == 1
    assert 88.0 < one.cycle.period < 99.0
    assert one.residual < 1e-11
    assert np.abs(floquet(one.monodromy)[0][0]) > 2.0


def test_an_orbit_of_two_cycles_is_found_beside_the_simple_one():
    """The ODE's run at log10 r = -2.59 settles on the doubled orbit, whose period is nearly twice that of the simple one."""
    closed = found("kelvin-voigt", -2.59).closed
    assert floquet(closed.monodromy)[0][0] < -1.2
    twice = close(closed.flow, closed.cycle.start, 2.0 * closed.cycle.period)
    assert repeats_sooner(twice.cycle, closed.flow.nodes, 2)
    for one, cycles in returns("kelvin-voigt", -2.59, near=158.0):
        if not repeats_sooner(one.cycle, one.flow.nodes, cycles):
            break
    assert cycles == 2
    assert one.cycle.period == pytest.approx(2.0 * closed.cycle.period, rel=1e-3)
    assert np.abs(floquet(one.monodromy)[0]).max() < 1.0


def test_no_orbit_near_a_run():
    with pytest.raises(NumericsError, match=r"delay: .*(returns to steady sliding|no orbit near it).*'paper'"):
        guessed("delay", -2.72)
    with pytest.raises(NumericsError, match=r"a run of 300 transits made \d+ cycles in its second half: no orbit near it"):
        approach(run_of("delay", -2.68), 1e-6, most=300.0)


@pytest.mark.parametrize("log10_r", [-2.69, -2.68])
def test_the_estimated_errors_bound_the_errors(log10_r):
    """Against a mesh of half the steps. Measured: 0.03 to 0.8 of the estimates."""
    result = found("delay", log10_r, 1e-8)
    closed = result.closed
    finer, state = closed.flow.remeshed(closed.cycle, 2.0)
    exact = figures_of(close(finer, state, closed.cycle.period))
    for name, value in exact.items():
        estimate = getattr(result.orbit, name)
        assert abs(estimate.value - value) <= estimate.error < 1e-8 * abs(value), name


def test_no_multiplier_of_the_waves_is_told():
    """Their ring about the essential radius is never the same on two meshes; what is told is on a third one too."""
    told = found("delay", -2.68).multipliers
    assert told.essential_radius == pytest.approx(0.0044, abs=1e-4)
    finest = np.linalg.eigvals(found("delay", -2.68, 1e-11).closed.monodromy)
    for value in told.values:
        assert np.abs(finest - value).min() < 2e-3 * abs(value)


def test_a_run_that_creeps_past_a_lost_orbit_is_followed_on():
    """At log10 r = -2.675 cycles of 74.68 transits hardly change for a while, and no orbit is near. It has 74.93245
    (by continuation from -2.68); the first guess leads nowhere. On the mesh of a run to 1e-6: 2e-7 was measured."""
    one, _ = next(returns("delay", -2.675))
    assert one.cycle.period == pytest.approx(74.93244964, abs=2e-6)


def test_the_torus_of_kelvin_voigt():
    """From beyond it, where nothing stable is near: an orbit that was found along the branch. The paper reads 10^-2.468."""
    state, period = np.array([-0.0255313, 0.0472059, 0.0722975, -2.1407318]), 81.90486
    slabs = ReducedSlabs(scene_at(-2.466), lambda other: reduction_of(other, "kelvin-voigt"), STAGES)
    flow, metric = flow_near(slabs, state, period, 1e-8, 2.0), metric_for(-2.72, -2.3)
    family = FlowFamily(flow, scene_at)
    point = from_orbit(family, close(flow, state, period), -2.466, -3.0, metric)
    steps = follow_branch(family, point, metric, lambda q: True, 1e-7)
    torus = next(special for _, step in zip(range(60), steps, strict=False) for special in step.special)
    assert (torus.kind, torus.unstable_before, torus.unstable_after) == ("NS", 2, 0)
    assert torus.point.parameter == pytest.approx(-2.469026250, abs=1e-9)
    assert torus.point.closed.cycle.period == pytest.approx(81.900881030, abs=1e-6)
    assert torus.bracket < 1e-9


@pytest.mark.parametrize(
    ("model", "log10_r", "period"), [("delay", -2.6995497159, 49.66818383), ("kelvin-voigt", -2.69954994745, 49.66821032)]
)
def test_onsets_in_any_parameter_are_one(model, log10_r, period):
    """At the critical r the onset in epsilon is at the paper's value, and that in V too, with one period."""
    for key, low, high, known in (("slab.epsilon", 1e-5, 1e-4, 2.8e-5), ("drive.velocity", 50.0, 300.0, 100.0)):
        (onset,) = onsets(lambda p, key=key: read("paper", {"slab.log10_r": log10_r, key: p}), low, high, model)
        assert (onset.parameter, onset.period) == (pytest.approx(known, rel=1e-7), pytest.approx(period, rel=1e-7))
        assert sorted((onset.unstable_below, onset.unstable_above)) == [0, 2]
    assert onsets(scene_at, -2.8, -2.7, "delay") == []


@pytest.mark.parametrize("ends", [(0.0, 1.0), (-1.0, 0.0)])
def test_an_onset_on_a_sample_of_its_search_is_bracketed_beyond_rounding(ends):
    """An end lies on the Hopf point: the sign of the crossing root's real part there is that of rounding."""
    for rounding in (1e-16, -1e-16):
        low, high = _bracket(lambda x, rounding=rounding: x or rounding, *ends)
        assert low < -1e-9 < 1e-9 < high
