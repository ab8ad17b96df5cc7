"""A drawing as SVG for a page: text as text, own ids, title and description, colours that a dark page can change; reproducible
byte for byte."""

import base64
import io
import re
from collections.abc import Iterable
from html import escape
from typing import TYPE_CHECKING, Any

from validation.chart.colors import PAPER, by_night

if TYPE_CHECKING:
    from validation.chart.draw import Drawing

FONTS = "'STIX Two Text','STIXGeneral','Times New Roman','Liberation Serif',Tinos,serif"
_NAMESPACE = ' xmlns="http://www.w3.org/2000/svg"'
_COLOR, _REFERENCE = re.compile(r"#[0-9a-f]{6}"), re.compile(r'(url\(#|href="#)([^")]+)')
_PLACES, _NUMBER = re.compile(r' (?:[dxy]|width|height|viewBox|transform)=".*?"'), re.compile(r"-?\d+\.\d+")
_GROUP = re.compile(r"<g>((?:(?!</?g\b).)*)</g>|<g/>")  # without attributes
_ALIKE = re.compile(r'<(?:use|path) (?!id)[^>]*?( style="[^"]*")/>(?:<(?:use|path) (?!id)[^>]*\1/>)+')  # as the marks of a curve
_TIDY = {
    r"(?s)^.*?(?=<svg)|<metadata>.*?</metadata>|<!--.*?-->| xmlns:xlink=\S+|xlink:": "",  # who made it, and formulas once more
    r">\s*\n\s*<": "><",
    r"\s*\n": " ",
    r" ?font-family: [^;\"]*;?": "",  # those of the page instead
    r' fill="(.*?)"': r' style="fill: \1"',  # behind a hatch
}
_SHADES, _KEYS = 256, 16  # colours of a picture; of one whose colours a key explains
_RASTER_DOTS = 72  # per inch, of pictures within a drawing


def svg_of(figure: "Drawing", name: str, title: str, description: str) -> str:
    """The drawing as one <svg> element, whose ids begin with `name`: only those that are referred to; places to a tenth of a
    point."""
    raw = io.StringIO()
    figure.savefig(raw, format="svg", dpi=_RASTER_DOTS, metadata={"Date": None})
    text = raw.getvalue()
    for pattern, other in _TIDY.items():
        text = re.sub(pattern, other, text)
    own = {old: f"{name}-{n}" for n, old in enumerate(dict.fromkeys(old for _, old in _REFERENCE.findall(text)))}
    text = re.sub(' id="(.*?)"', lambda id: f' id="{own[id[1]]}"' if id[1] in own else "", text)
    text = _REFERENCE.sub(lambda match: match[1] + own[match[2]], text)
    text = _PLACES.sub(lambda places: _NUMBER.sub(lambda number: f"{float(number[0]):.1f}".removesuffix(".0"), places[0]), text)
    text = re.sub('style=".*?"', lambda style: re.sub("(?<=[:;]) ", "", style[0]), text)
    text = re.sub('<image (.*?base64,)(.*?)(".*?/>)', _day_and_night, text)
    while _GROUP.search(text):
        text = _GROUP.sub(r"\1", text)
    text = _ALIKE.sub(lambda marks: f"<g{marks[1]}>{marks[0].replace(marks[1], '')}</g>", text)
    known = f'role="img" aria-labelledby="{name}-title" aria-describedby="{name}-desc" style="font-family:{FONTS};fill:#000000"'
    words = f'<title id="{name}-title">{escape(title)}</title>\n<desc id="{name}-desc">{escape(description)}</desc>\n'
    text = text.replace(">", f" {known}>{words}", 1)
    return _COLOR.sub(lambda match: f"var({variable(match[0])},{match[0]})", text) + "\n"


def _day_and_night(element: re.Match[str]) -> str:
    """A picture with a palette. A dark page inverts its shades; one of few colours, explained by a key, has a second version in
    the dark colours of the key."""
    from PIL import Image

    def with_palette(image: Any, words: str) -> str:
        file = io.BytesIO()
        image.save(file, format="png", optimize=True)
        return f"<image {words} {element[1]}{base64.b64encode(file.getvalue()).decode('ascii')}{element[3]}"

    with Image.open(io.BytesIO(base64.b64decode(element[2]))) as image:
        seen = image.convert("RGBA")
    day = Image.alpha_composite(Image.new("RGBA", seen.size, PAPER), seen).convert("RGB").quantize(_SHADES)
    if len(day.getcolors() or []) > _KEYS:
        return with_palette(day, 'class="shades"')
    night, palette = day.copy(), bytes(day.getpalette() or [])
    colors = (by_night(f"#{palette[k : k + 3].hex()}") for k in range(0, len(palette), 3))
    night.putpalette(b"".join(bytes.fromhex(color[1:]) for color in colors))
    return with_palette(day, 'class="day"') + with_palette(night, 'class="night" style="display:none"')


def inline(svg: str, name: str) -> str:
    """The element as part of a page, which declares namespace and colours; its ids begin with the short `name`."""
    known = re.sub(r"var\((--c[0-9a-f]{6}),#[0-9a-f]{6}\)", r"var(\1)", svg.replace(_NAMESPACE, "", 1))
    own = re.search(r'aria-labelledby="(.*?)-title"', known)
    return re.sub(rf'(["#]){re.escape(own[1])}-', rf"\g<1>{name}-", known) if own else known


def variable(color: str) -> str:
    """The CSS variable of a colour."""
    return f"--c{color[1:]}"


def colors_of(svgs: Iterable[str]) -> tuple[str, str]:
    """Declarations of every variable in these drawings, for a light and for a dark page."""
    used = sorted({color for svg in svgs for color in re.findall(r"var\(--c[0-9a-f]{6},(#[0-9a-f]{6})\)", svg)})
    day, night = ("".join(f"{variable(color)}:{shown(color)};" for color in used) for shown in (str, by_night))
    return day, night
