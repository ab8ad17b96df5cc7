"""The report's machinery on synthetic studies: stored whole, recomputed only on a change, side by side, words and tables."""

import fcntl
import json
import math
import os
import re
import signal
import subprocess
import sys
import time
from dataclasses import replace
from functools import partial
from html.parser import HTMLParser

import pytest
from fake_studies import answered, result
from test_page import models

from slipwave.errors import SceneError
from validation.commands.cli import main
from validation.report import StudyResult, questions, registered, table
from validation.report.baseline import RedReport
from validation.report.build import make_report, store
from validation.report.model_table import Compared, ModelCell
from validation.report.names import by_claim
from validation.report.text import number


class Tags(HTMLParser):
    def __init__(self):
        super().__init__()
        self.open = []

    def handle_starttag(self, tag, attrs):
        self.open += [] if tag in ("meta", "img", "br", "input") else [tag]

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def test_page_is_one_file_without_outer_addresses(fake, tmp_path):
    fake.add("first")
    html, tags = make_report(tmp_path / "out", quick=True).read_text(), Tags()
    assert "http" not in html
    assert "One &lt;mode&gt; is 6\u202f·\u202f10<sup>−4</sup> off." in html
    assert "73.472145" in html
    tags.feed(html)
    assert tags.open == []


def test_only_what_changed_is_computed_again(fake, tmp_path):
    module = fake.add("first")
    fake.add("second")
    make_report(tmp_path)
    make_report(tmp_path)
    assert fake.runs == ["first", "second"]
    fake.edit(module, "\n# a comment")
    make_report(tmp_path)
    assert fake.runs == ["first", "second"]
    fake.edit(module, "\nedited = True")
    make_report(tmp_path)
    assert fake.runs == ["first", "second", "first"]
    make_report(tmp_path, quick=True)
    assert fake.runs[3:] == ["first", "second"]


def test_stored_result_comes_back_as_it_was(fake, tmp_path):
    module = fake.add("first")
    given = replace(result(), model_tables=(models(),))
    saved = store.store_result(tmp_path, module, "key", given, 1.5)
    read = store.stored_result(tmp_path, module, "key")
    assert repr(read.result) == repr(saved.result)
    tables = [replace(one, id=f"first.{one.name}", study="first", csv=f"data/first/table-{one.name}.csv") for one in given.tables]
    numbers = {name: replace(one, id=f"first.{name}", study="first", name=name) for name, one in given.numbers.items()}
    named = {"verdicts": by_claim("first", given.verdicts), "tables": tuple(tables), "numbers": numbers}
    assert repr(read.result) == repr(replace(given, figures=(), **named))
    assert (read.fresh, saved.fresh) == (False, True)
    assert store.stored_result(tmp_path, module, "another key") is None


@pytest.mark.parametrize("damage", ["overlay.svg", "overlay.png", "overlay.csv", "result.json"])
def test_damaged_result_is_computed_again(fake, tmp_path, damage):
    fake.add("first")
    make_report(tmp_path)
    path = tmp_path / "data/first" / damage
    whole = path.read_bytes()
    for times, damaged in enumerate((None, whole[: len(whole) // 2], whole[:-20] + b"\0" + whole[-19:])):
        path.unlink() if damaged is None else path.write_bytes(damaged)
        make_report(tmp_path)
        assert fake.runs == ["first"] * (times + 2)


def test_a_second_report_into_a_folder_is_refused_while_the_first_is_made(fake, tmp_path):
    told = []

    def run(budget):
        if not told:
            told.append("let in")
            with pytest.raises(SceneError) as refused:
                make_report(tmp_path / "out")
            told[0] = str(refused.value)
        return result()

    fake.add("first", run)
    make_report(tmp_path / "out")
    reason = "another process writes to this folder now; wait for its end, or name another folder"
    assert told == [f"--out = {str(tmp_path / 'out')!r}: {reason}"]
    assert answers(make_report(tmp_path / "out")) == [result().headline]


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


@pytest.mark.parametrize(
    ("value", "spec", "html"),
    [
        (73.47214494, ".9g", "73.4721449"),
        (-0.0373, ".1%", "−3.7%"),
        (1.23e-9, ".2e", "1.23\u202f·\u202f10<sup>−9</sup>"),
        (math.nan, ".3g", "–"),
        (-math.inf, ".3g", "−∞"),
    ],
)
def test_numbers(value, spec, html):
    assert number(value, spec) == html


def model_cell(value, error, standard_error=1e-9, right=True):
    return ModelCell("periodic", right, 0, {"T": Compared(value, error, standard_error)})


@pytest.mark.parametrize(
    ("shown", "words", "shade"),
    [
        (model_cell(73.47214, None), "73.472", ""),
        (model_cell(70.0, -0.0373), "−3.7 %", "amber"),
        (model_cell(73.5, 9.99e-4), "+1 · 10^{−3}", "none"),
        (model_cell(94.0, -0.0011, 0.0035), "−0.1 ± 0.7 %", "pale"),
        (model_cell(94.0, -0.028, 0.06), "−2.8 ± 12.0 %", "open"),
        (model_cell(7e6, 616.0, 480.0), "6 · 10^{2} times", "red"),
        (model_cell(94.031, None, 0.0055), "94.0 ± 1.0", ""),
        (model_cell(60.0, -0.45, right=False), "−45.0 %", "wrong"),
        (ModelCell("runs away", False), "runs away", "wrong"),
    ],
)
def test_what_a_cell_says(shown, words, shade):
    assert (shown.words("T"), shown.shade("T")) == (words, shade)


TOGETHER = """
    import time
    (HERE / f"{NAME}.begun").touch()
    budget.report(0.5)
    while len(list(HERE.glob("*.begun"))) < 2:
        time.sleep(0.01)
    (HERE / f"{NAME}.done").touch()
    return StudyResult({str(os.getpid()): ()})
"""
ALONE = """
    done = sorted(path.stem for path in HERE.glob("*.done"))
    return StudyResult({f"{os.getpid()} after {', '.join(done)}": ()})
"""
PATIENCE = 600.0
"""Seconds after which a test gives up; no outcome depends on it."""


def answers(page):
    studies = json.loads((page.parent / "report.json").read_text())["studies"]
    return [study["answer"] for study in studies if not study["error"]]


def test_studies_run_together_and_those_that_time_alone_at_the_end(fake, tmp_path, capfd):
    """The first two each wait for the other to begin: one after the other, they would never end."""
    fake.write("timing", ALONE, timed=True)
    fake.write("first", TOGETHER)
    fake.write("second", TOGETHER)
    timing, first, second = answers(make_report(tmp_path / "out", processes=2))
    assert timing == f"{os.getpid()} after first, second"
    assert len({first, second, str(os.getpid())}) == 3
    lines = capfd.readouterr().err.splitlines()
    assert sorted(line.split()[0] for line in lines[:2]) == ["first", "second"]
    assert lines[2].split()[0] == "timing"


NAMED = """from typing import NamedTuple
from slipwave.friction import LAWS, register

class Mine(NamedTuple):
    a_star: float = 0.369
    a: float = 0.0349
    b: float = 0.0489

register("as-aged", Mine, LAWS["ageing"].respond)
"""


def test_studies_that_name_an_own_law_have_it_in_any_process_and_are_computed_again_when_it_changes(fake, tmp_path, capsys):
    law, out = tmp_path / "law.py", tmp_path / "out"
    for name in ("first", "second"):
        fake.write(
            name,
            'import slipwave\nreturn StudyResult({type(slipwave.read("paper", ["interface.law=as-aged"]).law).__name__[:4]: ()})',
        )
    fake.write("third", 'return StudyResult({"none": ()})')
    for text, kept in ((NAMED, []), (NAMED, ["first", "second", "third"]), (NAMED + "# edited", ["third"])):
        law.write_text(text)
        assert main(["report", "--out", str(out), "--law", str(law)]) == 0
        assert answers(out / "index.html") == ["Mine", "Mine", "none"]
        assert sorted(line.split()[0] for line in capsys.readouterr().err.splitlines() if line.endswith("stored")) == kept


def test_a_process_that_dies_is_a_study_that_failed(fake, tmp_path):
    fake.write("first", "os._exit(9)")
    fake.write("second", "os._exit(9)")
    fake.write("timing", ALONE, timed=True)
    with pytest.raises(RedReport) as red:
        make_report(tmp_path / "out", processes=2)
    died = "failed: a process of the report died, killed or short of memory, before this study was done"
    assert red.value.lines == [f"first: {died}", f"second: {died}"]
    assert answers(red.value.page) == [f"{os.getpid()} after "]


@pytest.mark.parametrize(
    ("run", "why"),
    [
        (lambda: StudyResult({}), "ValueError: the study answers nothing"),
        (lambda: answered(tables=(table("t", "", "a | b", [(1,)]),)), r"the table 't' of 2 columns has the row \(1,\)"),
        (lambda: answered(tables=(table("t", "", "a", [(1, 2)]),)), r"the table 't' of 1 columns has the row \(1, 2\)"),
        (lambda: answered(tables=(table("t", "", "a", []),) * 2), "several tables have the name 't'"),
        (lambda: answered(figures=result().figures * 2), "several figures have the name 'overlay'"),
        (
            lambda: answered(tables=(table("../../t", "", "a", []),)),
            r"tables are files, and none can have the name '\.\./\.\./t'",
        ),
        (sys.exit, "SystemExit:"),
    ],
)
def test_a_result_that_no_page_can_show_is_a_study_that_failed(fake, tmp_path, run, why):
    """Before, no page was written, of any study; of two tables of one name the file of one was lost; the exit status was 0."""
    fake.add("first", lambda budget: run())
    fake.add("second")
    with pytest.raises(RedReport) as red:
        make_report(tmp_path / "out")
    (line,) = red.value.lines
    assert re.match(f"first: failed: .*{why}", line)
    assert answers(red.value.page) == [result().headline]


@pytest.mark.parametrize(
    ("fact", "value", "told"),
    [
        ("NAME", "other", "NAME = 'other': must be 'first'"),
        ("NAME", "second", "NAME = 'second': must be 'first'"),
        ("QUESTION", None, "QUESTION = None: must be a text"),
        ("SCENES", "paper", "SCENES = 'paper': must be a tuple of names of the gallery"),
        ("SCENES", ("papper",), r"SCENES = \('papper',\): must be a tuple of names of the gallery"),
        ("SECONDS", 1.0, r"SECONDS = 1.0: must be \(quick, full\), two numbers"),
        ("run", None, "run = None: must be a function"),
    ],
)
def test_a_study_of_other_facts_is_refused_before_any_is_computed(fake, tmp_path, fact, value, told):
    """Before, KeyError or AttributeError; of two studies of one name, the result of one stood for both."""
    setattr(fake.add("first"), fact, value)
    fake.add("second")
    with pytest.raises(SceneError, match=f"^study 'first': {told}$"):
        make_report(tmp_path / "out")
    assert fake.runs == []


def test_a_study_that_cannot_be_imported_is_named(fake, tmp_path):
    """Before, a traceback, with exit status 1."""
    registered.STUDIES["absent"] = "absent"
    with pytest.raises(SceneError, match=r"^study 'absent': cannot be imported: ModuleNotFoundError: No module named 'valid.*"):
        make_report(tmp_path / "out")


def test_a_study_whose_line_names_no_question_stands_with_the_checks(monkeypatch):
    """Before, it stood nowhere on the page."""
    monkeypatch.setitem(questions.STUDIES, "mine", "trsut")
    studies = [store.StoredStudy(name, "Why?", 0.0, True, result()) for name in ("mine", "orders")]
    shown = {asked["name"]: [study.name for study in asked["studies"]] for asked in questions.ask(studies, "")}
    assert shown == {key: [] for key in questions.QUESTIONS} | {"exact": ["orders"], "trust": ["mine"]}


PROGRAM = """
import sys
from types import ModuleType
from validation.report import registered
from validation.report import build
from validation.commands.cli import main
from validation.models import progress

progress.PATIENCE = float("inf")
folder, *words = sys.argv[1:]
sys.path.insert(0, folder)
registered.STUDIES.clear()
for name in ("quick", "endless"):
    sys.modules[f"validation.studies.{name}"] = __import__(f"written_{name}")
    registered.STUDIES[name] = name
build.cores = lambda: 2
if __name__ == "__main__":
    sys.exit(main(words))
"""
ENDLESS = """
    import fcntl, subprocess, time
    if (HERE / "freed").exists():
        return StudyResult({"at last": ()})
    lock = open(HERE / "lock", "w")
    fcntl.flock(lock, fcntl.LOCK_EX)
    with subprocess.Popen(["sleep", "100000"], pass_fds=(lock.fileno(),)):
        (HERE / "begun").touch()
        time.sleep(100000)
"""


def wait_for(condition):
    began = time.monotonic()
    while not condition():
        assert time.monotonic() - began < PATIENCE
        time.sleep(0.05)


def is_free(path):
    """Whether nobody holds this file any more: neither the study's process nor the one that it started."""
    with path.open("w") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
    return True


@pytest.mark.parametrize("end", [signal.SIGINT, signal.SIGKILL])
def test_ctrl_c_ends_all_processes_and_the_report_resumes(fake, tmp_path, end):
    """With one line, and all that was done is kept. Nor does anything survive the report's own violent death."""
    fake.write("quick", 'return StudyResult({"done": ()})')
    fake.write("endless", ENDLESS)
    program = tmp_path / "program.py"
    program.write_text(PROGRAM)
    words = [sys.executable, str(program), str(fake.folder), "report", "--out", str(tmp_path / "out")]
    stored = tmp_path / "out" / "data" / "quick" / "result.json"
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    heard = partial(signal.signal, signal.SIGINT, signal.SIG_DFL)  # whoever runs the tests may have it ignored
    with subprocess.Popen(words, **pipes, start_new_session=True, preexec_fn=heard) as process:
        wait_for(lambda: (fake.folder / "begun").exists() and stored.exists())
        os.killpg(process.pid, end)
        said = process.communicate()
    wait_for(lambda: is_free(fake.folder / "lock"))
    if end is signal.SIGINT:
        assert process.returncode == 130
        assert said[0] == ""
        *told, last = said[1].splitlines()
        assert [line.split()[0] for line in told] in ([], ["quick"])  # stored, but perhaps not yet told
        kept = tmp_path / "out" / "data"
        assert last == f"slipwave: interrupted; finished studies are kept in {kept}, and the same command goes on from there"
    assert not (tmp_path / "out" / "index.html").exists()
    (fake.folder / "freed").touch()
    again = subprocess.run(words, capture_output=True, text=True, check=True)
    assert again.stderr.splitlines()[0].split() == ["quick", "stored"]
    assert answers(tmp_path / "out" / "index.html") == ["done", "at last"]
