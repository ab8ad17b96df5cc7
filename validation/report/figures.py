"""Figures in the page: inline SVG whose colours follow the reader's, and the data of those that can be enlarged."""

import base64
import gzip
import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from validation.chart.svg import colors_of, inline
from validation.report.store import Picture, Stored
from validation.study import Verdict

if TYPE_CHECKING:
    from jinja2 import Environment


_HERE = Path(__file__).parent


class OfPaper(NamedTuple):
    """A figure of the paper that is drawn again, and the verdicts that it carries, of any study."""

    picture: Picture
    verdicts: list[Verdict]


def of_paper_in(studies: Sequence[Stored]) -> list[OfPaper]:
    """The paper's figures in its order."""
    every = [verdict for study in studies if study.result for verdict in study.result.verdicts]
    pictures = [picture for study in studies for picture in study.pictures if picture.paper]
    return [
        OfPaper(picture, [verdict for verdict in every if verdict.claim.startswith(tuple(picture.carries))])
        for picture in sorted(pictures, key=lambda one: one.paper)
    ]


def with_figures(environment: "Environment", studies: Sequence[Stored]) -> "Environment":
    """The environment with the filter `inline` and the figures' dark colours for `figure.html.j2`."""
    from markupsafe import Markup

    def element(picture: Picture) -> Any:
        return Markup(inline(picture.svg.read_text(encoding="utf-8"), f"f{pictures.index(picture)}"))

    pictures = [picture for study in studies for picture in study.pictures]
    environment.filters["inline"] = element
    colors = colors_of(picture.svg.read_text(encoding="utf-8") for picture in pictures)
    environment.globals["day"], environment.globals["night"] = map(Markup, colors)
    environment.globals["of_paper"] = of_paper_in(studies)
    environment.filters |= {"packed": packed, "json": json.dumps}
    environment.globals["plotting"] = Markup(_plotting()) if any(picture.zoom for picture in pictures) else ""
    return environment


def packed(picture: Picture) -> str:
    """The figure's CSV file as gzip in base64, the same bytes for the same file."""
    return base64.b64encode(gzip.compress(picture.csv.read_bytes(), mtime=0)).decode("ascii")


def _plotting() -> str:
    """The scripts: uPlot, without its first line, an address, and our code that uses it."""
    library = (_HERE / "uplot" / "uPlot.iife.min.js").read_text(encoding="utf-8")
    assert library.startswith("/*!")
    return (
        "/* uPlot 1.6.32, Copyright (c) 2022 Leon Sorokin, MIT License */"
        + library[library.index("*/") + 2 :]
        + (_HERE / "plot.js").read_text(encoding="utf-8")
    )
