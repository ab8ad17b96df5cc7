"""Full waves as users meet them: agreement, equivalent forms, the ledger, limits, refusals, memory, grids by a tolerance."""

import dataclasses
import math
import resource

import numpy as np
import pytest
from grid_scenes import FAMILIES, PAIRS, PAPER, SCENES

import fullwave.lines.explicit
import fullwave.lines.march
import slipwave
from fullwave.adapt import resolution_for, to_tolerance
from fullwave.discontinuous import DiscontinuousGalerkin
from fullwave.families import GALERKIN
from fullwave.finite_difference import Leapfrog
from fullwave.finite_element import FiniteElement
from fullwave.lines.matrix import motion_matrix
from fullwave.options import AnyShare
from fullwave.summation_by_parts import SummationByParts
from slipwave.errors import NumericsError, SceneError
from slipwave.observe import EventObserver
from slipwave.scene.drive import Start, StartKind
from slipwave.scene.slab import Slab
from slipwave.solve import follow
from tests.compiled_work import count_calls
from validation.models.build import build, judged_grid

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


@pytest.mark.parametrize("steps_taken", [{"cfl": 0.5}, {"cfl": 0.4}, {"cfl": 0.31}, {"time": "exact"}])
def test_a_step_of_v_radiates_what_a_mass_behind_a_stiff_dashpot_takes_up(steps_taken):
    """m (dV/2)^2/2 on each side; before, 1.4 to 1900 times as much, by where in an explicit step V jumped, and a quarter by exact
    steps, far longer than the mass takes to follow."""
    face = {"kind": "machine", "stiffness": 1.0, "impedance": 1e3, "mass": 0.05}
    steps = {"start.size": 0.0, "drive.velocity": [[0, 100], [0.1, 100], [0.1, 150]]}
    scene = slipwave.read("paper", {"slab.face": face, **steps})
    solver = DiscontinuousGalerkin(scene, number=3, cells=2, **steps_taken)
    solver.keep_ledger()
    follow(solver, 0.2)
    assert solver.energy().radiated == pytest.approx(scene.upper.termination.mass * 25.0**2, rel=0.02)


@pytest.mark.parametrize("cells", [100, 400])
def test_fd_dates_an_event_behind_a_jump_of_v_in_which_v_stays_above_half_its_maximum(cells):
    """At the largest elastic stress; before, at the next front, 6.0 less a cell, because the stress of every other step swung
    around that of the motion."""
    changes = ["drive.velocity=[[0,100],[4.5,100],[4.5,300]]", "slab.log10_r=-2.44", "slab.epsilon=3e-4"]
    scene = slipwave.read("paper", changes)
    dates = []
    for solver in (Leapfrog(scene, cells=cells), build("delay", scene, tolerance=1e-10)):
        observer = EventObserver(scene, solver.nodes)
        follow(solver, 7.0, [observer])
        dates.append(observer.dates())
    assert dates[0] == pytest.approx(dates[1], abs=0.15 / cells)


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


@pytest.mark.parametrize(("kind", "options"), [(Leapfrog, {"cells": 16}), (DiscontinuousGalerkin, {"number": 3, "cells": 4})])
def test_a_slip_rate_that_no_number_holds_ends_the_run_unless_the_law_allows_rest(kind, options):
    """Stress of -45 arrives: ln v = -1300 by the plain law."""
    step = [[0.0, 100.0], [2.0, 100.0], [2.0, 10.0]]
    heavy = slipwave.read("paper", {"slab.epsilon": 1.0, "start.size": 0.0, "drive.velocity": step})
    with pytest.raises(NumericsError, match=r"stopped being finite .*reverses slip, but law 'ageing' needs v > 0: ageing-reg"):
        follow(kind(heavy, **options), 4.0)
    allowed = follow(kind(slipwave.read(heavy, {"interface.law": "ageing-regularised"}), **options), 2.9)
    assert allowed.v == pytest.approx(-80.0, abs=2.0)


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


@pytest.mark.parametrize(
    ("kind", "options", "products"),
    [
        (DiscontinuousGalerkin, {"number": 24, "cells": 20_000}, 12 * (25 + 6)),
        (SummationByParts, {"number": 6, "cells": 200_000}, 12 * (7 + 6)),
        (FiniteElement, {"number": 4, "cells": 20_000}, 12 * (5 + 6)),
        (Leapfrog, {"cells": 1_000_000}, 10),
    ],
)
def test_a_big_grid_leaves_compiled_code_soon(kind, options, products, monkeypatch):
    """`products` a value and step, of 12 stages each; 4e8 of them take less than a second."""
    calls = count_calls(monkeypatch)
    solver = kind(PAPER, **options)
    solver.advance(1e6)
    assert sum(call.steps for call in calls) >= 4
    assert max(call.steps * call.values * products for call in calls) < 4.3e8


@pytest.mark.parametrize(("kind", "options"), [(DiscontinuousGalerkin, {"number": 24}), (FiniteElement, {"number": 16})])
def test_a_grid_beyond_the_memory_is_refused_at_once(kind, options, monkeypatch):
    """Before more of it is built than the few cells by which it is judged."""
    built = []
    grid_of = kind.grid_of

    def counted(solver, some):
        built.append(sum(section.cells for section in some))
        return grid_of(solver, some)

    monkeypatch.setattr(kind, "grid_of", counted)
    monkeypatch.setattr(fullwave.lines.march, "assemble", lambda *arguments: pytest.fail("was assembled"))
    used = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(SceneError, match=r"cells = 1000000: would take .* GB of memory, .* at most some \d+ fit"):
        kind(PAPER, cells=1_000_000, **options)
    assert 0 < max(built) <= 32
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - used < 100_000


def test_the_other_slab_counts_too():
    """Cells are those of the faster slab; a slower one takes many more."""
    slow = dataclasses.replace(PAPER.upper, round_trip=3000.0 * PAPER.upper.round_trip)
    unlike = dataclasses.replace(PAPER, lower=slow)
    for kind in (SummationByParts, DiscontinuousGalerkin):
        with pytest.raises(SceneError, match=r"cells = 10000: would take .* GB"):
            kind(unlike, cells=10_000)


def test_memory_that_is_not_there_is_one_line(monkeypatch):
    def full(*arguments):
        raise MemoryError

    monkeypatch.setattr(fullwave.lines.march, "assemble", full)
    with pytest.raises(SceneError, match="cells = 9: not enough memory on this machine"):
        DiscontinuousGalerkin(PAPER, cells=9)
    monkeypatch.setattr(fullwave.finite_difference, "steady_side", full)
    with pytest.raises(SceneError, match="cells = 9: not enough memory on this machine"):
        Leapfrog(PAPER, cells=9)


@pytest.mark.parametrize(
    ("kind", "options"),
    [
        (DiscontinuousGalerkin, {"number": 7, "cells": 5000}),
        (FiniteElement, {"number": 8, "cells": 3000}),
        (SummationByParts, {"number": 6, "cells": 100_000}),
    ],
)
def test_the_count_is_about_what_is_taken(kind, options, monkeypatch):
    """tracemalloc would not see what scipy's C++ takes for itself; what it sees must be covered."""
    import tracemalloc

    counted = []
    kind(PAPER)
    monkeypatch.setattr("fullwave.lines.budget.require_bytes", lambda cells, needed: counted.append(needed))
    tracemalloc.start()
    kind(PAPER, **options)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert 0.6 * peak < counted[0] < 2.0 * peak


def cycles(solver, until=400.0):
    observer = EventObserver(solver.scene, solver.nodes)
    follow(solver, until, [observer])
    return np.concatenate((observer.events().period, observer.events().stress_drop))


def to_a_tolerance(scene, tolerance, **options):
    """As `--model dg --tol`."""
    made = {"number": GALERKIN.suited(tolerance), "resolution": resolution_for(tolerance)} | options
    return to_tolerance(scene, tolerance, DiscontinuousGalerkin, made["number"] + 1, **made)


@pytest.mark.parametrize("name", ["alike", "unlike", "grip"])
@pytest.mark.parametrize("tolerance", [1e-4, 1e-8])
def test_estimate_bounds_the_error_in_period_and_drop(name, tolerance):
    chosen = SCENES[name]
    solver, choice = to_a_tolerance(chosen, tolerance)
    assert solver.time == 0.0
    assert choice.quantity == "cycles"
    assert choice.error_estimate <= tolerance
    exact = cycles(DiscontinuousGalerkin(chosen, number=11, cells=8))
    error = np.abs(cycles(solver) / exact - 1).max()
    assert error < max(2.0 * choice.error_estimate, 1e-11)


@pytest.mark.parametrize("name", ["alike", "unlike", "grip"])
def test_the_estimate_bounds_the_error_of_a_grid_marched_explicitly(name):
    """Nothing is added for its steps: the estimate is the difference of two grids."""
    solver, choice = to_a_tolerance(SCENES[name], 1e-5, time="explicit", number=4)
    exact = cycles(DiscontinuousGalerkin(SCENES[name], number=11, cells=8))
    error = np.abs(cycles(solver) / exact - 1).max()
    assert 0.01 * choice.error_estimate < error < choice.error_estimate  # 0.035 to 0.12 of it were measured


def layered(*layers):
    """`paper` with slabs of these layers: share of the round trip, relative impedance."""
    layers = [{"fraction": share, "impedance": impedance} for share, impedance in layers]
    return slipwave.read("paper", {"slab.layers": layers, "slab.r": 2.3e-3})


def test_grids_that_leave_cells_as_they_are_are_not_compared():
    """Two cells and three make one grid of 2, 1 and 1 in these layers: 2e-5 was stated, of an error of 1.7e-2."""
    scene = layered((0.62, 0.8), (0.22, 0.7), (0.16, 2.4))
    solver, choice = to_a_tolerance(scene, 1e-4, number=3)
    error = np.abs(cycles(solver) / cycles(build("delay", scene, tolerance=1e-11)) - 1.0).max()
    assert error < choice.error_estimate <= 1e-4


def test_a_default_grid_of_many_layers_is_judged_by_one_with_other_cells():
    """In layers of few cells another number may change one of them in seventeen: 1.1e-6 was stated, of an error of 3.3e-6."""
    scene = layered((0.3, 1.0), (0.24, 0.7), (0.23, 1.5), (0.23, 0.7))
    solver = build("sbp:6", scene)
    choice = judged_grid(solver, solver.state())
    error = np.abs(cycles(solver) / cycles(build("delay", scene, tolerance=1e-11)) - 1.0).max()
    assert choice is not None
    assert 0.1 * choice.error_estimate < error < choice.error_estimate


def test_the_estimate_counts_the_error_of_the_steps_which_no_grid_shows():
    """Of grids with an error of 1e-8. Measured: 4e-5, the same on both grids."""
    solver, choice = to_a_tolerance(SCENES["alike"], 1e-2, number=12)
    assert solver.settings["resolution"] == pytest.approx(2e-4)
    assert choice.error_estimate == pytest.approx(2e-3, rel=1e-2)
    exact = cycles(DiscontinuousGalerkin(SCENES["alike"], number=11, cells=8))
    assert 1e-6 < np.abs(cycles(solver) / exact - 1.0).max() < choice.error_estimate


def test_a_grid_too_large_for_the_march_ends_the_search_with_what_was_reached(monkeypatch):
    monkeypatch.setattr("fullwave.lines.budget.MOST_UNKNOWNS", 200)
    jump = dataclasses.replace(SCENES["alike"], start=Start(StartKind.JUMP, 0.5), until=60.0)
    with pytest.raises(
        NumericsError, match=r"not reached with 8 cells: .*; cells = 12: \d+ unknowns, more than the 200 .* explicit"
    ):
        to_a_tolerance(jump, 1e-11, time="exact")


def test_a_jump_is_given_up_as_soon_as_its_trend_is_seen():
    """Order 1: a factor of 1e6 in the error would take a million times the cells, so few are tried."""
    jump = dataclasses.replace(SCENES["alike"], start=Start(StartKind.JUMP, 0.5), until=60.0)
    with pytest.raises(NumericsError, match=r"by its trend it needs about [\d,]+ cells, but at most 400 are tried") as refusal:
        to_a_tolerance(jump, 1e-11)
    assert int(str(refusal.value).split(" cells:")[0].split()[-1]) < 60


def test_the_steps_of_irregular_motion_become_finer_until_they_fit():
    """It amplifies their error 5000 times, the same on all grids: with the usual steps 9.5 times the tolerance was measured."""
    scene = slipwave.read("paper", ["log10_r=-2.3093", "drive.velocity=236.2"])
    solver, choice = to_a_tolerance(scene, 1e-4)
    error = np.abs(cycles(solver) / cycles(build("delay", scene, tolerance=1e-12)) - 1.0).max()
    assert 2e-6 < error < choice.error_estimate <= 1e-4  # 6.5e-5 measured
    assert solver.settings["resolution"] <= resolution_for(1e-4) / 8.0


def test_steps_that_cannot_become_fine_enough_end_the_search(monkeypatch):
    """Their error falls as their resolution: below the finest it is extrapolated."""

    class Series:
        model, step, transits_per_piece = "series", 1.0, 4.0

        def __init__(self, scene, cells, resolution):
            self.cells, self.settings = cells, {"resolution": resolution}

    monkeypatch.setattr("fullwave.adapt._probe", lambda solver: ("cycles", np.array([1.0 + 1e7 * solver.settings["resolution"]])))
    with pytest.raises(
        NumericsError, match=r"not reached with 3 cells: estimated error 4e-06; its steps are as short as they can"
    ):
        to_tolerance(SCENES["alike"], 1e-6, Series, 2.0, resolution=1e-8)


def test_grids_that_converge_late_are_not_given_up():
    """The difference of 26 and 39 cells is as large as that of the two before: by that trend 17,000,000 would be needed."""
    scene = slipwave.read("paper", ["log10_r=-2.3022", "drive.velocity=43.44"])
    solver, choice = to_tolerance(scene, 1e-4, SummationByParts, 4.0, 4.0, number=4, resolution=2e-6)
    error = np.abs(cycles(solver) / cycles(build("delay", scene, tolerance=1e-12)) - 1.0).max()
    assert choice.cells == 201
    assert 0.1 * choice.error_estimate < error < choice.error_estimate


@pytest.mark.parametrize(("credited", "cells", "estimate"), [(np.inf, 8, 1e-4), (6.0, 8, 0.04 / 1.5**6), (2.0, 18, 2.733e-3)])
def test_a_difference_that_is_small_by_chance_proves_nothing(monkeypatch, credited, cells, estimate):
    """No refinement of order 2 gains a factor of 400; at order 2 the estimate is half as much again."""
    values = {2: 1.124, 3: 1.044, 5: 1.004, 8: 1.0041, 12: 1.0, 18: 1.0}

    class Series:
        model, step, settings, transits_per_piece = "series", 1.0, {}, 4.0

        def __init__(self, scene, cells):
            self.cells = cells

    monkeypatch.setattr("fullwave.adapt._probe", lambda solver: ("cycles", np.array([values[solver.cells]])))
    _, choice = to_tolerance(SCENES["alike"], 7e-3, Series, 2.0, credited)
    assert (choice.cells, choice.error_estimate) == (cells, pytest.approx(estimate, rel=2e-2))
