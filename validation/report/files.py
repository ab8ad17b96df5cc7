"""The accompanying files of the page: report.json, junit.xml for continuous integration, badge.svg, and every table as CSV."""

import csv
import io
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from xml.sax.saxutils import escape

from slipwave.files import whole_or_absent
from validation.report import Cell, Outcome
from validation.report.baseline import line_of
from validation.report.record import NAME, Record, StudyRecord, Word, text_of
from validation.report.text import bare, templates

_CONTROL = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""Characters that XML cannot hold."""
_ENTITIES = {'"': "&quot;", "\t": "&#09;", "\n": "&#10;", "\r": "&#13;"}


def write_files(out: Path, report: Record, red: tuple[Word, ...], patch: str) -> None:
    """Write every accompanying file of out/index.html, each whole or not at all. `red`: words of changes that make a report red;
    an empty `patch` removes an old one."""
    from markupsafe import Markup

    texts = {table.csv: _text_of_rows(table.sheet) for table in report.tables}
    for table, records in ((stored.csv, [*stored.table.records()]) for stored in report.model_tables):
        texts[table] = _text_of_rows([*records[:1], *(record.values() for record in records)])
    environment = templates()
    environment.filters["legal"] = lambda words: Markup(escape(_CONTROL.sub("?", bare(words)), _ENTITIES))
    told = {"report": report, "red": red, "suites": [(study, [*_cases(report, study, red)]) for study in report.studies]}
    texts |= {name: environment.get_template(f"{name}.j2").render(told) for name in ("junit.xml", "badge.svg")}
    texts |= {NAME: text_of(report)} | ({"baseline.patch": patch} if patch else {})
    if not patch:
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


def _cases(report: Record, study: StudyRecord, red: tuple[Word, ...]) -> Iterator[tuple[str, str, str, str]]:
    """(name, kind of fault, what is said, outcome) of a study's error, of every case of its verdicts, of its numbers, those that
    are gone too, and of verdicts that got better or worse. A finding is no failure."""
    if study.error:
        yield "ends", "error", study.error, ""
    for row in (row for verdict in report.verdicts if verdict.study == study.name for row in verdict.rows):
        yield row.id.removeprefix(f"{study.name}."), "failure" * (row.outcome is Outcome.FAIL), row.line, row.outcome
    changes = {change.id: change for change in report.changes.listed if change.study == study.name}
    names = {number.id: number.name for number in report.numbers if number.study == study.name}
    names |= {change.id: change.name for change in changes.values() if change.word is not Word.NEW}
    for place, name in names.items():
        change = changes.get(place)
        failed = change is not None and change.word in red
        yield f"number {name}", "failure" * failed, line_of(change) if change else "", ""
