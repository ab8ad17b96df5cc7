"""The tables of the exact march: breaks that steps end on, what is kept of them and what is forgotten, their threads, and the
refusals of step and of grid."""

from types import SimpleNamespace

import numpy as np
import pytest
import threadpoolctl

import slipwave
from fullwave.discontinuous import DiscontinuousGalerkin
from fullwave.finite_element import FiniteElement
from fullwave.lines import budget, grid_slabs, march, propagator, step_maps
from fullwave.lines.exact import ExactMarch
from fullwave.lines.grid_slabs import GridSlabs
from fullwave.summation_by_parts import SummationByParts
from slipwave.errors import NumericsError, SceneError
from slipwave.solve import follow

FAR_RAMP = "drive.velocity=[[0.0, 100.0], [105.3, 100.0], [1211.17, 200.0]]"
PAPER = slipwave.read("paper")


def slabs_of(solver: DiscontinuousGalerkin) -> GridSlabs:
    assert isinstance(solver._march, ExactMarch)
    return solver._march.slabs


@pytest.mark.parametrize("name", ["unlike", "unlike-irrational"])
def test_steps_end_on_breaks_far_apart_and_none_is_tiny(name: str) -> None:
    """The longest step between two breaks is no round number, and a break is a thousand steps away. Measured: at most 1e-13."""
    solver = DiscontinuousGalerkin(slipwave.read(name, [FAR_RAMP]), 5, 2, time="exact")
    ends, shortest = [], np.inf
    while solver.time < 1230.0:
        pieces = solver.advance(1230.0)
        ends.extend(pieces.time + pieces.length)
        shortest = min(shortest, pieces.length.min())
    travels = [0.5 * slab.round_trip / solver.scene.transit for slab in (solver.scene.upper, solver.scene.lower)]
    for arrival in (knot + delay for knot in (105.3, 1211.17) for delay in (0.0, *travels)):
        assert np.abs(np.array(ends) - arrival).min() < 2e-12
    assert shortest > 0.01


def test_lengths_that_differ_by_rounding_share_tables_but_not_lengths() -> None:
    slabs = slabs_of(DiscontinuousGalerkin(PAPER, 3, 2, time="exact"))
    third = 1.0 / 3.0
    one, other, apart = slabs.port(third), slabs.port(np.nextafter(third, 1.0)), slabs.port(third * (1.0 + 1e-11))
    assert one.change is other.change
    assert one.change is not apart.change
    for port, longest in ((one, third), (other, np.nextafter(third, 1.0))):
        assert port.length[0] == longest
        assert port.length[5] == longest / 32.0


@pytest.mark.parametrize(("bytes_", "most"), [(budget.MOST_BYTES, 64), (1.0, 2), (8.0 * 80 * 32**2 * 5.5, 5)])
def test_as_many_lengths_are_known_as_memory_allows(bytes_: float, most: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of 32 unknowns; the length that was used last is forgotten last."""
    monkeypatch.setattr(grid_slabs, "MOST_BYTES", bytes_)
    slabs = slabs_of(DiscontinuousGalerkin(PAPER, 7, 2, time="exact"))
    assert slabs.remembered == 32
    lost, kept = slabs.known(3.0), slabs.known(2.0)
    for k in range(most - 1):
        slabs.known(4.0 + k)
        assert slabs.known(2.0) is kept
    assert len(slabs._known) == most
    assert slabs.known(3.0) is not lost


def test_all_matrices_are_made_on_one_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    used = []

    def watched(function):
        def counted(*arguments):
            pools = threadpoolctl.threadpool_info()
            used.append(max(pool["num_threads"] for pool in pools if pool["user_api"] == "blas"))
            return function(*arguments)

        return counted

    for module, name in ((grid_slabs, "motion_of"), (step_maps, "short_step"), (step_maps, "doubled")):
        monkeypatch.setattr(module, name, watched(getattr(module, name)))
    with threadpoolctl.threadpool_limits(2):
        solver = DiscontinuousGalerkin(PAPER, 3, 2, time="exact")
        solver.keep_frames(1.0 / 32.0)
        solver.advance(3.0)
    assert len(used) > 3
    assert set(used) == {1}


def test_a_motion_too_fast_for_every_step_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(grid_slabs, "LEVELS", 3)
    solver = DiscontinuousGalerkin(slipwave.read("paper", ["start.kind=jump", "start.size=3.0"]), 3, 2, time="exact")
    with pytest.raises(
        NumericsError, match=r"^dg:3: no step is short enough at t = 0 transits, v = .*, psi = [-.\d]+ \(scene 'paper'"
    ):
        follow(solver, 1.0)


@pytest.mark.parametrize(
    ("kind", "options"),
    [
        (DiscontinuousGalerkin, {"number": 7, "cells": 10_000}),
        (FiniteElement, {"number": 4, "cells": 600}),
        (SummationByParts, {"number": 6, "cells": 80_000}),
    ],
)
def test_too_many_unknowns_are_refused_before_any_matrix(kind, options, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(march, "ExactMarch", lambda *arguments: pytest.fail("matrices were begun"))
    with pytest.raises(SceneError, match=rf"cells = {options['cells']}: \d+ unknowns, more than the 2048 .* or --time explicit"):
        kind(PAPER, **options, time="exact")


@pytest.mark.parametrize(("gallery", "about"), [("paper", 121), ("viscous", 60), ("unlike", 45), ("layered", 121)])
def test_the_advised_number_of_cells_fits(gallery: str, about: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(march, "ExactMarch", lambda *arguments: SimpleNamespace(nodes=None))
    scene = slipwave.read(gallery)
    for asked in (10_000, about + about // 10):
        with pytest.raises(SceneError) as refusal:
            DiscontinuousGalerkin(scene, 7, asked, time="exact")
        advised = int(str(refusal.value).partition("at most some ")[2].split()[0])
        assert advised == pytest.approx(about, rel=0.12)
        DiscontinuousGalerkin(scene, 7, advised, time="exact")


def test_maps_are_kept_between_the_runs_of_a_sweep_where_this_is_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """Over V and r one grid has one set of maps; another grid has its own. The motion is the same to the last bit."""
    made = []
    monkeypatch.setattr(step_maps, "short_step", lambda *given: made.append(given) or propagator.short_step(*given))

    def psi(change: str, cells: int = 2) -> float:
        return follow(DiscontinuousGalerkin(slipwave.read("paper", [change]), 5, cells, time="exact"), 20.0).psi

    runs = (("drive.velocity=100.0", 2), ("drive.velocity=150.0", 2), ("slab.log10_r=-2.6", 2), ("drive.velocity=100.0", 3))
    alone = [psi(*run) for run in runs]
    assert len(made) == 4
    made.clear()
    with step_maps.maps_kept():
        assert [psi(*run) for run in runs] == alone
        assert len(made) == 2
    assert psi(*runs[0]) == alone[0]
    assert len(made) == 3


def test_kept_maps_are_those_of_the_same_slabs() -> None:
    """Grids of equal size that differ in a number of their rates only."""

    def psi(middle: float) -> float:
        layers = ", ".join(f"{{fraction={share}, impedance={one}}}" for share, one in ((0.3, 1.0), (0.4, middle), (0.3, 1.0)))
        scene = slipwave.read("paper", [f"slab.layers=[{layers}]"])
        return follow(DiscontinuousGalerkin(scene, 5, 3, time="exact"), 20.0).psi

    alone = [psi(1.5), psi(2.0)]
    assert abs(alone[0] - alone[1]) > 1e-6
    with step_maps.maps_kept():
        assert [psi(1.5), psi(2.0)] == alone


def test_few_maps_are_kept_and_the_last_used_the_longest() -> None:
    slabs = slabs_of(DiscontinuousGalerkin(PAPER, 3, 2, time="exact")).slabs
    lengths = [2.0**-k for k in range(9)]
    with step_maps.maps_kept():
        first, second, *_ = [step_maps.maps_of(slabs, None, length) for length in lengths[:8]]
        assert step_maps.maps_of(slabs, None, lengths[0]) is first
        step_maps.maps_of(slabs, None, lengths[8])
        assert step_maps.maps_of(slabs, None, lengths[0]) is first
        assert step_maps.maps_of(slabs, None, lengths[1]) is not second
