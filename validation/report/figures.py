"""Figures in the page: inline SVG whose colours follow the reader's, and the data of those that can be enlarged."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from validation.report.store import Picture, Stored
from validation.study.vector import inline, night_colors

if TYPE_CHECKING:
    from jinja2 import Environment


def with_figures(environment: "Environment", studies: Sequence[Stored]) -> "Environment":
    """The environment, in which `figure.html.j2` knows the filter `inline` and the figures' colours by night."""
    from markupsafe import Markup

    def element(picture: Picture) -> Any:
        return Markup(inline(picture.svg.read_text(encoding="utf-8")))

    pictures = [picture for study in studies for picture in study.pictures]
    environment.filters["inline"] = element
    environment.globals["night"] = Markup(night_colors(picture.svg.read_text(encoding="utf-8") for picture in pictures))
    return environment
