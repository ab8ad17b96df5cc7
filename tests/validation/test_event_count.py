"""The number of slip events belongs to the physics: neither model, tolerance nor grid may change it."""

import pytest

import slipwave
from slipwave.observe import EventObserver
from slipwave.solve import follow
from validation.registry.build import build

BRIEF_STICKS = ["drive.velocity=1e4"]
"""V so large that the paper's slabs stick for hardly more than one round trip."""


@pytest.mark.parametrize(
    ("model", "options"),
    [
        ("delay", {}),
        ("delay", {"tolerance": 1e-5}),
        ("delay", {"tolerance": 1e-7}),
        ("delay", {"tolerance": 1e-11}),
        ("dg:7", {"cells": 2}),
        ("dg:7", {"cells": 8}),
        ("fd", {"cells": 64}),
        ("fd", {"cells": 150}),
    ],
)
def test_brief_sticks_are_counted_alike(model, options):
    chosen = slipwave.read("paper", BRIEF_STICKS)
    solver = build(model, chosen, **options)
    watch = EventObserver(chosen, solver.nodes)
    follow(solver, 100.0, [watch])
    assert watch.count == 37


@pytest.mark.parametrize(("name", "count"), [("paper", 8), ("paper-2.3", 5), ("unlike", 11), ("reflection", 9), ("slip-law", 8)])
def test_other_scenes_keep_their_count(name, count):
    chosen = slipwave.read(name)
    counts = []
    settings = [("delay", {}), ("delay", {"tolerance": 1e-6}), ("fd", {"cells": 64})]
    for model, options in settings:
        solver = build(model, chosen, **options)
        watch = EventObserver(chosen, solver.nodes)
        follow(solver, 500.0, [watch])
        counts.append(watch.count)
    assert counts == [count] * 3
