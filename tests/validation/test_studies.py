"""The registered studies: their shape, their verdicts, and that a wrong number makes a verdict fail."""

from types import SimpleNamespace

import pytest
from counterfeit import PLACES
from shown import quick
from test_quick_studies import held

import slipwave
from slipwave.input.source import gallery_names
from validation.report.build import make_report
from validation.studies import STUDIES, scene_facts, study_called
from validation.study import Outcome
from validation.timing import Setting, TimedRun, cheapest, time_final, time_run


@pytest.mark.parametrize("name", STUDIES)
def test_a_study_says_what_it_is(name):
    study = study_called(name)
    assert name == study.NAME
    assert study.QUESTION.endswith("?")
    assert set(study.SCENES) <= set(gallery_names())
    assert all(seconds > 0 for seconds in study.SECONDS)
    assert name in PLACES


def bad(result):
    return [f"{v.claim}: expected {v.expected}, ours {v.ours}" for v in result.verdicts if v.outcome is Outcome.FAIL]


def test_scene_facts():
    result = quick("scene-facts")
    assert bad(result) == []
    assert result.numbers["r_c delay"].value == pytest.approx(10**-2.6995497159, rel=1e-9)
    groups = {row[0]: row[2] for row in result.tables[0].rows}
    assert groups["r/r_{c}"] == pytest.approx(1.04604, rel=1e-5)
    of_rock = [row[-1] for row in result.tables[1].rows]
    assert of_rock == pytest.approx([2e-5, 1e-6, 1e8, 1e-2, 5e6, 20.0, 2.1e-4], rel=1e-12)  # drive 1e4 V*, epsilon 5e-8
    one_transit = result.tables[1].rows[-1][3]
    assert one_transit == pytest.approx(2 * 0.03357797353158276 / (1e6 / 784.0) ** 0.5, rel=1e-12)


@pytest.mark.parametrize(("off", "outcome"), [(7e-16, Outcome.PASS), (3e-15, Outcome.FAIL)])
def test_scenes_given_in_si_are_the_same_to_rounding(off, outcome):
    paper = slipwave.read("paper")
    upper = SimpleNamespace(epsilon=paper.upper.epsilon * (1.0 + off))
    assert scene_facts._verdicts(paper, SimpleNamespace(upper=upper, transit=paper.transit))[0].outcome is outcome


def test_every_claim_of_the_paper_is_settled_or_said_to_be_left_out():
    result = held("claims")
    settled = {verdict.claim.split()[0] for verdict in result.verdicts}
    left_out = {omission.what.split(",")[0] for omission in result.omissions}
    assert {"Periods", *(f"P{n}" for n in range(1, 15))} == settled | (left_out & {"P8", "P9", "P10", "P14"})


def test_timed_run_knows_its_error():
    exact = {"period": 73.4721449443, "stress_drop": 0.1739634131}
    point = time_run(Setting("fd", cells=32, cfl=1.0), slipwave.read("paper"), 2500.0, exact, repeats=1)
    assert point.period_error == pytest.approx(-8.0e-6, rel=0.02)
    assert point.seconds > 0.0
    assert Setting("fd", cells=32, cfl=0.5).words == "32 cells, CFL 0.5"
    assert Setting("delay", tolerance=1e-5).words == "tolerance 10^{-5}"


def test_the_time_of_a_run_is_the_least_of_its_repetitions(monkeypatch):
    spent = iter([3.0, 1.0, 2.0, 5.0, 4.0])
    monkeypatch.setattr("validation.timing.timed", lambda work: (next(spent), work()))
    fast = slipwave.read("paper", ["drive.velocity=2000"])
    assert time_run(Setting("block8"), fast, 60.0, {"period": 4.0, "stress_drop": 0.1}).seconds == 1.0
    assert time_final(Setting("block8"), fast, 5.0, repeats=2)[0] == 4.0


def test_cheapest_point_within_an_error():
    points = [
        TimedRun(Setting("a"), 3.0, 1.0, 1e-9, 0.0),
        TimedRun(Setting("b"), 1.0, 1.0, 1e-3, 0.0),
        TimedRun(Setting("c"), 2.0, 1.0, -1e-8, 0.0),
    ]
    assert cheapest(points, 1e-7).setting.model == "c"
    assert cheapest(points, 1e-10) is None


def test_a_report_of_one_study_is_whole(tmp_path):
    html = make_report(tmp_path, quick=True, only=["scene-facts"]).read_text()
    assert html.count('class="study"') == 1
    assert "did not finish" not in html
