"""What a march costs in steps and Newton iterations: no busy machine can change that.

A worse guess, a slower iteration or a step shorter than the tolerance asks for gives the same answers, and is seen nowhere else.
"""

import pytest

import slipwave
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
