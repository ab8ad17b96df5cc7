"""The page: stored results through one template into one self-contained HTML file."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from slipwave.files import whole_or_absent
from validation.report import Evidence, Outcome, Verdict, first_screen, text
from validation.report.advice import JUDGED, advice_on
from validation.report.figures import with_figures
from validation.report.questions import ask, left_out, tally, verdicts_of
from validation.report.record import Changes, Record, Word
from validation.report.store import Stored

if TYPE_CHECKING:
    from jinja2 import Environment

_HERE = Path(__file__).parent
_FILES = {"JSON": "report.json", "JUnit": "junit.xml", "badge": "badge.svg"}
_WORST = (Outcome.FAIL, Outcome.FINDING, Outcome.PASS)


def write_page(out: Path, studies: Sequence[Stored], facts: dict[str, str], report: Record) -> Path:
    """Render out/index.html from the studies' results; the file appears whole or not at all."""
    from markupsafe import Markup

    said = _said(report.changes)
    page = (
        _templates(studies, out)
        .get_template("page.html.j2")
        .render(
            css=Markup((_HERE / "page.css").read_text(encoding="utf-8")),
            script=Markup((_HERE / "page.js").read_text(encoding="utf-8")),
            facts=facts,
            files=_FILES,
            quick=report.quick,
            written=report.times.written,
            models=first_screen.models_of(studies),
            questions=ask(studies, said),
            findings=[verdict for verdict in verdicts_of(studies) if verdict.outcome is Outcome.FINDING],
            failures=[verdict for verdict in verdicts_of(studies) if verdict.outcome is Outcome.FAIL],
            evidence=tuple(Evidence),
            matrix=matrix(studies),
            tally=report.outcomes,
            leads=[(study, picture) for study in studies for picture in study.pictures if picture.lead],
            omissions=left_out(studies),
            csv={one.id: one.csv for one in report.model_tables},
            changes=report.changes,
            said=said,
            studies=studies,
            before=report.times.before,
            wall=sum(study.wall_seconds for study in studies),
        )
    )
    with whole_or_absent(out / "index.html") as temporary:
        temporary.write_text(page, encoding="utf-8")
    return out / "index.html"


def _templates(studies: Sequence[Stored], out: Path) -> "Environment":
    """The environment of the templates: jinja's functions and ours."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined
    from markupsafe import Markup

    environment = Environment(
        loader=FileSystemLoader(_HERE), autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters |= {
        "markup": lambda words: Markup(text.markup(words).replace(" %", "\u00a0%")),
        "cell": lambda value, spec: Markup(text.cell(value, spec)),
        "bare": text.bare,
        "sentences": text.first_sentence,
    }
    environment.globals |= {function.__name__: function for function in first_screen.SHOWN}
    environment.globals |= {
        "tally_of": tally,
        "advice_on": advice_on,
        "judged": JUDGED,
        "proofs": partial(first_screen.proofs, studies=studies),
    }
    return with_figures(environment, studies, out)


def matrix(studies: Sequence[Stored]) -> list[dict[str, Any]]:
    """Rows of the matrix study x evidence: per kind of evidence the worst outcome, and the number of verdicts."""
    rows = []
    for study in studies:
        cells = [_light([v for v in verdicts_of([study]) if v.evidence is kind]) for kind in Evidence]
        rows += [{"study": study.name, "cells": cells}] if any(cells) else []
    return rows


def _light(verdicts: list[Verdict]) -> dict[str, Any] | None:
    """The symbol of one cell: the worst outcome."""
    if not verdicts:
        return None
    worst = next(outcome for outcome in _WORST if any(v.outcome is outcome for v in verdicts))
    return {"outcome": worst.value, "count": len(verdicts)}


def _said(changes: Changes) -> str:
    """One sentence on how many numbers and verdicts moved."""
    fresh = changes.counts.get(Word.NEW, 0)
    every, new = sum(changes.counts.values()) - fresh, f", {fresh} new" if fresh else ""
    if not every:
        return f"Nothing to compare with{new}."
    left = sum(changes.counts.get(word, 0) for word in (Word.BETTER, Word.MOVED, Word.WORSE, Word.GONE))
    kind = "numbers and verdicts" if any(change.kind == "verdict" for change in changes.listed) else "numbers"
    return f"{left} of {every} {kind} moved since {changes.since}{new}."
