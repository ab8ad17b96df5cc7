"""Figures in the page: inline SVG whose colours follow the reader's, and the data of those that can be enlarged."""

import base64
import gzip
import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from validation.chart.svg import colors_of, inline
from validation.report.store import Picture, Stored

if TYPE_CHECKING:
    from jinja2 import Environment


_HERE = Path(__file__).parent


def with_figures(environment: "Environment", studies: Sequence[Stored], out: Path) -> "Environment":
    """The environment, of a page in the folder `out`, with the filter `inline` and the figures' dark colours for
    `figure.html.j2`; the paper's figures that are drawn again, in its order, with the verdicts that they carry, of any study."""
    from markupsafe import Markup

    def packed(picture: Picture) -> str:
        """The figure's CSV file as gzip in base64, the same bytes for the same file."""
        return base64.b64encode(gzip.compress((out / picture.files[2]).read_bytes(), mtime=0)).decode("ascii")

    pictures = [picture for study in studies for picture in study.pictures]
    drawings = {picture.id: (out / picture.files[0]).read_text(encoding="utf-8") for picture in pictures}
    numbers = {name: f"f{number}" for number, name in enumerate(drawings)}
    environment.filters["inline"] = lambda picture: Markup(inline(drawings[picture.id], numbers[picture.id]))
    colors = colors_of(drawings.values())
    environment.globals["day"], environment.globals["night"] = map(Markup, colors)
    every = [verdict for study in studies if study.result for verdict in study.result.verdicts]
    environment.globals["of_paper"] = [
        {"picture": one, "verdicts": [verdict for verdict in every if verdict.claim.startswith(tuple(one.carries))]}
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
