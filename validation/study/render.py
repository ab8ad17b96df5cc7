"""Writes a drawing: SVG and PNG, a CSV file from which it can be redrawn, and its description in words."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from validation.study.description import description_of, title_of
from validation.study.drawing import Drawing
from validation.study.drawn import Panel, curves_csv, drawn, thin_out
from validation.study.vector import legible, svg_of

PNG_DOTS_PER_INCH = 110
SUFFIXES = (".svg", ".png", ".csv")


@dataclass(frozen=True)
class Words:
    """Description of a drawing: one sentence, the full text, and its panels."""

    title: str
    description: str
    panels: tuple[Panel, ...]


def render(figure: Drawing, stem: Path, name: str) -> Words:
    """Write stem.svg, stem.png and stem.csv, byte for byte the same for the same drawing; ids in the SVG begin with `name`."""
    import matplotlib as mpl

    figure.draw_without_rendering()  # only then do axes know their limits, and lie where they stay
    figure.set_layout_engine("none")
    thin_out(figure)
    panels = drawn(figure)
    words = Words(title_of(panels), description_of(panels), panels)
    _make_legible(figure)
    with mpl.rc_context({"svg.fonttype": "none"}):
        stem.with_name(stem.name + ".svg").write_text(svg_of(figure, name, words.title, words.description), encoding="utf-8")
    figure.savefig(stem.with_name(stem.name + ".png"), dpi=PNG_DOTS_PER_INCH, metadata={"Software": None})
    stem.with_name(stem.name + ".csv").write_text(curves_csv(panels), encoding="utf-8")
    return words


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
