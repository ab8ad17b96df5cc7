import dataclasses

import numpy as np
import pytest

import slipwave
from reduced.impedance.reduce import reduction_of
from reduced.impedance.reduction import TABULATED, reduction
from reduced.ode import slabs
from reduced.ode.slabs import ReducedModel, impedance_at
from slipwave.errors import NumericsError, SceneError
from slipwave.scene.drive import Drive
from slipwave.solve import follow
from slipwave.step.port import LEVELS


def test_only_the_quasistatic_pair_runs_away_and_it_says_so():
    assert [name for name in TABULATED if reduction(name).runs_away] == ["quasistatic"]
    with pytest.raises(NumericsError, match=r"quasistatic: no step is short enough at t = .*runs away"):
        follow(ReducedModel(slipwave.read("paper", ["slab.log10_r=-2.5"]), reduction("quasistatic")), 6000)


@pytest.mark.parametrize("name", ["modal:-1", "modal:65", "modal:", "modal:x", "modal:1.5", "block9", "taylor", "", "modal:²"])
def test_a_wrong_name_is_the_users_error(name):
    with pytest.raises(SceneError, match="model = "):
        reduction(name)


def test_a_drive_of_many_knots_is_marched_at_once_to_the_same_motion(monkeypatch):
    """120 stretches between knots: one batch of steps, and the impedances of all step lengths of a stretch in one call."""
    knots = np.linspace(0.0, 1.5, 121) ** 1.1
    velocities = 100.0 + 50.0 * np.cos(np.arange(121) ** 2)
    scene = dataclasses.replace(slipwave.read("paper"), drive=Drive(tuple(knots.tolist()), tuple(velocities.tolist())))
    calls = []
    monkeypatch.setattr(slabs, "impedance_at", lambda reduction, s: calls.append(s.size) or impedance_at(reduction, s))
    whole, parted = (ReducedModel(scene, reduction_of(scene, "quasidynamic"), 1e-9) for _ in range(2))
    calls.clear()
    pieces = whole.advance(float(knots[-1]))
    assert calls == [LEVELS] * 119  # the first stretch had its own before
    parts = [parted.advance(float(knot)) for knot in knots[1:]]
    for ours, theirs in zip(pieces, map(np.concatenate, zip(*parts, strict=True)), strict=True):
        assert np.array_equal(ours, theirs)
    assert np.abs((pieces.time + pieces.length)[:, None] - knots[1:]).min(axis=0).max() < 1e-12
