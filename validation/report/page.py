"""The page: stored results through one template into one self-contained HTML file."""

import base64
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from slipwave.files import whole_or_absent
from validation.report.record import Record
from validation.report.store import Picture, Stored
from validation.study import Evidence, Outcome, Verdict, text

_HERE = Path(__file__).parent
_WORST = (Outcome.FAIL, Outcome.FINDING, Outcome.PASS)


def write_page(out: Path, studies: Sequence[Stored], facts: dict[str, str], report: Record) -> Path:
    """Render out/index.html from the studies' results; the file appears whole or not at all."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined
    from markupsafe import Markup

    environment = Environment(
        loader=FileSystemLoader(_HERE), autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters["markup"] = lambda words: Markup(text.markup(words))
    environment.filters["cell"] = lambda value, spec: Markup(text.cell(value, spec))
    environment.filters["inline"] = _inline
    page = environment.get_template("page.html.j2").render(
        css=Markup((_HERE / "page.css").read_text(encoding="utf-8")),
        facts=facts,
        quick=report.quick,
        written=report.times.written,
        studies=studies,
        evidence=tuple(Evidence),
        matrix=matrix(studies),
        tally=tally(studies),
        leads=[(study, picture) for study in studies for picture in study.pictures if picture.lead],
        omissions=[(study, o) for study in studies if study.result for o in study.result.omissions],
        changes=report.changes,
        wall=sum(study.wall_seconds for study in studies),
    )
    with whole_or_absent(out / "index.html") as temporary:
        temporary.write_text(page, encoding="utf-8")
    return out / "index.html"


def matrix(studies: Sequence[Stored]) -> list[dict[str, Any]]:
    """Rows of the claim x evidence matrix: study, claim, and per kind of evidence its worst outcome and all its verdicts."""
    rows = []
    for study in studies:
        verdicts = study.result.verdicts if study.result else ()
        for claim in dict.fromkeys(verdict.claim for verdict in verdicts):
            mine = [verdict for verdict in verdicts if verdict.claim == claim]
            cells = [_light([v for v in mine if v.evidence is kind]) for kind in Evidence]
            rows.append({"study": study.name, "claim": claim, "cells": cells})
    return rows


def _light(verdicts: list[Verdict]) -> dict[str, Any] | None:
    """The symbol of one cell: the worst outcome, with a title that lists its verdicts."""
    if not verdicts:
        return None
    worst = next(outcome for outcome in _WORST if any(v.outcome is outcome for v in verdicts))
    title = "; ".join(f"expected {v.expected}, ours {v.ours}" for v in verdicts)
    return {"outcome": worst.value, "count": len(verdicts), "title": text.bare(title)}


def tally(studies: Sequence[Stored]) -> dict[str, int]:
    """How many verdicts of each outcome, and how many studies failed."""
    verdicts = [verdict for study in studies if study.result for verdict in study.result.verdicts]
    counts = {outcome.value: sum(v.outcome is outcome for v in verdicts) for outcome in Outcome}
    return counts | {"broken": sum(study.result is None for study in studies)}


def _inline(picture: Picture) -> str:
    """The figure's SVG as a data address, so that the page is one file."""
    return "data:image/svg+xml;base64," + base64.b64encode(picture.svg.read_bytes()).decode("ascii")
