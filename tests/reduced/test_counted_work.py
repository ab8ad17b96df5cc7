"""What a march costs in steps and Newton iterations, and a search for roots in evaluations: no busy machine can change that.

A worse guess, a slower iteration, a step shorter than the tolerance asks for or a contour cut finer than needed gives the same
answers, and is seen nowhere else.
"""

import numpy as np
import pytest

import slipwave
from reduced.impedance import Jet
from reduced.stability import characteristic, critical_epsilon, critical_round_trip, leading_roots, unstable_count
from slipwave.solve import follow
from validation.compute.build import build


class Steps:
    """Counts the pieces of a march."""

    count = 0

    def scan(self, pieces):
        self.count += pieces.time.size


@pytest.mark.parametrize(
    ("scene", "model", "tolerance", "until", "steps", "iterations"),
    [
        ("paper", "delay", 1e-9, 1000.0, 7334, 11283),
        ("unlike", "delay", 1e-9, 1000.0, 4297, 7485),
        ("unlike-irrational", "delay", 1e-10, 400.0, 1328, 2592),
        ("paper", "kelvin-voigt", 1e-9, 1000.0, 4870, 7033),
        ("ramp", "kelvin-voigt", 1e-7, 1200.0, 3934, 5601),
    ],
)
def test_steps_and_iterations_are_as_many_as_measured(scene, model, tolerance, until, steps, iterations):
    solver = build(model, slipwave.read(scene), tolerance=tolerance)
    taken = Steps()
    follow(solver, until, [taken])
    assert (taken.count, solver.iterations) == pytest.approx((steps, iterations), rel=2e-3)  # rounding may decide on one more


SEARCHES = {
    "critical r": critical_round_trip,
    "critical epsilon": critical_epsilon,
    "leading roots": lambda scene, model: leading_roots(characteristic(scene, model)),
    "unstable roots": lambda scene, model: unstable_count(characteristic(scene, model)),
}


@pytest.mark.parametrize(
    ("search", "scene", "model", "evaluations"),
    [
        ("critical r", "paper", "delay", 9143),
        ("critical r", "viscous", "delay", 26097),
        ("critical epsilon", "paper", "delay", 1063),
        ("leading roots", "paper", "delay", 18005),
        ("leading roots", "viscous", "delay", 18021),
        ("leading roots", "paper", "modal:2", 18327),
        ("unstable roots", "reflection", "delay", 308),
    ],
)
def test_evaluations_are_as_many_as_measured(search, scene, model, evaluations, monkeypatch):
    variable, points = Jet.variable, [0]

    def counted(s):
        points[0] += np.size(s)
        return variable(s)

    monkeypatch.setattr(Jet, "variable", staticmethod(counted))
    name, *settings = scene.split()
    SEARCHES[search](slipwave.read(name, settings), model)
    assert points[0] == pytest.approx(evaluations, rel=0.01)
