"""Special points of branches of orbits and onsets in any parameter against AUTO-07p and DDE-BIFTOOL, started nearby."""

import numpy as np
import pytest

from reduced.continuation.branch import follow_branch
from reduced.continuation.point import FlowFamily
from reduced.continuation.start import from_orbit, metric_for, onsets
from reduced.impedance import reduction_of
from reduced.ode.slabs import LONGEST, STAGES, ReducedSlabs
from reduced.orbit.closing import close
from slipwave import read
from slipwave.step.port_flow import flow_near


def scene_at(log10_r):
    return read("paper", {"slab.log10_r": log10_r})


def test_the_torus_of_kelvin_voigt():
    """From beyond it, where nothing stable is near: an orbit that was found along the branch. The paper reads 10^-2.468."""
    state, period = np.array([-0.0255313, 0.0472059, 0.0722975, -2.1407318]), 81.90486
    slabs = ReducedSlabs(scene_at(-2.466), lambda other: reduction_of(other, "kelvin-voigt"), STAGES)
    flow, metric = flow_near(slabs, state, period, 1e-8, LONGEST), metric_for(-2.72, -2.3)
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
