"""The report's machinery on synthetic studies: stored whole, recomputed only on a change, failures shown, page whole."""

import json
import math
import re
import sys
import types
from html.parser import HTMLParser

import pytest

from scene.errors import NumericsError, SceneError
from validation import studies
from validation.report import baseline, make_report, sources, store
from validation.report.drawing import canvas
from validation.studies import load
from validation.study import Budget, Column, Evidence, Figure, Number, Omission, Outcome, StudyResult, Table, Verdict


def draw():
    figure = canvas(height=2.0)
    figure.add_subplot().plot([0, 1], [0, 1])
    return figure


def result():
    return StudyResult(
        answer="One <mode> is 6 · 10^{-4} off.",
        tables=(
            Table(
                "t", "Periods *T*.", (Column("model"), Column("T", "transits", ".8g")), (("delay", 73.4721449), ("x", math.nan))
            ),
        ),
        figures=(Figure("overlay", "One cycle.", draw, lead=True),),
        verdicts=(
            Verdict("T is right", Evidence.WITNESS, "73.47", "73.48", Outcome.PASS),
            Verdict("T is right", Evidence.PAPER, "73.5", "80", Outcome.FINDING),
            Verdict("T is right", Evidence.PAPER, "73.5", "73.5", Outcome.PASS),
        ),
        notes=("Clock: transits.",),
        numbers={"T": Number(73.4721449, 1e-6), "void": Number(math.nan)},
        omissions=(Omission("P8", "needs continuation"),),
    )


class Fake:
    """Registers studies for one test and counts how often each runs."""

    def __init__(self, monkeypatch, tmp_path):
        self.patch, self.folder, self.runs = monkeypatch, tmp_path / "sources", []
        self.folder.mkdir()
        monkeypatch.setattr(studies, "STUDIES", {})

    def add(self, name, run=lambda budget: result()):
        module = types.ModuleType(f"validation.studies.{name}")
        source = self.folder / f"{name}.py"
        source.write_text(f"# {name}")
        module.NAME, module.QUESTION, module.SCENES, module.SECONDS = name, f"Does {name} work?", (), (1.0, 1.0)
        module.__file__ = str(source)

        def counted(budget):
            self.runs.append(name)
            return run(budget)

        module.run = counted
        self.patch.setitem(sys.modules, module.__name__, module)
        studies.STUDIES[name] = name
        return module


@pytest.fixture
def fake(monkeypatch, tmp_path):
    return Fake(monkeypatch, tmp_path)


def test_page_is_one_file_without_scripts_or_addresses(fake, tmp_path):
    fake.add("first")
    page = make_report(tmp_path / "out", quick=True)
    html = page.read_text()
    assert "<script" not in html
    assert "http" not in re.sub(r"base64,[A-Za-z0-9+/=]+", "", html)
    assert "One &lt;mode&gt; is 6\u202f·\u202f10<sup>−4</sup> off." in html
    assert "73.472145" in html
    HTMLParser().feed(html)
    assert sorted(path.name for path in page.parent.iterdir()) == ["data", "index.html"]
    assert sorted(path.name for path in (page.parent / "data/first").iterdir()) == ["overlay.png", "overlay.svg", "result.json"]


def test_every_anchor_is_unique(fake, tmp_path):
    fake.add("first")
    fake.add("second")  # whose tables have the same names
    anchors = re.findall(r'\bid="([^"]*)"', make_report(tmp_path).read_text())
    assert len(anchors) == len(set(anchors)) > 4


def test_every_tag_is_closed(fake, tmp_path):
    fake.add("first")
    stack = []

    class Balance(HTMLParser):
        def handle_starttag(self, tag, attrs):
            if tag not in ("meta", "img", "br", "!doctype"):
                stack.append(tag)

        def handle_endtag(self, tag):
            assert stack.pop() == tag

    Balance().feed(make_report(tmp_path).read_text())
    assert stack == []


def test_matrix_shows_the_worst_outcome_of_each_kind_of_evidence(fake, tmp_path):
    fake.add("first")
    rows = re.findall(r"<tr><td class=\"t\">T is right</td>(.*?)</tr>", make_report(tmp_path).read_text())
    assert re.findall(r"light (\w+)", rows[0]) == ["pass", "finding"]


def test_only_what_changed_is_computed_again(fake, tmp_path):
    module = fake.add("first")
    fake.add("second")
    make_report(tmp_path)
    make_report(tmp_path)
    assert fake.runs == ["first", "second"]
    with open(module.__file__, "a") as source:
        source.write("\n# edited")
    make_report(tmp_path)
    assert fake.runs == ["first", "second", "first"]
    make_report(tmp_path, quick=True)
    assert fake.runs[3:] == ["first", "second"]


def test_key_follows_the_solver_sources_and_the_scenes(fake, monkeypatch, tmp_path):
    module = fake.add("first")
    before = store.study_key(module, False)
    monkeypatch.setattr(store, "source_digest", lambda: "other")
    assert store.study_key(module, False) != before
    monkeypatch.undo()
    monkeypatch.setattr(sources, "_GALLERY", tmp_path)
    module.SCENES = ("paper",)
    (tmp_path / "paper.toml").write_text("[drive]\nvelocity = 100.0\n")
    before = store.study_key(module, False)
    (tmp_path / "paper.toml").write_text("[drive]\nvelocity = 101.0\n")
    assert store.study_key(module, False) != before


def test_key_follows_every_file_that_a_study_imports():
    """Also those whose names do not begin with the study's own."""
    names = {path.name for path in sources.sources_of(load("stability-attacks"))}
    assert {"stability_attacks.py", "attack_runs.py", "models.py", "study.py", "paper.toml"} <= names
    assert not {"energy.py", "cli.py", "page.py"} & names


def test_key_follows_the_files_that_a_study_reads(fake, tmp_path):
    module = fake.add("first")
    module.FILES = (tmp_path,)
    (tmp_path / "a.py").write_text("x = 1")
    before = store.study_key(module, False)
    (tmp_path / "a.py").write_text("x = 2")
    assert store.study_key(module, False) != before


def test_stored_result_comes_back_as_it_was(fake, tmp_path):
    module = fake.add("first")
    saved = store.save(tmp_path, module, "key", result(), 1.5)
    read = store.load(tmp_path, module, "key")
    assert read.result.tables[0].rows[0] == ("delay", 73.4721449)
    assert math.isnan(read.result.tables[0].rows[1][1])
    assert repr(read.result) == repr(saved.result)
    assert read.result.verdicts == result().verdicts
    assert read.result.omissions == result().omissions
    assert (read.fresh, saved.fresh) == (False, True)
    assert store.load(tmp_path, module, "another key") is None


@pytest.mark.parametrize("damage", ["overlay.svg", "result.json"])
def test_damaged_result_counts_as_absent(fake, tmp_path, damage):
    fake.add("first")
    make_report(tmp_path)
    path = tmp_path / "data/first" / damage
    path.unlink() if damage.endswith("svg") else path.write_text(path.read_text()[:100])
    make_report(tmp_path)
    assert fake.runs == ["first", "first"]


def test_interrupted_report_resumes(fake, tmp_path):
    fake.add("first")
    interrupted = []

    def run(budget):
        if not interrupted:
            interrupted.append(True)
            raise KeyboardInterrupt
        return result()

    fake.add("second", run)
    with pytest.raises(KeyboardInterrupt):
        make_report(tmp_path)
    assert not (tmp_path / "index.html").exists()
    make_report(tmp_path)
    assert fake.runs == ["first", "second", "second"]


def test_failed_drawing_leaves_nothing_half_written(fake, tmp_path):
    module = fake.add("first")
    broken = StudyResult("", figures=(Figure("a", "", draw), Figure("b", "", lambda: 1 / 0)))
    with pytest.raises(ZeroDivisionError):
        store.save(tmp_path, module, "key", broken, 1.0)
    assert list(tmp_path.glob("**/*.svg")) == []
    assert not (tmp_path / "first").exists()


def test_failed_study_is_shown_and_the_rest_goes_on(fake, tmp_path):
    fake.add("first", lambda budget: 1 / 0)
    fake.add("second")
    with pytest.raises(NumericsError, match="first: failed"):
        make_report(tmp_path)
    html = (tmp_path / "index.html").read_text()
    assert "This study did not finish" in html
    assert "ZeroDivisionError: division by zero" in html
    assert "Does second work?" in html
    assert fake.runs == ["first", "second"]


def test_only_runs_what_was_named_and_shows_what_is_stored(fake, tmp_path):
    fake.add("first")
    fake.add("second")
    fake.add("third")
    make_report(tmp_path, only=["first"])
    html = make_report(tmp_path, only=["second"]).read_text()
    assert fake.runs == ["first", "second"]
    assert "Does first work?" in html
    assert "Does third work?" not in html
    with pytest.raises(SceneError, match="'forth': no such study; choose from first, second, third"):
        make_report(tmp_path, only=["forth"])


def test_baseline_tells_what_moved(fake, tmp_path, monkeypatch):
    values = [73.0]
    fake.add("first", lambda budget: StudyResult("", numbers={"T": Number(values[0], 1e-6)}))
    monkeypatch.setattr(baseline.compare, "__defaults__", (tmp_path / "baseline",))
    assert "No baseline" in make_report(tmp_path / "out").read_text()
    written = baseline.take(tmp_path / "out", tmp_path / "baseline")
    assert json.loads(written[0].read_text()) == {"T": {"value": 73.0, "tolerance": 1e-6}}
    assert "All 1 numbers of first are within" in make_report(tmp_path / "out").read_text()
    values[0] = 73.001
    html = make_report(tmp_path / "other").read_text()
    assert '<td class="n">73</td><td class="n">73.001</td>' in html


def test_what_a_quick_report_leaves_out_is_no_change(fake, tmp_path, monkeypatch):
    numbers = {"T": Number(73.0), "order": Number(2.0)}
    fake.add("first", lambda budget: StudyResult("", numbers=dict(list(numbers.items())[: 1 if budget.quick else 2])))
    monkeypatch.setattr(baseline.compare, "__defaults__", (tmp_path / "baseline",))
    make_report(tmp_path / "full")
    baseline.take(tmp_path / "full", tmp_path / "baseline")
    assert "All 1 numbers of first are within" in make_report(tmp_path / "quick", quick=True).read_text()
    del numbers["order"]
    assert "All" not in make_report(tmp_path / "again").read_text().partition("Since the baseline")[2].partition("<h2>")[0]


def test_progress_reaches_the_study(fake, tmp_path):
    seen = []

    def run(budget: Budget):
        budget.report(0.5)
        seen.append(budget.quick)
        return result()

    fake.add("first", run)
    make_report(tmp_path, quick=True)
    assert seen == [True]
