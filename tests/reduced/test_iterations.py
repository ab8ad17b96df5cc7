"""What a march costs in steps and Newton iterations, which no busy machine can change.

A worse guess, a slower iteration or a step shorter than the tolerance asks for gives the same motion, and is seen nowhere else.
"""

from dataclasses import dataclass

import pytest

import slipwave
from slipwave.observe.pieces import Pieces
from slipwave.solve import follow
from validation.registry.build import build

ROUNDING = 2e-3
"""Rounding may decide whether one iteration more is needed."""


@dataclass
class Steps:
    """Counts the pieces of a march."""

    count: int = 0

    def scan(self, pieces: Pieces) -> None:
        self.count += pieces.time.size


@pytest.mark.parametrize(
    ("scene", "model", "tolerance", "until", "steps", "iterations"),
    [
        ("paper", "delay", 1e-6, 1000.0, 5771, 9515),
        ("paper", "delay", 1e-9, 1000.0, 7334, 11283),
        ("paper", "delay", 1e-12, 1000.0, 13053, 14673),
        ("paper-2.3", "delay", 1e-9, 200.0, 6908, 7916),
        ("jump", "delay", 1e-9, 400.0, 3996, 5888),
        ("rock", "delay", 1e-7, 400.0, 1200, 1212),
        ("unlike", "delay", 1e-9, 1000.0, 4297, 7485),
        ("unlike-irrational", "delay", 1e-10, 400.0, 1328, 2592),
        ("layered", "delay", 1e-9, 400.0, 2077, 3812),
        ("ramp", "delay", 1e-9, 1200.0, 9990, 14589),
        ("paper", "kelvin-voigt", 1e-9, 1000.0, 4870, 7033),
        ("paper", "block8", 1e-6, 1000.0, 650, 1065),
        ("paper", "modal:4", 1e-9, 1000.0, 6301, 10637),
        ("paper", "quasidynamic", 1e-9, 400.0, 220, 292),
        ("jump", "modal:2", 1e-9, 400.0, 4597, 5283),
        ("paper-2.6", "kelvin-voigt", 1e-11, 1000.0, 12209, 14130),
        ("ramp", "kelvin-voigt", 1e-7, 1200.0, 3934, 5601),
    ],
)
def test_steps_and_iterations_are_as_many_as_measured(
    scene: str, model: str, tolerance: float, until: float, steps: int, iterations: int
) -> None:
    solver = build(model, slipwave.read(scene), tolerance=tolerance)
    taken = Steps()
    follow(solver, until, [taken])
    assert (taken.count, solver.iterations) == pytest.approx((steps, iterations), rel=ROUNDING)
