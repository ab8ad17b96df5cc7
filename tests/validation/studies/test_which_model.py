"""The study of all models: its tables, other scenes and the laws of the errors."""

import json
import shlex

import pytest
from llvmlite.binding import get_host_cpu_name
from test_quick_studies import held

import slipwave
from validation.commands.cli import main
from validation.report import Outcome
from validation.report.answer import read_table
from validation.report.compared import EXACT_MODEL, critical_r
from validation.report.model_table import words_of
from validation.studies import which_model as study
from validation.studies.which_model import judged, laws, scenes
from validation.studies.which_model.means import RECORD


@pytest.mark.studies
def test_the_tables_have_every_model_at_every_r():
    """At log10 r = -2.65 the period is 79.3225 in the mean (lifted shooting); eight modes keep the torus."""
    result = held("which-model")
    table, elsewhere = result.model_tables
    assert [row.model for row in table.rows] == list(study.EVERY)
    assert [column.group for column in table.columns] == ["periodic"] * 3 + ["torus, irregular"] * 2
    assert [words_of(cell, "T") for cell in table.row("quasidynamic").cells][:3] == ["slides steadily"] * 3
    assert {cell.regime for cell in table.row("quasistatic").cells} == {"runs away"}
    assert table.row("quasidynamic").onset.value == pytest.approx(-2.6532125, abs=1e-7)
    assert (table.row("delay").advice, table.row("kelvin-voigt").advice) == ("use", "avoid")
    at = {row.model: row.cells[3] for row in table.rows}
    assert [at[model].regime for model in ("delay", "modal:8", "kelvin-voigt")] == ["torus", "torus", "periodic"]
    damped, mean = at["quasidynamic"].figures, at["delay"].figures["T"]
    assert (damped["T"].value, damped["Δμ"].value) == pytest.approx((48.371789354, 0.0221755339), rel=1e-8)
    assert result.numbers["quasidynamic T at -2.65"].value == damped["T"].value
    assert abs(mean.value - 79.3225) < 2.0 * mean.standard_error * mean.value < 0.1
    assert (at["kelvin-voigt"].figures["T"].value, at["kelvin-voigt"].right) == (pytest.approx(75.30034, abs=1e-5), False)
    tried = {row.model: [column.title for column, *_ in judged.cells_of(elsewhere, row.model)] for row in elsewhere.rows}
    assert (tried["modal:8"], tried["fitted:4"]) == (["unlike", "rock"] * 2, ["grip"] * 2)
    assert {row.model for row in elsewhere.rows if row.advice == "avoid"} >= {"kelvin-voigt", "block12", "quasistatic"}


FIGURES = {"T": "period", "Δμ": "stress_drop"}


def repeats(cell, command, capsys):
    """Whether a command of the page prints the figures of its cell in all digits of the page; means of irregular motions on
    another processor than that of the record within four standard errors."""
    assert main([*shlex.split(command)[1:], "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    known = cell.regime != "irregular" or get_host_cpu_name() == json.loads(RECORD.read_bytes())["processor"]
    found = {symbol: told[name]["mean"] if "run" in command else told[name] for symbol, name in FIGURES.items()}
    found["v_{max}"] = told["v_max_median" if cell.cycles else "v_max"]
    ours = {symbol: (one.value, one.standard_error) for symbol, one in cell.figures.items()}
    off = {symbol: abs(found[symbol] / value - 1.0) / (1.0 if known else 8e6 * error) for symbol, (value, error) in ours.items()}
    return all(one < 5e-7 for one in off.values())


@pytest.mark.parametrize(("model", "place"), [("modal:1", 1), ("modal:2", 3)])
def test_a_printed_command_repeats_an_orbit_and_a_mean(model, place, capsys):
    table = read_table()
    cell, column = table.row(model).cells[place], table.columns[place]
    assert (cell.regime, cell.cycles > 0) == (("periodic", False) if place == 1 else ("torus", True))
    assert repeats(cell, cell.command_for(table.row(model), column), capsys)


@pytest.mark.slow
def test_ten_printed_commands_repeat_their_figures(capsys):
    """Of both tables, every so many of those that take seconds; the first is of an orbit, the last of a scene in SI."""
    cells = [found for table in held("which-model").model_tables for found in judged.cells_of(table) if found[2].figures]
    quick = [found for found in cells if "e+06" not in found[2].command]
    chosen = quick[:: len(quick) // 10][:10]
    assert len({cell.command.partition(" ")[0] for _, _, cell in chosen}) == 2
    assert [column.title for column, row, cell in chosen if not repeats(cell, cell.command_for(row, column), capsys)] == []


@pytest.mark.parametrize("name", ["unlike", "grip", "rock"])
def test_the_settings_of_a_place_make_its_scene(name):
    """Both slabs scaled together, 1.1 times the onset; the column names the options that repeat it."""
    column, scene = scenes.place(name, 1.1)
    first, *options = [word for word in column.settings.split() if word != "--set"]
    again = slipwave.read(first, options)
    for slab, other in zip(again.slabs, scene.slabs, strict=True):
        assert (slab.round_trip, slab.epsilon) == pytest.approx((other.round_trip, other.epsilon), rel=1e-5)
    assert again.start == scene.start
    assert scene.transit == pytest.approx(1.1 * critical_r(EXACT_MODEL, again), rel=1e-4)
    assert 10.0**column.log10_r == pytest.approx(scene.transit)


def test_the_cycles_error_does_not_fall():
    measured = [laws.measure_cycle(slipwave.read("paper"), scale) for scale in (1.0, 0.5)]
    assert [one.error() for one in measured] == pytest.approx([-0.0318, -0.0292], abs=2e-4)
    assert [one.outcome for one in laws.law_verdicts({}, measured)] == [Outcome.FINDING]
