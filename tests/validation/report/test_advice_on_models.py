"""The table of models from regimes and run times: errors, their error bars, units, advice and the two sentences."""

import pytest

import slipwave
from slipwave.observe.statistics import Estimate
from validation.measure.regimes import AWAY, STEADY, UNDECIDED, UNTRIED, Regime
from validation.report.compared import compared_table, onset
from validation.report.model_table import Compared, ModelCell, ModelColumn

PAPER = slipwave.read("paper")
COLUMNS = [ModelColumn("near", -2.68, 1.05, ""), ModelColumn("far", -2.5, 1.6, "")]


def regime(period, drop=0.2, v_max=4000.0, words="periodic", error=0.0):
    figures = {"T": Estimate(period, error), "Δμ": Estimate(drop, 0.0), "v_{max}": Estimate(v_max, 0.0)}
    return Regime(words, figures, 0 if words == "periodic" else 90)


EXACT = [regime(70.0), regime(90.0, words="irregular", error=0.9)]
REGIMES = {
    "delay": EXACT,
    "dg:7": EXACT,
    "modal:8": [regime(70.007), regime(90.9, words="irregular", error=0.9)],
    "modal:1": [regime(70.35), regime(90.0)],
    "kelvin-voigt": [regime(67.9), regime(72.0, words="irregular")],
    "quasidynamic": [Regime(STEADY), regime(45.0)],
    "quasistatic": [Regime(AWAY)] * 2,
}


def table_of(regimes, costs=None, columns=COLUMNS, onsets=None):
    return compared_table("paper", "caption", "r/r_{c}", columns, regimes, onsets or {}, costs or {})


def a_table(cost=1.2):
    times = {model: {"modal:8": cost, "dg:7": 4.0}.get(model, 1.0) for model in REGIMES}
    return table_of(REGIMES, {"near": times}, onsets={model: onset(model, PAPER) for model in REGIMES})


def test_the_table_has_errors_against_the_exact_system():
    table = a_table()
    assert [column.group for column in table.columns] == ["periodic", "torus, irregular"]
    exact, modal = table.row("delay").cells[1], table.row("modal:8").cells[1]
    assert exact.figures["T"] == Compared(90.0, None, pytest.approx(0.01))
    assert modal.figures["T"] == Compared(90.9, pytest.approx(0.01), pytest.approx(0.0141, rel=1e-2))
    assert modal.figures["v_{max}"] == Compared(4000.0, 0.0, 0.0)
    assert table.row("kelvin-voigt").cells[0].figures["T"].error == pytest.approx(-0.03)
    assert table.row("quasidynamic").cells[0] == ModelCell(STEADY, right=False)
    assert table.row("quasidynamic").onset.error == pytest.approx(0.1126, rel=1e-3)
    assert table.row("dg:7").onset.error == 0.0


def test_where_a_regime_is_undecided_it_speaks_neither_for_a_model_nor_against_it():
    away, first = [Regime(AWAY)] * 2, [Regime(UNDECIDED), EXACT[0]]
    table = table_of({"delay": first, "quasistatic": away, "modal:8": first})
    assert (table.parameter, [column.group for column in table.columns]) == ("r/r_{c}", ["undecided", "periodic"])
    found = {"delay": EXACT, "quasidynamic": [Regime(UNDECIDED), Regime(STEADY)], "modal:8": [Regime(UNDECIDED), EXACT[1]]}
    for one in (table, table_of(found)):
        assert [row.advice for row in one.rows] == ["use", "avoid", "use"]


def test_advice_and_sentences_follow_the_table():
    table = a_table()
    assert {row.model: (row.advice, row.why) for row in table.rows} == {
        "delay": ("use", "exact"),
        "dg:7": ("use as witness", "full wave"),
        "modal:8": ("use", "as an ODE, off by 1 · 10^{−4}"),
        "modal:1": ("use up to 1.05 r_{c}", "then periodic"),
        "kelvin-voigt": ("avoid", "T −3.0 to −20 %"),
        "quasidynamic": ("avoid", "slides steadily up to 1.05 r_{c}, then T −50 %"),
        "quasistatic": ("avoid", "runs away"),
    }
    use, avoid = table.sentences
    assert use == (
        "Use `delay`: it is exact and costs as little as any ODE that is right to 1 % (they take ~{1.2} times as long); where an "
        "ODE is needed, `modal:8` (off by at most 1 · 10^{−4} where orbits repeat), `modal:1` up to 1.05 r_{c}."
    )
    assert avoid.startswith("Avoid `kelvin-voigt` (T −3.0 to −20 %), `quasidynamic` (slides steadily up to 1.05 r_{c}, then")
    assert "ODEs that are right to 1 % take ~{0.5} times as long" in a_table(cost=0.5).sentences[0]


def test_each_ode_is_off_by_its_own_error_and_a_full_wave_is_no_ode():
    """Errors are rounded up; three standard errors of a mean are chance in a full wave, and a fault in an ODE."""
    chance = regime(85.0, words="irregular", error=0.9)
    more = {"modal:4": [regime(70.0141), EXACT[1]], "modal:2": [regime(70.0), chance], "dg:7": [EXACT[0], chance]}
    first = [regime(70.0, drop=0.21), regime(90.0, words="irregular", error=0.9)]
    table = table_of(REGIMES | more | {"block8": first})
    assert "`modal:8` or `modal:4` (off by at most 1 · 10^{−4} or 3 · 10^{−4} where orbits repeat)," in table.sentences[0]
    assert "dg:7" not in table.sentences[0]
    assert (table.row("dg:7").advice, table.row("modal:2").advice) == ("use as witness", "use up to 1.05 r_{c}")
    assert table.row("block8").why == "Δμ +0.0 to +5.0 %"


def test_advice_over_scenes_goes_by_the_least_r_at_which_a_model_fails():
    """Columns of several scenes at the same r over their onsets; a scene in which a model was not tried says nothing of it."""
    columns = [ModelColumn(name, -2.6, over_onset, f"r = {over_onset} r_{{c}}") for over_onset in (1.02, 1.25) for name in "ab"]
    good, bad, none = regime(70.0), regime(80.0), Regime(UNTRIED)
    found = {
        "delay": [good] * 4,
        "modal:1": [good, good, good, bad],
        "block8": [good, bad, good, good],
        "modal:8": [none, good] * 2,
    }
    table = table_of(found, columns=columns)
    assert [column.group for column in table.columns] == ["r = 1.02 r_{c}"] * 2 + ["r = 1.25 r_{c}"] * 2
    assert [row.advice for row in table.rows] == ["use", "use up to 1.02 r_{c}", "avoid", "use"]
