"""The stages that a drive has."""

import numpy as np
import pytest

from slipwave.observe.pieces import lagrange_basis
from slipwave.observe.protocol import _integrals
from slipwave.observe.stages import stages_of
from slipwave.scene.drive import Drive, steady_drive

KNOTS = [(0, 1), (5, 1), (5, 10), (8, 10), (8, 0), (12, 0), (12, 1), (15, 1), (20, 3), (25, 3)]


def test_every_kind_of_stage() -> None:
    drive = Drive(*zip(*KNOTS, strict=True))  # type: ignore[arg-type]
    found = [(stage.kind, stage.start, stage.end, stage.before, stage.velocity) for stage in stages_of(drive, 40.0)]
    assert found == [
        ("start", 0.0, 5, 1, 1),
        ("step", 5, 8, 1, 10),
        ("hold", 8, 12, 10, 0),
        ("slide", 12, 15, 0, 1),
        ("ramp", 15, 20, 1, 3),
        ("level", 20, 40.0, 3, 3),
    ]
    assert [stage.sign for stage in stages_of(drive, 40.0)] == [1.0, 1.0, -1.0, 1.0, 1.0, 1.0]


def test_the_run_ends_the_last_stage() -> None:
    drive = Drive((5.0, 5.0), (1.0, 2.0))
    assert [(stage.kind, stage.end) for stage in stages_of(drive, 3.0)] == [("start", 3.0)]
    assert [(stage.kind, stage.end) for stage in stages_of(drive, 6.0)] == [("start", 5.0), ("step", 6.0)]
    assert stages_of(steady_drive(7.0), 6.0) == []


def test_polynomials_are_integrated_exactly() -> None:
    nodes, points = np.array([0.1, 0.5, 1.0]), np.array([0.0, 0.3, 1.0])
    rows = _integrals(lagrange_basis(nodes), points)
    assert rows @ nodes**2 == pytest.approx(points**3 / 3.0, abs=1e-15)
