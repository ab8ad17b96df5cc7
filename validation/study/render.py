"""Writes the files of a figure: of a chart or, until every study gives charts, of a drawing."""

from pathlib import Path
from typing import Any

from validation.chart import Chart
from validation.chart.colors import legible
from validation.chart.draw import Drawing
from validation.chart.render import PNG_DOTS_PER_INCH, render
from validation.chart.svg import svg_of
from validation.chart.table import curves_csv, panel_facts
from validation.chart.words import described
from validation.study.drawn import drawn, thin_out


def render_figure(figure: Chart | Drawing, stem: Path, name: str) -> dict[str, Any]:
    """As `render`, of a chart or a drawing."""
    if isinstance(figure, Chart):
        return render(figure, stem, name)
    figure.draw_without_rendering()  # only then do axes know their limits, and lie where they stay
    figure.set_layout_engine("none")
    thin_out(figure)
    chart = drawn(figure)
    title, description = described(chart)
    _make_legible(figure)
    stem.with_name(stem.name + ".svg").write_text(svg_of(figure, name, title, description), encoding="utf-8")
    figure.savefig(stem.with_name(stem.name + ".png"), dpi=PNG_DOTS_PER_INCH, metadata={"Software": None})
    stem.with_name(stem.name + ".csv").write_text(curves_csv(chart), encoding="utf-8")
    return {"title": title, "description": description, "panels": panel_facts(chart)}


def _make_legible(figure: Drawing) -> None:
    """Darken each line and mark, in the axes and in the legends, until it is clear enough on white paper."""
    from matplotlib.colors import to_hex

    def clear(color: Any) -> Any:
        if isinstance(color, str) and color in ("none", "auto", "white"):
            return color
        return color if to_hex(color) == "#ffffff" else legible(to_hex(color))

    legends = [*figure.legends, *(legend for axes in figure.axes if (legend := axes.get_legend()))]
    handles: list[Any] = [one for legend in legends for one in legend.legend_handles if hasattr(one, "get_marker")]
    for line in (*handles, *(line for axes in figure.axes for line in axes.lines)):
        line.set(
            color=clear(line.get_color()),
            markeredgecolor=clear(line.get_markeredgecolor()),
            markerfacecolor=clear(line.get_markerfacecolor()),
        )
