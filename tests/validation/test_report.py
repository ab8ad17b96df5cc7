"""The report's machinery on synthetic studies: stored whole, recomputed only on a change, failures shown, page whole."""

import math
import os
import re
import subprocess
from html.parser import HTMLParser

import pytest
from fake_studies import draw, result

from slipwave.errors import SceneError
from validation.report.build import make_report, store
from validation.study import Figure, StudyResult
from validation.study.names import with_names


class Tags(HTMLParser):
    """The anchors of a page, and its tags that are still open."""

    def __init__(self):
        super().__init__()
        self.anchors, self.open = [], []

    def handle_starttag(self, tag, attrs):
        self.anchors += [value for name, value in attrs if name == "id"]
        self.open += [] if tag in ("meta", "img", "br", "input") else [tag]

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def test_page_is_one_file_without_outer_addresses(fake, tmp_path):
    fake.add("first")
    fake.add("second")  # whose tables have the same names
    page = make_report(tmp_path / "out", quick=True)
    html, tags = page.read_text(), Tags()
    assert "http" not in html
    assert "One &lt;mode&gt; is 6\u202f·\u202f10<sup>−4</sup> off." in html
    assert "73.472145" in html
    tags.feed(html)
    assert tags.open == []
    assert len(tags.anchors) == len(set(tags.anchors)) > 4
    assert sorted(path.name for path in page.parent.iterdir()) == ["badge.svg", "data", "index.html", "junit.xml", "report.json"]
    beside = sorted(path.name for path in (page.parent / "data/first").iterdir())
    assert beside == ["overlay.csv", "overlay.png", "overlay.svg", "result.json", "table-t.csv"]


def test_matrix_shows_the_worst_outcome_of_each_kind_of_evidence(fake, tmp_path):
    fake.add("first")
    (row,) = re.findall(
        r'<tr><th scope="row" class="t"><a href="#first">first</a></th>(.*?)</tr>', make_report(tmp_path).read_text()
    )
    assert re.findall(r'light (\w+)".*?class="count">(\d)', row) == [("pass", "1"), ("finding", "2")]


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
    saved = store.store_result(tmp_path, module, "key", result(), 1.5)
    read = store.stored_result(tmp_path, module, "key")
    assert read.result.tables[0].rows[0] == ("delay", 73.4721449)
    assert math.isnan(read.result.tables[0].rows[1][1])
    assert repr(read.result) == repr(saved.result)
    assert read.result.verdicts == with_names("first", result().verdicts)
    assert (read.result.omissions, (read.fresh, saved.fresh)) == (result().omissions, (False, True))
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


def test_no_damage_to_a_result_goes_unnoticed(fake, tmp_path):
    """One bit flipped anywhere in it, or cut off anywhere: absent, or (white space) the same result."""
    module = fake.add("first")
    saved = store.store_result(tmp_path, module, "key", result(), 1.5)
    path = tmp_path / "first" / "result.json"
    written = path.read_bytes()
    flips = (written[:k] + bytes([written[k] ^ (1 << k % 8)]) + written[k + 1 :] for k in range(0, len(written), 3))
    cuts = (written[:k] for k in range(0, len(written), 7))
    found = []
    for damaged in (*flips, *cuts):
        path.write_bytes(damaged)
        found.append(store.stored_result(tmp_path, module, "key"))
        assert found[-1] is None or repr(found[-1].result) == repr(saved.result)
    assert len(found) > 600
    assert found.count(None) > 0.95 * len(found)


def test_what_a_killed_process_left_is_removed(fake, tmp_path):
    """But not what another one is writing now."""
    module = fake.add("first")
    with subprocess.Popen(["sleep", "100000"]) as other:
        parts = [tmp_path / f".first.{name}" for name in (other.pid, os.getpid(), "old")]
        with subprocess.Popen(["true"]) as gone:
            pass
        parts.append(tmp_path / f".first.{gone.pid}")
        for part in parts:
            part.mkdir()
        store.store_result(tmp_path, module, "key", result(), 1.0)
        other.kill()
    assert [part for part in parts if part.exists()] == [parts[0]]


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
        store.store_result(tmp_path, module, "key", broken, 1.0)
    assert list(tmp_path.glob("**/*.svg")) == []
    assert not (tmp_path / "first").exists()


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


@pytest.mark.parametrize(("quick", "order"), [(True, ["c", "a", "b", "timed"]), (False, ["b", "a", "c", "timed"])])
def test_the_longest_study_begins_first_and_those_that_time_last(fake, tmp_path, quick, order):
    """By what they say of the quick and of the full report."""
    seconds = {"a": (2.0, 2.0), "b": (1.0, 3.0), "c": (3.0, 1.0), "timed": (9.0, 9.0)}
    for name, both in seconds.items():
        study = fake.add(name)
        study.SECONDS, study.TIMED = both, name == "timed"
    make_report(tmp_path, quick=quick)
    assert fake.runs == order
