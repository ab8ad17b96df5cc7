"""The whole page, unfolded, without a browser: how much there is to read, and where its links lead."""

import json
import os
import re
from html.parser import HTMLParser

import pytest

from tests.page.conftest import FOLDER

VOID, UNREAD = {"meta", "img", "br", "input", "link"}, {"script", "style", "head", "svg"}


class Words(HTMLParser):
    """Counts words in cells of tables and all others, but those of scripts and pictures; keeps names, links, and text with markup
    for indices that nothing has set."""

    def __init__(self, page):
        super().__init__()
        self.open, self.names, self.links, self.unset, self.cells, self.text = [], [], [], [], 0, 0
        self.feed(page)

    def handle_starttag(self, tag, attrs):
        self.open += [] if tag in VOID else [tag]
        self.names += [value for key, value in attrs if key == "id"]
        self.links += [value for key, value in attrs if key == "href" and tag == "a"]

    def handle_endtag(self, tag):
        while tag in self.open and self.open.pop() != tag:
            pass

    def handle_data(self, data):
        if not UNREAD & {*self.open}:
            self.cells += len(data.split()) * ("table" in self.open)
            self.text += len(data.split()) * ("table" not in self.open)
            self.unset += [data] if re.search(r"[_^]\{", data) else []


@pytest.fixture(scope="module")
def page():
    if "REPORT" not in os.environ or not (FOLDER / "index.html").exists():
        pytest.skip("no report is named: `make page` reads the last one")
    return (FOLDER / "index.html").read_text(encoding="utf-8")


def test_a_report_is_short(page):
    words = Words(page)
    assert words.text <= 9_000
    assert words.cells <= 20_000
    assert len(page.encode()) <= 2_000_000


def test_no_link_is_broken(page):
    found = Words(page)
    assert len(found.names) == len(set(found.names))
    assert [link for link in found.links if link[0] == "#" and link[1:] not in found.names] == []
    assert [link for link in found.links if link[0] != "#" and not (FOLDER / link).is_file()] == []


def test_indices_are_set(page):
    assert Words(page).unset == []


def test_every_verdict_is_cited(page):
    report = json.loads((FOLDER / "report.json").read_text(encoding="utf-8"))
    cited = {name for answer in report["answers"] for name in answer["verdicts"]}
    assert [verdict["id"] for verdict in report["verdicts"] if verdict["id"] not in cited] == []
    assert [name for name in cited if f'href="#{name}"' not in page] == []
