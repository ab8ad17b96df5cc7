"""The page: stored results through one template into one self-contained HTML file."""

import base64
import gzip
import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from slipwave.files import whole_or_absent
from validation.chart.svg import colors_of, inline
from validation.report import Evidence, Verdict
from validation.report.compared import JUDGED, advice_on
from validation.report.questions import ask, left_out, tally, verdicts_of
from validation.report.record import Changes, Record, Word
from validation.report.store import Picture, StoredStudy
from validation.report.text import templates

if TYPE_CHECKING:
    from jinja2 import Environment

_HERE = Path(__file__).parent


def write_page(out: Path, studies: Sequence[StoredStudy], report: Record) -> Path:
    """Render out/index.html from the studies' results; the file appears whole or not at all."""
    said = _said(report.changes)
    told = {"report": report, "studies": studies, "said": said}
    told |= {"questions": [*ask(studies, said)], "omissions": left_out(studies), "evidence": Evidence}
    page = _templates(studies, out).get_template("page.html.j2").render(told)
    with whole_or_absent(out / "index.html") as temporary:
        temporary.write_text(page, encoding="utf-8")
    return out / "index.html"


def _templates(studies: Sequence[StoredStudy], out: Path) -> "Environment":
    """The environment of the templates, of a page in the folder `out`: jinja's functions and ours, styles, scripts, the figures'
    dark colours."""
    from markupsafe import Markup

    pictures = [picture for study in studies for picture in study.figures]
    drawings = {picture.id: (out / picture.files[0]).read_text(encoding="utf-8") for picture in pictures}
    numbers = {name: f"f{number}" for number, name in enumerate(drawings)}
    day, night = map(Markup, colors_of(drawings.values()))

    def packed(picture: Picture) -> str:
        """The figure's CSV file as gzip in base64, the same bytes for the same file."""
        return base64.b64encode(gzip.compress((out / picture.files[2]).read_bytes(), mtime=0)).decode("ascii")

    def proofs(model: str) -> list[Verdict]:
        """The verdicts, or cases of them, that judge the model by its name."""
        rows = (row for verdict in verdicts_of(studies) for row in verdict.rows)
        return [row for row in rows if f"`{model}`" in row.claim + row.remark]

    environment = templates()
    environment.filters |= {
        "inline": lambda picture: Markup(inline(drawings[picture.id], numbers[picture.id])),
        "packed": packed,
        "json": json.dumps,
    }
    environment.globals |= {"tally_of": tally, "advice_on": advice_on, "judged": JUDGED, "proofs": proofs}
    environment.globals |= {name.replace(".", "_"): Markup((_HERE / name).read_text("utf-8")) for name in ("page.css", "page.js")}
    plotting = Markup(_plotting()) if any(picture.zoom for picture in pictures) else ""
    environment.globals |= {"plotting": plotting, "day": day, "night": night}
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


def _said(changes: Changes) -> str:
    """One sentence on how many numbers and verdicts moved."""
    fresh = changes.counts.get(Word.NEW, 0)
    every, new = sum(changes.counts.values()) - fresh, f", {fresh} new" if fresh else ""
    if not every:
        return f"Nothing to compare with{new}."
    left = sum(changes.counts.get(word, 0) for word in (Word.BETTER, Word.MOVED, Word.WORSE, Word.GONE))
    kind = "numbers and verdicts" if any(change.kind == "verdict" for change in changes.listed) else "numbers"
    return f"{left} of {every} {kind} moved since {changes.since}{new}."
