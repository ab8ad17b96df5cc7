"""Colours that can be told from the paper by day and by night."""

import colorsys
from collections.abc import Iterable

PAPER, DARK_PAPER = "#ffffff", "#171716"
"""Background of a chart, light and dark."""

REGIMES = {
    "steady": "#f4f8fc",
    "decaying": "#cfe3f5",
    "settling": "#cacac0",
    "growing": "#9a76c4",
    "periodic": "#e69f00",
    "torus": "#146a55",
    "irregular": "#66152f",
}
"""Colours of regimes, which differ in grey and for colour-blind eyes too: from quiet to wild they darken."""

LEAST_CONTRAST = 3.0
"""Least contrast ratio of a line with the background (WCAG 1.4.11)."""


def _contrast(first: str, other: str) -> float:
    """Contrast ratio of two colours, 1 to 21 (WCAG)."""

    def luminance(color: str) -> float:
        linear = (x / 12.92 if x <= 0.04045 else ((x + 0.055) / 1.055) ** 2.4 for x in _channels(color))
        return sum(weight * x for weight, x in zip((0.2126, 0.7152, 0.0722), linear, strict=True))

    low, high = sorted((luminance(first), luminance(other)))
    return (high + 0.05) / (low + 0.05)


def by_night(color: str) -> str:
    """The colour of the same hue for a dark background, with the same contrast if it is a line's."""
    if color == PAPER:
        return DARK_PAPER
    hue, light, depth = colorsys.rgb_to_hls(*_channels(color))
    least, low = _channels(DARK_PAPER)[0], 1.0 - light
    turned = _hex(colorsys.hls_to_rgb(hue, least + low * (0.93 - least), depth))
    return legible(turned, DARK_PAPER) if _contrast(color, PAPER) >= LEAST_CONTRAST else turned


def legible(color: str, paper: str = PAPER) -> str:
    """The nearest colour of the same hue with enough contrast: darker on white, lighter on dark paper."""
    hue, light, depth = colorsys.rgb_to_hls(*_channels(color))
    end = 0.0 if _contrast(paper, "#000000") > _contrast(paper, "#ffffff") else 1.0
    for k in range(101):
        shade = _hex(colorsys.hls_to_rgb(hue, light + (end - light) * k / 100.0, depth)) if k else color
        if _contrast(shade, paper) >= LEAST_CONTRAST:
            return shade
    return color


def _channels(color: str) -> tuple[float, float, float]:
    red, green, blue = (int(color[k : k + 2], 16) / 255.0 for k in (1, 3, 5))
    return red, green, blue


def _hex(channels: Iterable[float]) -> str:
    return "#" + "".join(f"{round(255 * min(1.0, max(0.0, x))):02x}" for x in channels)
