"""Independent witnesses: the method-of-lines families against the delay system; only the interface's solve is common to both."""

import dataclasses

import pytest

import scene
from fullwave.discontinuous import DiscontinuousGalerkin
from fullwave.finite_element import FiniteElement
from fullwave.summation_by_parts import SummationByParts
from reduced.exact import delay_system
from scene.observe import EventObserver, follow
from scene.slab import GripFace, Layer, ReflectingFace

PAPER = scene.read("paper")
SLAB = PAPER.upper
PERIOD, STRESS_DROP = 73.4721449443, 0.1739634131
"""The paper's orbit at log10 r = -2.68 by Newton on the delay system: three meshes and a second program agree on these digits."""


@pytest.mark.parametrize(
    ("kind", "options", "allowed"),
    [
        (DiscontinuousGalerkin, {"degree": 7, "cells": 6}, 1e-9),
        (FiniteElement, {"degree": 7, "cells": 6}, 1e-8),
        (SummationByParts, {"order": 6, "cells": 48}, 1e-6),
    ],
    ids=["dg", "fem", "sbp"],
)
def test_period_and_stress_drop_of_the_papers_orbit(kind, options, allowed):
    solver = kind(PAPER, **options)
    observer = EventObserver(PAPER, solver.nodes)
    follow(solver, 3000.0, [observer])
    events = observer.events
    assert events.period[-1] == pytest.approx(PERIOD, rel=allowed)
    assert events.stress_drop[-1] == pytest.approx(STRESS_DROP, rel=allowed)
    assert events.elastic_stress_drop[-1] == pytest.approx(0.1547375, rel=max(allowed, 1e-6))
    assert events.v_max[-1] == pytest.approx(4412.320, rel=max(allowed, 2e-7))


def changed(upper, lower=None):
    """The paper's scene with other slabs."""
    slabs = [dataclasses.replace(SLAB, **(changes or {})) for changes in (upper, upper if lower is None else lower)]
    return dataclasses.replace(PAPER, upper=slabs[0], lower=slabs[1])


SCENES = {
    "twice as thick": changed({}, {"round_trip": 2 * SLAB.round_trip, "epsilon": 3 * SLAB.epsilon}),
    "incommensurate": changed({}, {"round_trip": 2**0.5 * SLAB.round_trip, "epsilon": 3 * SLAB.epsilon}),
    "grips": changed({"face": GripFace(2.0, 1.5)}),
    "one grip": changed({"face": GripFace(2.0, 1.5)}, {"round_trip": 2**0.5 * SLAB.round_trip}),
    "reflecting": changed({"face": ReflectingFace(0.9)}),
    "one absorbing": changed({"face": ReflectingFace(0.0)}, {}),
    "layers": changed({"layers": (Layer(0.4, 1.0), Layer(0.6, 2.0))}, {}),
}


@pytest.mark.parametrize("name", SCENES)
def test_final_state_agrees_with_the_delay_system(name):
    exact = follow(delay_system(SCENES[name], tolerance=1e-11), 150.0)
    final = follow(DiscontinuousGalerkin(SCENES[name], degree=9, cells=6), 150.0)
    assert final.psi == pytest.approx(exact.psi, abs=1e-9)
    assert final.ln_v == pytest.approx(exact.ln_v, abs=1e-8)
    assert final.mu == pytest.approx(exact.mu, abs=1e-9)
