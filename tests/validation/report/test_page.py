"""The page: seven questions, the table of models, rows of verdicts, in the words and numbers of the stored results."""

import re

import pytest
from fake_studies import answered

import slipwave
from slipwave.observe.statistics import Estimate
from validation.measure.regimes import AWAY, STEADY, UNDECIDED, UNTRIED, Regime
from validation.report import Evidence, Omission, Outcome, StudyResult, Verdict
from validation.report.compared import compared_table, onset
from validation.report.model_table import Compared, ModelCell, ModelColumn, ModelQuantity, ModelRow, ModelTable
from validation.report.names import by_claim
from validation.report.page import write_page
from validation.report.questions import QUESTIONS, ask, left_out
from validation.report.record import record_of
from validation.report.registered import STUDIES
from validation.report.store import StoredStudy


def stored(name, *verdicts, answers=(), **parts):
    named = by_claim(name, verdicts)
    result = StudyResult(answers, verdicts=named, **parts) if answers else answered("It does.", named, **parts)
    return StoredStudy(name, f"Does {name} work?", 1.0, True, result)


def verdict(outcome=Outcome.PASS, evidence=Evidence.EXACT, title="A holds", **more):
    return Verdict(title, evidence, "below 0.5", "0.1", outcome, **more)


def models():
    """Two models at three r: the second slides steadily at the first two, and is 40 % short at the third."""
    columns = tuple(
        ModelColumn(f"−{x}", -x, 1.0, group, f"paper --set slab.log10_r=-{x}")
        for x, group in ((2.7, "periodic"), (2.6, "periodic"), (2.5, "torus"))
    )
    own = [{"T": Compared(70.0 + n, None, 1e-9), "Δμ": Compared(0.2, None, 1e-9)} for n in range(3)]
    short = {"T": Compared(43.2, -0.4, 0.001), "Δμ": Compared(0.21, 0.05, 0.001)}
    still, moving = ModelCell("slides steadily", False), ("periodic", True, 140, short, "run --until 2e+04")
    exact = tuple(ModelCell("periodic", True, 0, figures) for figures in own)
    rows = (
        ModelRow("delay", exact, Compared(-2.69, None, 0.0), (1.0,), "use", ""),
        ModelRow("quasidynamic", (still, still, ModelCell(*moving)), None, (0.05,), "avoid", "other cycles"),
    )
    quantities = (ModelQuantity("T", "period", "transits"), ModelQuantity("Δμ", "stress drop", "σ"))
    return ModelTable(
        "paper", "Errors. Of orbits.", "log_{10} r", quantities, columns, ("−2.6",), "delay", rows, ("Use `delay`.",)
    )


def page_of(tmp_path, *studies):
    return write_page(tmp_path, studies, record_of(studies, False, "today")).read_text(encoding="utf-8")


def summary_of(html, name):
    return re.search(rf'<details class="\w+" id="{name}"[^>]*>\s*<summary>(.*?)</summary>', html, re.DOTALL)[1]


def rows_of(html, label):
    """Cells of the table in the region of this label, without tags."""
    table = html.split(f'aria-label="{label}"')[1].split("</table>")[0]
    rows = re.findall(r"<tr.*?</tr>", table, re.DOTALL)
    return [[re.sub(r"<.*?>", "", cell) for cell in re.findall(r"<t[hd].*?</t[hd]>", row, re.DOTALL)] for row in rows]


def test_every_study_answers_one_question():
    assert {*STUDIES.values()} == {*QUESTIONS} - {"changed"}
    assert {*QUESTIONS} & {*STUDIES} == set()  # both are anchors of the page


def test_a_question_is_answered_by_its_studies_and_by_none_that_fails(tmp_path):
    answers = {"It folds.": ("A holds",), "It doubles.": ("B",)}
    sound = stored("bifurcation", verdict(), verdict(title="B holds"), answers=answers)
    broken = stored("snaking", verdict(Outcome.FAIL), answers={"It folds.": ("A holds",)})
    stopped = StoredStudy("onset", "?", 1.0, True, error="it died")
    asked = {one["name"]: one for one in ask([broken, sound, stopped], "Nothing.")}
    failed = "Not shown: 1 of 1 checks fail (A holds)."
    told = ["It folds.", failed, "But: 1 check of `snaking` failed; `onset` did not finish."]
    assert asked["begin"]["answers"] == told
    assert [[one.id for one in proofs] for _, proofs in asked["begin"]["rests_on"]] == [
        ["bifurcation.a-holds"],
        ["snaking.a-holds"],
    ]
    assert (asked["changed"]["answers"], asked["cost"]["answers"]) == (["Nothing."], ["Not computed in this report."])
    html = page_of(tmp_path, sound)
    assert "It folds." in summary_of(html, "begin")
    cited = {address for line in re.findall('<p class="rests">(.*?)</p>', html) for address in re.findall('href="#(.*?)"', line)}
    assert cited == {"bifurcation", "bifurcation.a-holds", "bifurcation.b-holds"}


def test_a_row_of_a_verdict_has_found_beside_limit_and_their_ratio(tmp_path):
    html = page_of(tmp_path, stored("energy", verdict(found=0.1, limit=0.5)))
    assert rows_of(html, "verdicts energy")[1][1:] == ["A holds", "exact", "below 0.5", "0.1", " 0.2"]
    assert '<tr id="energy.a-holds">' in html
    assert '<i style="width:20%">' in html


def test_a_verdict_that_is_not_decided_has_its_own_light(tmp_path):
    html = page_of(tmp_path, stored("energy", verdict(Outcome.OPEN), verdict(title="B holds")))
    assert [row[0] for row in rows_of(html, "verdicts energy")[1:]] == ["?", "✓"]
    assert rows_of(html, "studies and kinds of evidence")[1][1] == "? 2"


def test_a_claim_of_several_cases_is_told_once(tmp_path):
    told = [("B holds", "at 1"), ("A holds", "at 1"), ("B holds", "at 2")]
    html = page_of(tmp_path, stored("energy", *(verdict(title=title, remark=remark) for title, remark in told)))
    assert '<tr class="claim" id="energy.b-holds">' in html
    assert '<tr id="energy.b-holds.exact-at-2">' in html
    rows = [row[1:4] for row in rows_of(html, "verdicts energy")[1:]]
    shared = ["B holds", "exact", "below 0.5"]
    assert rows == [shared, ["at 1", "", ""], ["at 2", "", ""], ["A holdsat 1", "exact", "below 0.5"]]


def test_every_address_within_the_page_leads_somewhere(tmp_path):
    html = page_of(
        tmp_path,
        stored("which-model", verdict(Outcome.FINDING, remark="`delay`"), model_tables=(models(),)),
        stored("energy", verdict(Outcome.FAIL)),
    )
    names = re.findall(r'id="(.*?)"', html)
    assert len(names) == len(set(names))
    assert set(re.findall(r'href="#(.*?)"', html)) <= set(names)


def test_the_table_of_models_joins_cells_of_a_wrong_regime(tmp_path):
    html = page_of(tmp_path, stored("which-model", verdict(), model_tables=(models(),)))
    assert "Use <code>delay</code>." in html
    head, titles, delay, short = rows_of(html, "error of the period, paper")
    assert head[1:] == ["periodic", "torus", "cost, delay = 1", "advice"]
    assert titles == ["−2.7", "−2.6", "−2.5", "at −2.6"]
    assert delay == ["delay T, transits", "70", "71", "72", "1", "use"]
    assert short == ["quasidynamic", "slides steadily", "−40.0 ± 0.2\u00a0%", "0.05", "avoid other cycles"]
    assert '<td class="n wrong first" colspan="2"><a href="#models.paper.quasidynamic.-2.7">slides steadily</a></td>' in html
    assert rows_of(html, "error of the stress drop, paper")[3][2] == "+5.0 ± 0.2\u00a0%"
    assert rows_of(html, "onset of stick-slip, paper")[1:] == [["delay", "−2.690000", "exact"], ["quasidynamic", "–", "–"]]


def test_every_cell_has_its_numbers_its_verdicts_and_a_command(tmp_path):
    html = page_of(tmp_path, stored("which-model", verdict(remark="`quasidynamic`"), model_tables=(models(),)))
    head, *_, last = rows_of(html, "every cell of the table paper")
    assert head[3:5] == ["Ttransits", "standard errorof its error, relative"]  # that of the exact system's error is in it
    assert last[:5] == [
        "−2.5",
        "periodic, 140 cycles",
        "slipwave run paper --set slab.log10_r=-2.5 --model quasidynamic --until 2e+04",
        "43.2",
        "1.0\u202f·\u202f10−3",
    ]
    assert rows_of(html, "every cell of the table paper")[5] == ["quasidynamic ✓ "]


def test_a_reason_with_numbers_is_checked_by_a_verdict_or_said_not_to_be(tmp_path):
    named = [Omission("Gone.", "At 3.", ("A holds",)), Omission("Lost.", "At 4.", ("B holds",)), Omission("Else.", "No.")]
    studies = [stored("energy", verdict(title="A holds so")), stored("claims", omissions=tuple(named))]
    assert [([v.claim for v in proofs], bare) for _, _, proofs, bare in left_out(studies)] == [
        (["A holds so"], False),
        ([], True),
        ([], False),
    ]
    html = page_of(tmp_path, *studies)
    assert "3 reasons, 1 unchecked" in summary_of(html, "omissions")
    assert 'At 3. <a href="#claims">claims</a> <a href="#energy.a-holds-so"' in html


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
        "Use `delay`: it is exact and costs as little as any ODE that is right to 1 % (those take ~{1.2} times as long); where "
        "an ODE is needed, `modal:8` (off by at most 1 · 10^{−4} where orbits repeat), `modal:1` up to 1.05 r_{c}."
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
    found = {"delay": [good] * 4, "modal:1": [good, good, good, bad]}
    found |= {"block8": [good, bad, good, good], "modal:8": [none, good] * 2}
    table = table_of(found, columns=columns)
    assert [column.group for column in table.columns] == ["r = 1.02 r_{c}"] * 2 + ["r = 1.25 r_{c}"] * 2
    assert [row.advice for row in table.rows] == ["use", "use up to 1.02 r_{c}", "avoid", "use"]
