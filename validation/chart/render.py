"""Writes the files of a chart: SVG, PNG, and a CSV file from which it can be drawn again."""

from pathlib import Path
from typing import Any

from validation.chart import Chart
from validation.chart.draw import draw, styled
from validation.chart.svg import svg_of
from validation.chart.table import curves_csv, panel_facts
from validation.chart.thin import with_fewer
from validation.chart.words import described

PNG_DOTS_PER_INCH = 110
SUFFIXES = (".svg", ".png", ".csv")


def render(chart: Chart, stem: Path, name: str) -> dict[str, Any]:
    """Write stem.svg, stem.png and stem.csv, byte for byte the same for the same chart; ids in the SVG begin with `name`. Returns
    its title, description and panels, as stored beside them."""
    kept = with_fewer(chart)
    title, description = described(kept)
    with styled():
        figure = draw(chart)
        stem.with_name(stem.name + ".svg").write_text(svg_of(figure, name, title, description), encoding="utf-8")
        figure.savefig(stem.with_name(stem.name + ".png"), dpi=PNG_DOTS_PER_INCH, metadata={"Software": None})
    stem.with_name(stem.name + ".csv").write_text(curves_csv(kept), encoding="utf-8")
    return {"title": title, "description": description, "panels": panel_facts(kept)}
