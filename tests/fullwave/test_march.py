"""Full waves as users meet them: agreement, equivalent forms, limits, refusals, the ledger.

Step limits: tests/verification/test_noise.
"""

import dataclasses
import math

import numpy as np
import pytest
from grid_scenes import FAMILIES, PAIRS, PAPER, SCENES, of

from fullwave.discontinuous import DiscontinuousGalerkin
from fullwave.finite_difference import Leapfrog
from fullwave.finite_element import FiniteElement
from fullwave.lines.matrix import motion_matrix
from fullwave.options import AnyShare
from fullwave.summation_by_parts import SummationByParts
from slipwave.errors import NumericsError, SceneError
from slipwave.scene.slab import Slab
from slipwave.solve import follow

FINE = {
    "dg": (DiscontinuousGalerkin, {"number": 7, "cells": 6}),
    "fem": (FiniteElement, {"number": 7, "cells": 6}),
    "sbp": (SummationByParts, {"number": 6, "cells": 96}),
}
SMOOTH = [name for name in SCENES if name not in ("everything", "stiff-grip")]


@pytest.mark.parametrize("name", SMOOTH)
def test_families_agree_on_every_scene(name):
    finals = {family: follow(kind(SCENES[name], **options), 20.0) for family, (kind, options) in FINE.items()}
    for family in ("fem", "sbp"):
        assert finals[family].psi == pytest.approx(finals["dg"].psi, abs=1e-12)  # measured: 5e-14
        assert finals[family].mu == pytest.approx(finals["dg"].mu, abs=3e-12)  # 1.4e-13


@pytest.mark.parametrize(
    ("kind", "options", "message"),
    [
        *((Leapfrog, {"cells": one}, "cells = .*whole number from 2") for one in (0, 1, -3, 2.5, 10**7, True, "64", math.nan)),
        *((Leapfrog, {"cfl": wrong}, r"cfl = .*\(0, 1\]") for wrong in (0.0, -1.0, 1.0001, math.nan, math.inf, True, "1")),
        (DiscontinuousGalerkin, {"number": 0}, "degree = 0: must be a whole number from 1 to 24"),
        (DiscontinuousGalerkin, {"cfl": AnyShare(-1.5)}, r"cfl = -1.5: must lie in \(0, 1\]"),
        (DiscontinuousGalerkin, {"time": "implicit"}, "time = 'implicit': must be exact or explicit"),
        (SummationByParts, {"number": 3}, "order = 3: must be one of 2, 4, 6"),
        (SummationByParts, {"number": 6, "cells": 9}, "cells = 9: must be a whole number from 16"),
    ],
)
def test_wrong_options_are_refused_by_name(kind, options, message):
    with pytest.raises(SceneError, match=message):
        kind(PAPER, **options)


def test_state_too_fast_for_the_step_is_reported_in_one_line():
    """r V so large that explicit steps of psi would run away: never in silence."""
    fast = dataclasses.replace(PAPER, upper=Slab(2.8e-5, 10.0), lower=Slab(2.8e-5, 10.0))
    solver = DiscontinuousGalerkin(fast, number=3, cells=2, cfl=AnyShare(15.0))
    with pytest.raises(NumericsError, match=r"dg:3: before t = .* state relaxes at .* per transit, too fast for steps of"):
        follow(solver, 50.0)


@pytest.mark.parametrize("name", ["alike", "grip", "machine", "absorbing", "layers", "kelvin-voigt", "standard-linear"])
def test_ledger_closes(name):
    for family, (kind, options) in FINE.items():
        solver = kind(SCENES[name], **options, time="explicit")
        follow(solver, 12.0)
        energy = solver.energy()
        assert abs(energy.residual) < 2e-13, family  # measured: 1e-14
        assert energy.friction > 0.0
        assert (energy.viscous > 0.0) == (name in ("kelvin-voigt", "standard-linear"))
        assert (energy.radiated > 0.0) == (name in ("grip", "machine", "absorbing", "layers"))


@pytest.mark.parametrize(("family", "name"), PAIRS)
def test_no_scene_lets_the_frictionless_motion_grow(family, name):
    """Spectrum of the plain matrix: nothing to the right of the imaginary axis, locked or free."""
    system = FAMILIES[family](SCENES[name]).system
    for locked in (True, False):
        spectrum = np.linalg.eigvals(motion_matrix(system, locked))
        assert spectrum.real.max() < 1e-9 * np.abs(spectrum).max()


def test_a_layer_thinner_than_a_cell_is_refused():
    scene = SCENES["layers"]
    with pytest.raises(SceneError, match="layer 1 is thinner than a cell; use at least 4"):
        Leapfrog(scene, cells=3)
    Leapfrog(scene, cells=4)


def test_numbers_without_bound_end_the_run_with_the_time():
    solver = Leapfrog(PAPER, 16)
    follow(solver, 5.0)
    state = solver.state()
    state["upper.stress"][3] = 1e308
    solver.restore(state)
    with pytest.raises(NumericsError, match=r"stopped being finite between t = 5"):
        follow(solver, 10.0)


def test_too_coarse_a_step_ends_the_run():
    """A round trip of many state relaxations: eight cells cannot follow psi through an event, 512 can."""
    scene = of({"epsilon": 1e-3, "round_trip": 1.0})
    with pytest.raises(NumericsError, match=r"did not converge by t = .*, the first at t = "):
        follow(Leapfrog(scene, 8), 100.0)
    solver = Leapfrog(scene, 512)
    follow(solver, 100.0)
    assert solver.failures == 0


@pytest.mark.parametrize("name", SCENES)
def test_ledger_closes_to_rounding(name):
    solver = Leapfrog(SCENES[name], 24, 0.9)
    follow(solver, 120.0)
    ledger = solver.energy()
    assert abs(ledger.residual) < 1e-12
    assert ledger.input > 0
    assert ledger.friction > 0
    assert (ledger.radiated > 0) == (
        name in ("grip", "stiff-grip", "machine", "hung-machine", "absorbing", "layers", "everything")
    )
    assert (ledger.viscous > 0) == (name in ("kelvin-voigt", "standard-linear", "hung-machine", "everything"))
    assert solver.failures == 0
