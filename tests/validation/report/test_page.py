"""The page: seven questions, the table of models, rows of verdicts, in the words and numbers of the stored results."""

import re

from fake_studies import answered

from validation.report import Evidence, Omission, Outcome, StudyAnswer, StudyResult, Verdict
from validation.report.model_table import Compared, ModelCell, ModelColumn, ModelQuantity, ModelRow, ModelTable
from validation.report.names import by_claim
from validation.report.page import write_page
from validation.report.questions import QUESTIONS, ask, left_out
from validation.report.record import record_of
from validation.report.registered import STUDIES
from validation.report.store import Stored

FACTS = dict.fromkeys(("slipwave", "commit", "solver sources", "scene paper", "platform", "processor", "cores"), "1")


def stored(name, *verdicts, answers=(), **parts):
    named = by_claim(name, verdicts)
    result = StudyResult(answers, verdicts=named, **parts) if answers else answered("It does.", named, **parts)
    return Stored(name, f"Does {name} work?", 1.0, True, result)


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
    rows = (
        ModelRow(
            "delay",
            tuple(ModelCell("periodic", True, 0, figures) for figures in own),
            Compared(-2.69, None, 0.0),
            (1.0,),
            "use",
            "",
        ),
        ModelRow("quasidynamic", (still, still, ModelCell(*moving)), None, (0.05,), "avoid", "other cycles"),
    )
    quantities = (ModelQuantity("T", "period", "transits"), ModelQuantity("Δμ", "stress drop", "σ"))
    return ModelTable(
        "paper", "Errors. Of orbits.", "log_{10} r", quantities, columns, ("−2.6",), "delay", rows, ("Use `delay`.",)
    )


def page_of(tmp_path, *studies):
    return write_page(tmp_path, studies, FACTS, record_of(studies, FACTS, False, "today")).read_text(encoding="utf-8")


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
    answers = StudyAnswer("It folds.", ("A holds",)), StudyAnswer("It doubles.", ("B",))
    sound = stored("bifurcation", verdict(), verdict(title="B holds"), answers=answers)
    broken = stored("snaking", verdict(Outcome.FAIL), answers=answers[:1])
    stopped = Stored("onset", "?", 1.0, True, error="it died")
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
    assert rows_of(html, "onset of stick-slip, paper")[1:] == [
        ["delay", "−2.690000", "exact"],
        ["quasidynamic", "–", "–"],
    ]


def test_every_cell_has_its_numbers_its_verdicts_and_a_command(tmp_path):
    html = page_of(tmp_path, stored("which-model", verdict(remark="`quasidynamic`"), model_tables=(models(),)))
    last = rows_of(html, "every cell of the table paper")[-1]
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
