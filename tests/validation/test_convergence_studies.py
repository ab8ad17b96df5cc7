"""The two studies of convergence: outcomes on both sides of every limit, answers, shared code, figures."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from fullwave.families import GALERKIN
from slipwave.observe.statistics import Estimate
from validation.measure.grid_ladders import LADDERS
from validation.measure.order_fit import fit
from validation.measure.orders import QUANTITIES, Climb
from validation.measure.settle import SYMBOLS
from validation.studies import grid_convergence, leapfrog_convergence
from validation.studies.grid_convergence import orbits
from validation.studies.grid_convergence.code import code_note, code_table, shared
from validation.studies.grid_convergence.shown import convergence_and_cost, finest_table, orders_table
from validation.studies.leapfrog_convergence import ladders
from validation.study import Budget, Evidence, Outcome

CELLS = np.array([48, 96, 192, 384])
NAMES = (*SYMBOLS, leapfrog_convergence._SMOOTH, leapfrog_convergence._JUMP)


def leapfrog_errors(order=2.0, jump=1.0):
    return {
        name: dict.fromkeys(leapfrog_convergence.CFLS, 0.001 * (CELLS / 48.0) ** (-(jump if "jump" in name else order)))
        for name in NAMES
    }


def fits_of(errors):
    return {name: {cfl: fit(CELLS, values) for cfl, values in some.items()} for name, some in errors.items()}


@pytest.mark.parametrize(
    ("order", "jump", "red"), [(2.08, 0.92, 0), (1.92, 1.08, 0), (2.3, 1.0, 3), (1.7, 1.0, 3), (2.0, 0.7, 3), (2.0, 1.3, 3)]
)
def test_the_leapfrogs_orders_are_judged_on_both_sides(order, jump, red):
    verdicts = leapfrog_convergence._verdicts(fits_of(leapfrog_errors(order, jump)))
    assert [verdict.outcome for verdict in verdicts].count(Outcome.FAIL) == red
    assert [verdict.evidence for verdict in verdicts].count(Evidence.SELF) == 2  # CFL 1 is the delay system's own rule


@pytest.mark.parametrize(("cfl", "cells"), [(0.5, 60.0), (0.9, 60.0), (1.0, 3.0)])
def test_what_extrapolation_leaves(cfl, cells):
    """An error c h^2 with a part of order 4 that is just allowed, and three times that."""
    limit = (cells / 384.0) ** 2 * 1e-7

    def verdict(left):
        fine = 1e-7
        return leapfrog_convergence._extrapolated(np.array([4.0 * fine - 3.0 * left, fine]), 384, cfl)

    assert verdict(0.9 * limit).outcome is Outcome.PASS
    assert verdict(-0.9 * limit).outcome is Outcome.PASS
    assert verdict(3.0 * limit).outcome is Outcome.FAIL
    assert verdict(-3.0 * limit).outcome is Outcome.FAIL


def test_the_leapfrogs_study_shows_every_error_it_measured(monkeypatch):
    monkeypatch.setattr(leapfrog_convergence, "_measure", lambda cells, budget: leapfrog_errors())
    result = leapfrog_convergence.run(Budget(quick=True))
    assert [figure.name for figure in result.figures] == ["ladders"]
    drawn = [axes.get_lines()[1].get_ydata() for axes in result.figures[0].draw().axes if axes.get_lines()]
    assert np.array_equal(drawn, [errors[0.5] for errors in leapfrog_errors().values()])
    assert [len(table.rows) for table in result.tables] == [len(NAMES), len(CELLS)]
    assert len(result.verdicts) == 9
    assert "no independent evidence" in "".join(result.notes)
    remembered = {name: number.value for name, number in result.numbers.items()}
    assert remembered == {f"T error, CFL {cfl}, 96 cells": 0.00025 for cfl in (0.5, 0.9, 1.0)}


def test_the_leapfrogs_answer_follows_its_orders():
    yes = leapfrog_convergence._answer(fits_of(leapfrog_errors(2.0, 1.0)))
    assert yes.startswith("Yes: from the smooth start at orders 2.00 to 2.00")
    assert leapfrog_convergence._answer(fits_of(leapfrog_errors(0.1, 1.0))).startswith("No: from the smooth start at orders 0.10")


GRIDS = [orbits.GridOrbit("sbp:6", cells, 1e-3 * cells**-6.0, 1e-2 * cells**-6.0) for cells in (24, 32)]


@pytest.mark.parametrize(("quick", "model"), [(quick, model) for quick, known in orbits.FAMILIES.items() for model in known])
def test_agreement_on_the_grids_own_orbit(quick, model):
    """Both figures on both sides of their limits."""
    limits = orbits.FAMILIES[quick][model].allowed

    def outcomes(*shares):
        last = orbits.GridOrbit(model, 8, *(share * limit for share, limit in zip(shares, limits, strict=True)))
        return [verdict.outcome for verdict in orbits._agreement(last, limits)]

    assert outcomes(0.9, 0.9) == [Outcome.PASS] * 2
    assert outcomes(3.0, 0.9) == [Outcome.FAIL, Outcome.PASS]
    assert outcomes(0.9, np.inf) == [Outcome.PASS, Outcome.FAIL]


@pytest.mark.parametrize(("order", "outcome"), [(6.01, "pass"), (8.0, "pass"), (5.9, "fail")])
def test_orbits_must_converge_at_the_declared_order(order, outcome):
    family = [one._replace(stress_drop=1e-2 * (one.cells / 24) ** -order) for one in GRIDS]
    assert orbits.order_of(family, "stress_drop") == pytest.approx(order)
    assert orbits.order_of(family, "period") == pytest.approx(6.0)
    assert orbits._order([one._replace(period=one.stress_drop) for one in family]).outcome == outcome


def test_an_order_ends_where_rounding_begins():
    """The finest error above the floor counts; the second grid in any case."""
    family = [orbits.GridOrbit("dg:7", cells, error, error) for cells, error in ((2, 1e-4), (4, 1e-7), (8, 1e-10), (16, 2e-13))]
    assert orbits.order_of(family, "period") == pytest.approx(np.log(1e6) / np.log(4.0))
    assert orbits.order_of([family[0], family[3]], "period") == pytest.approx(np.log(5e8) / np.log(8.0))


def beside(off, error=0.0, cycles=0):
    """Periods 80 and drops 0.2, the wave's period off by a share, both periods known to an error."""
    wave = (Estimate(80.0 * (1.0 + off), error), Estimate(0.2, 1e-3))
    return orbits.Beside(-2.5, wave, (Estimate(80.0, error), Estimate(0.2, 1e-3)), cycles)


def test_the_full_wave_as_r_grows():
    assert [next(orbits._grown([beside(off)])).outcome for off in (4.5e-10, -15e-10)] == [Outcome.PASS, Outcome.FAIL]
    far = [[*orbits._grown([beside(0.0), beside(off, 0.1, 50)])][1].outcome for off in (0.0069, -0.0072)]
    assert far == [Outcome.PASS, Outcome.FAIL]  # four standard errors of 0.1 sqrt(2) are 0.0071 of 80
    rows = orbits.growth_table([beside(2e-10), beside(0.00177, 0.1, 50)]).rows
    assert rows[0][5:] == ("2 · 10^{−10}", None)
    assert rows[1][5:] == ("1.0 standard errors", 50)


WAVE, DELAY = (orbits._WAVE, orbits._WAVE_CELLS), ("delay", None)


@pytest.mark.parametrize(
    ("model", "figure", "outcome"),
    [(WAVE, "", "pass"), *((model, figure, "fail") for model in (WAVE, DELAY) for figure in ("period", "stress_drop"))],
)
def test_means_of_a_displaced_model_are_red(model, figure, outcome, monkeypatch):
    """400 irregular cycles with a spread of 1 % for each model; one figure of one model is displaced by 2 % in turn."""
    draw = {WAVE: np.random.default_rng(1).standard_normal, DELAY: np.random.default_rng(2).standard_normal}

    def cycles(name, scene, until, cells):
        found = {key: value * (1.0 + 0.01 * draw[name, cells](400)) for key, value in (("period", 80.0), ("stress_drop", 0.2))}
        if (name, cells) == model and figure:
            found[figure] *= 1.02
        return SimpleNamespace(**found)

    monkeypatch.setattr(orbits, "late_cycles", cycles)
    (found,) = orbits.as_r_grows((), (-2.5,))
    assert found.cycles == 400
    assert [verdict.outcome for verdict in orbits._grown([found])] == [outcome]


def test_a_run_beside_itself_is_red():
    assert next(orbits._grown([beside(0.0, 0.1, 50)])).outcome is Outcome.FAIL


def climbed(model="sbp:4", order=4.0):
    ladder = replace(LADDERS[model], finest=1.0)
    cells = np.array(ladder.levels(), dtype=float)
    return Climb(ladder, cells, np.ones(cells.size), dict.fromkeys(QUANTITIES, (4 * cells / cells[0]) ** (-order)))


def test_the_grids_answer_follows_errors_and_orders():
    fine = [one._replace(stress_drop=1e-10) for one in GRIDS]
    curves = {"fd": (CELLS, np.array([1e-3, 2e-3, 3e-3, 4e-3]), np.array([1e-2, 1e-3, 9e-5, 1e-5]))}
    told = grid_convergence._answer([climbed()], fine, curves)
    assert told.startswith("They do: in period and stress drop of their own orbits summation by parts to 1 · 10^{−10};")
    assert "every family tried reaches its order" in told
    assert told.endswith("An error of the state below 1 · 10^{−4} costs 3 ms with `fd`.")
    assert "1 of 2 families miss their order" in grid_convergence._answer([climbed(), climbed(order=3.5)], fine, curves)


def test_the_tables_of_a_ladder_show_its_orders_and_its_finest_grid():
    one = climbed()
    last = one.cells.size - 1
    (orders,), (finest,) = orders_table([one]).rows, finest_table([one]).rows
    assert orders[:4] == ("sbp:4", "s", f"{one.cells[0]:.0f}\u2060–\u2060{one.cells[last]:.0f}", "4")
    assert orders[4:] == ("4.00\u00a0±\u00a00.01",) * 6
    assert finest == ("sbp:4", "s", one.cells[last], 1000.0, *[one.errors["state"][last]] * 5)


def test_a_ladder_without_an_order_is_named_and_the_others_keep_their_rows():
    right = climbed()
    lost = replace(
        right, ladder=replace(right.ladder, model="fv"), errors=dict.fromkeys(QUANTITIES, np.full(right.cells.size, np.inf))
    )
    verdict = grid_convergence._order_verdict(lost)
    assert (verdict.outcome, verdict.ours, verdict.remark) == (
        Outcome.FAIL,
        "no order: 0 usable levels; an order needs 4",
        "`fv`",
    )
    none = replace(GALERKIN, pattern="volumes:P", ladder={})
    rows = orders_table([lost, right], [none]).rows
    assert [(row[0], row[3], row[-1]) for row in rows] == [
        ("fv", "4", "no order: 0 usable levels; an order needs 4"),
        ("sbp:4", "4", "4.00\u00a0±\u00a00.01"),
        ("volumes:7", "8", "not judged: declares no ladder"),
    ]
    empty = replace(lost, cells=np.array([]), seconds=np.array([]), errors=dict.fromkeys(QUANTITIES, np.array([])))
    assert [row[0] for row in finest_table([empty, right]).rows] == ["sbp:4"]
    assert grid_convergence._order_verdict(empty).outcome is Outcome.FAIL


def test_every_family_with_a_ladder_is_judged_by_a_quick_report(monkeypatch):
    own = replace(GALERKIN, pattern="volumes", numbers=(), default=None, ladder={0: GALERKIN.ladder[1]})
    monkeypatch.setattr(grid_convergence, "GRIDS", (*grid_convergence.GRIDS, own, replace(own, pattern="bare", ladder={})))
    assert grid_convergence.judged(quick=True) == (*grid_convergence._QUICK, "volumes")
    assert set(grid_convergence.judged(quick=False)) == set(LADDERS)


def test_which_code_is_common_is_read_from_the_imports(monkeypatch):
    assert {"fullwave.lines.march", "fullwave.lines.motion", "fullwave.lines.kernel"} <= set(shared("sbp", "dg"))
    assert not {"fullwave.lines.march", "fullwave.lines.motion", "fullwave.lines.kernel"} & set(shared("fd", "dg"))
    assert shared("delay", "fem") == ()
    assert len(code_table().rows) == 10
    note = code_note()
    assert "`sbp`, `fem` and `dg` have 23 modules in common, among them the right-hand side with its faces" in note
    assert "8 modules in common with them, but not the right-hand side" in note
    assert "no solver modules in common with any of them" in note


def test_the_figure_of_the_leapfrog_shows_every_error():
    errors = leapfrog_errors()
    figure = ladders(CELLS, errors, fits_of(errors))
    panels = [axes for axes in figure.axes if axes.get_lines()]
    assert len(panels) == len(NAMES)
    assert [axes.get_ylabel() for axes in (figure.axes[0], figure.axes[4])] == ["relative error", "error"]
    assert figure.axes[4].get_xlabel() == "cells per slab"
    drawn = panels[0].get_lines()[1]
    assert np.array_equal(drawn.get_xdata(), CELLS)
    assert np.array_equal(drawn.get_ydata(), errors["period"][0.5])


def test_the_figure_of_the_families_shows_error_over_points_and_time():
    curves = {
        "fd": (CELLS, np.array([1e-3, 2e-3, 3e-3, 4e-3]), 1e-3 * np.ones(4)),
        "dg:4": (CELLS, CELLS * 1e-3, 1e-5 * np.ones(4)),
    }
    figure = convergence_and_cost(curves)
    left, right = figure.axes
    assert [axes.get_xlabel() for axes in (left, right)] == ["points per slab", "run time (ms)"]
    assert left.get_ylabel() == "error of the state"
    assert np.allclose(right.get_lines()[0].get_xdata(), [1.0, 2.0, 3.0, 4.0])
    assert np.array_equal(left.get_lines()[1].get_ydata(), curves["dg:4"][2])
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["leapfrog", "Galerkin 4"]
