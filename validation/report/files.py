"""The accompanying files of the page: report.json, junit.xml for continuous integration, badge.svg, and every table as CSV."""

import csv
import html
import io
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from xml.etree import ElementTree as xml

from slipwave.files import whole_or_absent
from validation.report import Cell, Outcome
from validation.report.baseline import line_of
from validation.report.record import NAME, Change, Record, Word, text_of
from validation.report.text import bare

_CONTROL = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""Characters that XML cannot hold."""
_GREEN, _RED, _GREY = "#2e7d32", "#b3261e", "#5f6368"
_LETTER = 6.6  # width of a letter of the badge


def write_files(out: Path, report: Record, red: tuple[Word, ...], patch: str) -> None:
    """Write every accompanying file of out/index.html, each whole or not at all. `red`: words of changes that make a report red;
    an empty `patch` removes an old one."""
    texts = {table.csv: _text_of_rows(table.sheet) for table in report.tables}
    for table, records in ((one.csv, [*one.table.records()]) for one in report.model_tables):
        texts[table] = _text_of_rows([*records[:1], *(record.values() for record in records)])
    texts |= {"junit.xml": _junit_of(report, red), "badge.svg": _badge_of(report, red), NAME: text_of(report)}
    if patch:
        texts["baseline.patch"] = patch
    else:
        (out / "baseline.patch").unlink(missing_ok=True)
    for name, text in texts.items():
        path = out / name
        path.parent.mkdir(parents=True, exist_ok=True)
        with whole_or_absent(path) as temporary:
            temporary.write_text(text, encoding="utf-8", newline="\n")


def _text_of_rows(rows: Iterable[Iterable[Cell]]) -> str:
    stream = io.StringIO()
    csv.writer(stream, lineterminator="\n").writerows(rows)
    return stream.getvalue()


def _junit_of(report: Record, red: tuple[Word, ...]) -> str:
    """A suite for each study, with every case of every verdict and every number that was compared. A finding is no failure."""
    root = xml.Element("testsuites", name="slipwave report")
    for study in report.studies:
        suite = xml.SubElement(root, "testsuite", name=study.name, time=f"{report.times.seconds[study.name]:.3f}")
        if study.error:
            xml.SubElement(_case(suite, study.name, "ends"), "error", message=_legal(study.error))
        for row in (row for verdict in report.verdicts if verdict.study == study.name for row in verdict.rows):
            case = _case(suite, study.name, row.id.removeprefix(f"{study.name}."))
            said = _legal(row.line)
            if row.outcome is Outcome.FAIL:
                xml.SubElement(case, "failure", message=said)
            xml.SubElement(case, "system-out").text = f"{row.outcome}: {said}"
        for name, change in _compared(report, study.name):
            case = _case(suite, study.name, f"number {_legal(name)}")
            if change and change.word in red:
                xml.SubElement(case, "failure", message=_legal(line_of(change)))
        suite.set("tests", str(len(suite)))
        for tag, name in (("failure", "failures"), ("error", "errors")):
            suite.set(name, str(len(suite.findall(f"testcase/{tag}"))))
    xml.indent(root)
    return '<?xml version="1.0" encoding="utf-8"?>\n' + xml.tostring(root, encoding="unicode") + "\n"


def _case(suite: xml.Element, study: str, name: str) -> xml.Element:
    return xml.SubElement(suite, "testcase", classname=f"slipwave.{study}", name=name)


def _compared(report: Record, study: str) -> Iterator[tuple[str, Change | None]]:
    """Every number of a study with its change, if any, and those that are gone; and verdicts that got better or worse."""
    changes = {change.id: change for change in report.changes.listed if change.study == study}
    for number in report.numbers:
        if number.study == study:
            yield number.name, changes.pop(number.id, None)
    yield from ((change.name, change) for change in changes.values() if change.word is not Word.NEW)


def _legal(words: str) -> str:
    return _CONTROL.sub("?", bare(words))


def _badge_of(report: Record, red: tuple[Word, ...]) -> str:
    """The outcomes as a badge (SVG): green only if something holds and nothing is red."""
    count = report.outcomes
    bad = count["fail"] + count["broken"] + len(report.changes.of(*red))
    parts = [f"{count['pass']} hold", f"{count['finding']} findings" if count["finding"] else "", f"{bad} red" if bad else ""]
    words = ("quick: " if report.quick else "") + ", ".join(filter(None, parts))
    colour = _RED if bad else _GREEN if count["pass"] else _GREY
    left, right = (round(_LETTER * len(text) + 12) for text in ("slipwave", words))
    texts = "".join(
        f'<text x="{x + 6}" y="14" textLength="{width - 12}">{html.escape(text)}</text>'
        for x, width, text in ((0, left, "slipwave"), (left, right, words))
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{left + right}" height="20" role="img" aria-label="slipwave: {words}">'
        f'<title>slipwave: {words}</title><rect width="{left}" height="20" fill="{_GREY}"/>'
        f'<rect x="{left}" width="{right}" height="20" fill="{colour}"/>'
        f'<g fill="#fff" font-family="Verdana, DejaVu Sans, sans-serif" font-size="11">{texts}</g></svg>\n'
    )
