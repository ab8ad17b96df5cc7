"""The study of all models: its tables, other scenes and the laws of the errors."""

import pytest
from test_quick_studies import held

import slipwave
from validation.studies import which_model as study
from validation.studies.which_model import judged, laws, scenes
from validation.study import Outcome
from validation.study.compared import EXACT_MODEL, critical_r
from validation.study.model_table import words_of


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
