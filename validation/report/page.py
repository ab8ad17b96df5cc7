"""The page: stored results through one template into one self-contained HTML file."""

import base64
import gzip
import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from slipwave.files import whole_or_absent
from validation.chart.svg import colors_of, inline
from validation.report import Evidence, Outcome, Verdict, text
from validation.report.compared import JUDGED, advice_on
from validation.report.questions import ask, left_out, tally, verdicts_of
from validation.report.record import Changes, Record, Word
from validation.report.store import Picture, Stored

if TYPE_CHECKING:
    from jinja2 import Environment

_HERE = Path(__file__).parent
_FILES = {"JSON": "report.json", "JUnit": "junit.xml", "badge": "badge.svg"}
_WORST = (Outcome.FAIL, Outcome.FINDING, Outcome.PASS)


def write_page(out: Path, studies: Sequence[Stored], facts: dict[str, str], report: Record) -> Path:
    """Render out/index.html from the studies' results; the file appears whole or not at all."""
    from markupsafe import Markup

    said, verdicts = _said(report.changes), verdicts_of(studies)
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
            models=[table for study in studies for table in study.result.model_tables],
            questions=[*ask(studies, said)],
            findings=[verdict for verdict in verdicts if verdict.outcome is Outcome.FINDING],
            failures=[verdict for verdict in verdicts if verdict.outcome is Outcome.FAIL],
            evidence=tuple(Evidence),
            matrix=[*_matrix(studies)],
            tally=report.outcomes,
            leads=[(study, picture) for study in studies for picture in study.figures if picture.lead],
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

    def proofs(model: str) -> list[Verdict]:
        """The verdicts, or cases of them, that judge the model by its name."""
        rows = (row for verdict in verdicts_of(studies) for row in verdict.rows)
        return [row for row in rows if f"`{model}`" in row.claim + row.remark]

    environment.globals |= {"tally_of": tally, "advice_on": advice_on, "judged": JUDGED, "proofs": proofs}
    return _with_figures(environment, studies, out)


def _with_figures(environment: "Environment", studies: Sequence[Stored], out: Path) -> "Environment":
    """The environment, of a page in the folder `out`, with the filter `inline` and the figures' dark colours for
    `figure.html.j2`; the paper's figures that are drawn again, in its order, with the verdicts that they carry, of any study."""
    from markupsafe import Markup

    def packed(picture: Picture) -> str:
        """The figure's CSV file as gzip in base64, the same bytes for the same file."""
        return base64.b64encode(gzip.compress((out / picture.files[2]).read_bytes(), mtime=0)).decode("ascii")

    pictures = [picture for study in studies for picture in study.figures]
    drawings = {picture.id: (out / picture.files[0]).read_text(encoding="utf-8") for picture in pictures}
    numbers = {name: f"f{number}" for number, name in enumerate(drawings)}
    environment.filters["inline"] = lambda picture: Markup(inline(drawings[picture.id], numbers[picture.id]))
    colors = colors_of(drawings.values())
    environment.globals["day"], environment.globals["night"] = map(Markup, colors)
    environment.globals["of_paper"] = [
        (one, [verdict for verdict in verdicts_of(studies) if verdict.claim.startswith(one.carries)])
        for one in sorted(pictures, key=lambda one: one.paper)
        if one.paper
    ]
    environment.filters |= {"packed": packed, "json": json.dumps}
    environment.globals["plotting"] = Markup(_plotting()) if any(picture.zoom for picture in pictures) else ""
    return environment


def _plotting() -> str:
    """The scripts: uPlot, without its first line, an address, and our code that uses it."""
    library = (_HERE / "uplot" / "uPlot.iife.min.js").read_text(encoding="utf-8")
    assert library.startswith("/*!")
    return (
        "/* uPlot 1.6.32, Copyright (c) 2022 Leon Sorokin, MIT License */"
        + library[library.index("*/") + 2 :]
        + (_HERE / "plot.js").read_text(encoding="utf-8")
    )


def _matrix(studies: Sequence[Stored]) -> Iterator[dict[str, Any]]:
    """Rows of the matrix study x evidence: per kind of evidence the worst outcome, and the number of verdicts."""
    for study in (study for study in studies if study.result.verdicts):
        kinds = ([v.outcome for v in study.result.verdicts if v.evidence is kind] for kind in Evidence)
        cells = ({"outcome": min(found, key=_WORST.index).value, "count": len(found)} if found else None for found in kinds)
        yield {"study": study.name, "cells": list(cells)}


def _said(changes: Changes) -> str:
    """One sentence on how many numbers and verdicts moved."""
    fresh = changes.counts.get(Word.NEW, 0)
    every, new = sum(changes.counts.values()) - fresh, f", {fresh} new" if fresh else ""
    if not every:
        return f"Nothing to compare with{new}."
    left = sum(changes.counts.get(word, 0) for word in (Word.BETTER, Word.MOVED, Word.WORSE, Word.GONE))
    kind = "numbers and verdicts" if any(change.kind == "verdict" for change in changes.listed) else "numbers"
    return f"{left} of {every} {kind} moved since {changes.since}{new}."
