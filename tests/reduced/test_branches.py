"""Special points of branches of orbits against AUTO-07p, shooting and DDE-BIFTOOL, started
nearby."""

import numpy as np
import pytest

from reduced.continuation.branch import follow_branch
from reduced.continuation.onset import onsets
from reduced.continuation.point import FlowFamily
from reduced.continuation.start import from_orbit, metric_for
from reduced.delay.network import DelayNetwork
from reduced.impedance import reduction_of
from reduced.ode.march import LONGEST, STAGES, ReducedModel
from reduced.ode.slabs import ReducedSlabs
from reduced.orbit.approach import approach
from reduced.orbit.closing import close
from slipwave import read
from slipwave.step.port_flow import flow_near

METRIC = metric_for(-2.72, -2.3)


def scene_at(log10_r):
    return read("paper", {"slab.log10_r": log10_r})


def first_special(family, point, most=60):
    """The first special point after `point`."""
    for _, step in zip(range(most), follow_branch(family, point, METRIC, lambda q: True, 1e-7), strict=False):
        if step.special:
            return step.special[0]
    raise AssertionError(f"none within {most} steps")


def require(special, kind, parameter, period, counts, within=1e-9):
    """`period` to its digits at events that the branch passes; at a fold it is less sharp than the parameter by a square root."""
    assert special.kind == kind
    assert special.point.parameter == pytest.approx(parameter, abs=within)
    assert special.point.closed.cycle.period == pytest.approx(period, abs=2e-5 if kind == "LP" else 1e-6)
    assert (special.unstable_before, special.unstable_after) == counts
    assert special.bracket < 1e-9


def near(log10_r, state, period):
    """The family of kelvin-voigt, and the point of the branch near `state`, towards smaller log10 r."""
    scene = scene_at(log10_r)
    slabs = ReducedSlabs(scene, lambda other: reduction_of(other, "kelvin-voigt"), STAGES)
    flow = flow_near(slabs, np.array(state), period, 1e-8, LONGEST)
    family = FlowFamily(flow, scene_at)
    return family, from_orbit(family, close(flow, np.array(state), period), log10_r, -3.0, METRIC)


def kelvin_voigt(log10_r):
    """A guess from a run."""
    scene = scene_at(log10_r)
    solver = ReducedModel(scene, reduction_of(scene, "kelvin-voigt"), 1e-6)
    return approach(solver, 1e-8)


def test_the_first_period_doubling_of_kelvin_voigt():
    guess = kelvin_voigt(-2.60)
    family = FlowFamily(guess.flow, scene_at)
    point = from_orbit(family, close(*guess[:3]), -2.60, 0.0, METRIC)
    require(first_special(family, point), "PD", -2.595727667, 78.994716174, (0, 1))


def test_the_torus_of_kelvin_voigt():
    """From beyond it, where nothing stable is near: an orbit that was found along the branch. The paper reads 10^-2.468."""
    torus = first_special(*near(-2.466, [-0.0255313, 0.0472059, 0.0722975, -2.1407318], 81.90486))
    require(torus, "NS", -2.469026250, 81.900881030, (2, 0))


def test_the_first_torus_of_the_delay_system():
    guess = approach(DelayNetwork(scene_at(-2.658), tolerance=1e-6), 1e-6)
    flow, state = guess.flow.remeshed(guess.flow.march(guess.state, guess.period), 1.5)
    family = FlowFamily(flow, scene_at)
    point = from_orbit(family, close(flow, state, guess.period), -2.658, 0.0, METRIC)
    torus = first_special(family, point)
    require(torus, "NS", -2.657545713, 78.263260, (0, 2))
    assert torus.multiplier == pytest.approx(-0.111491 + 0.993765j, abs=1e-6)


@pytest.mark.parametrize(
    ("model", "log10_r", "period"), [("delay", -2.6995497159, 49.66818383), ("kelvin-voigt", -2.69954994745, 49.66821032)]
)
def test_onsets_in_any_parameter_are_one(model, log10_r, period):
    """At the critical r the onset in epsilon is at the paper's value, and that in V too, with one period."""
    for key, low, high, known in (("slab.epsilon", 1e-5, 1e-4, 2.8e-5), ("drive.velocity", 50.0, 300.0, 100.0)):
        (onset,) = onsets(lambda p, key=key: read("paper", {"slab.log10_r": log10_r, key: p}), low, high, model)
        assert onset.parameter == pytest.approx(known, rel=1e-7)
        assert onset.period == pytest.approx(period, rel=1e-7)
        assert sorted((onset.unstable_below, onset.unstable_above)) == [0, 2]


def test_no_onset_where_steady_sliding_stays_stable():
    assert onsets(scene_at, -2.8, -2.7, "delay") == []
