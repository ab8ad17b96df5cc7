"""What a search for roots and crossings costs in evaluations of the impedance, which no busy machine can change.

A worse first guess, a contour cut finer than needed or a scan of other points finds the same roots, and is seen nowhere else.
"""

from collections.abc import Callable

import numpy as np
import pytest

import slipwave
from reduced.impedance import Jet
from reduced.stability import (
    boundary,
    characteristic,
    critical_epsilon,
    critical_round_trip,
    leading_roots,
    unstable_count,
)
from slipwave.scene import Scene

ROUNDING = 0.01
"""Rounding may decide whether one evaluation more is needed."""

SEARCHES: dict[str, Callable[[Scene, str], object]] = {
    "critical r": critical_round_trip,
    "critical epsilon": critical_epsilon,
    "leading roots": lambda scene, model: leading_roots(characteristic(scene, model)),
    "unstable roots": lambda scene, model: unstable_count(characteristic(scene, model)),
    "boundary": lambda scene, model: boundary(scene, model, ("log10_r", "log10_epsilon"), ((-2.72, -2.68), (-4.56, -4.52))),
}


@pytest.mark.parametrize(
    ("search", "scene", "model", "evaluations"),
    [
        ("critical r", "paper", "delay", 9143),
        ("critical r", "grip", "delay", 8027),
        ("critical r", "viscous", "delay", 26097),
        ("critical epsilon", "paper", "delay", 1063),
        ("critical epsilon", "grip", "delay", 3324),
        ("leading roots", "paper", "delay", 18005),
        ("leading roots", "unlike-irrational", "delay", 18132),
        ("leading roots", "layered", "delay", 18003),
        ("leading roots", "viscous", "delay", 18021),
        ("leading roots", "machine", "delay", 18144),
        ("leading roots", "rock", "delay", 18016),
        ("leading roots", "paper slab.r=1.6", "delay", 19498),
        ("leading roots", "paper slab.r=3", "delay", 21119),
        ("leading roots", "paper", "modal:2", 18327),
        ("unstable roots", "reflection", "delay", 308),
        ("boundary", "paper", "kelvin-voigt", 211894),
    ],
)
def test_evaluations_are_as_many_as_measured(
    search: str, scene: str, model: str, evaluations: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    variable, points = Jet.variable, [0]

    def counted(s: object) -> Jet:
        points[0] += np.size(s)
        return variable(s)

    monkeypatch.setattr(Jet, "variable", staticmethod(counted))
    name, *settings = scene.split()
    SEARCHES[search](slipwave.read(name, settings), model)
    assert points[0] == pytest.approx(evaluations, rel=ROUNDING)
