"""A drawing as SVG for a page: text as text, rounded coordinates, own ids, title and description, colours that a dark page can
change; reproducible byte for byte."""

import base64
import colorsys
import io
import math
import re
from collections.abc import Iterable, Iterator
from html import escape
from itertools import groupby
from typing import Any

from validation.study.drawing import Drawing

PAPER, DARK_PAPER = "#ffffff", "#171716"
"""Background of a figure, light and dark."""

LEAST_CONTRAST = 3.0
"""Least contrast ratio of a line with the background (WCAG 1.4.11)."""

FONTS = "'STIX Two Text','STIXGeneral','Times New Roman','Liberation Serif',Tinos,serif"
_COLOR = re.compile(r"#[0-9a-f]{6}")
_TENTHS = 10
_MARKS = re.compile(r"(<g [^>]*>)(?:<use [^>]*/>)+</g>(?:\1(?:<use [^>]*/>)+</g>)+")
_SHADES, _KEYS = 256, 16  # colours of a picture; of one whose colours a key explains
_RASTER_DOTS = 72  # per inch, of maps within a drawing
_STRAIGHT = 1.0  # tenths of a point


def svg_of(figure: Drawing, name: str, title: str, description: str) -> str:
    """The drawing as one <svg> element, whose ids begin with `name`."""
    raw = io.StringIO()
    figure.savefig(raw, format="svg", dpi=_RASTER_DOTS, metadata={"Date": None})
    text = raw.getvalue()
    found = re.search(r"<svg [^>]*?width=\"([\d.]+)pt\" height=\"([\d.]+)pt\"", text)
    assert found
    body = text[text.index("</metadata>") + len("</metadata>") : text.rindex("</svg>")]
    body = re.sub(r"<!--.*?-->", "", body, flags=re.DOTALL).replace("xlink:href", "href")
    body = re.sub(r"(?<=\sd=\")[^\"]*", lambda found: rounded_path(found[0]), body)
    body = re.sub(r"(?<=[\s(\"])-?\d+\.\d+(?=[\s)\"])", lambda found: f"{float(found[0]):.2f}".rstrip("0").rstrip("."), body)
    body = re.sub(r"(<image [^>]*base64,)\s*([A-Za-z0-9+/=\s]+)([^>]*>)", _day_and_night, body)
    body = _own_ids(_flowing(body), name)
    body = re.sub(r"font-family: [^;\"]*;? ?", "", body)
    body = re.sub(r'(?<= style=")[^"]*', lambda found: re.sub(r"([;:]) ", r"\1", found[0]), body).replace(' style=""', "")
    body = _unwrapped(_once(re.sub(r">\s+<", "><", body).strip()))
    body = _COLOR.sub(lambda found: f"var({variable(found[0])},{found[0]})", body)
    width, height = (f"{float(size):.2f}" for size in found.groups())
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" role="img" aria-labelledby="{name}-title" aria-describedby="{name}-desc" '
        f'viewBox="0 0 {width} {height}" width="{width}pt" height="{height}pt" style="font-family:{FONTS};'
        f'fill:var({variable("#000000")},#000000)">\n<title id="{name}-title">{escape(title)}</title>\n'
        f'<desc id="{name}-desc">{escape(description)}</desc>\n{body}\n</svg>\n'
    )


def rounded_path(path: str) -> str:
    """A path in tenths of a point, each step relative to the rounded point before, so that errors do not add up; without points
    that lie on the straight line between others."""
    here, found = (0, 0), list[str]()
    for lines, command, numbers in re.findall(r"((?:L[^MLQCzZ]*)+)|([MQCzZ])([^MLQCzZ]*)", path):
        values = [round(_TENTHS * float(number)) for number in (numbers or lines.replace("L", " ")).split()]
        points = list(zip(values[::2], values[1::2], strict=True))
        if lines:
            points = corners([here, *points])[1:]
        if command == "M":
            steps = points
        elif command in "QC" and command:
            steps = [(x - here[0], y - here[1]) for x, y in points]
        else:
            steps = [(x - u, y - v) for (x, y), (u, v) in zip(points, [here, *points], strict=False)]
        here = points[-1] if points else here
        words = "".join(_short(value, k > 0) for k, value in enumerate(x for pair in steps for x in pair))
        found.append((command if command in "MzZ" and command else command.lower() or "l") + words)
    return "".join(found)


def corners(points: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """The points of a line without those within `_STRAIGHT` of the simplified line (Ramer, Douglas and Peucker)."""
    stays, open_ = {0, len(points) - 1}, [(0, len(points) - 1)]
    while open_:
        begin, end = open_.pop()
        apart = [_from_segment(points[k], points[begin], points[end]) for k in range(begin + 1, end)]
        if apart and max(apart) > _STRAIGHT:
            k = begin + 1 + apart.index(max(apart))
            stays.add(k)
            open_ += [(begin, k), (k, end)]
    return [points[k] for k in sorted(stays)]


def _from_segment(point: tuple[int, int], begin: tuple[int, int], end: tuple[int, int]) -> float:
    """Distance of a point from a piece of straight line."""
    (x, y), (u, v), (p, q) = begin, end, point
    square = (u - x) ** 2 + (v - y) ** 2
    share = min(1.0, max(0.0, ((p - x) * (u - x) + (q - y) * (v - y)) / square)) if square else 0.0
    return math.hypot(p - x - share * (u - x), q - y - share * (v - y))


def _short(tenths: int, spaced: bool) -> str:
    """A number of tenths in the fewest characters; `spaced`: it follows another number."""
    text = f"{abs(tenths) / _TENTHS:.1f}".rstrip("0").rstrip(".")
    text = text[1:] if text.startswith("0.") else text
    return f"-{text}" if tenths < 0 else f" {text}" if spaced else text


def _day_and_night(found: re.Match[str]) -> str:
    """A picture within the drawing, with a palette. A dark page inverts its shades; a picture of few colours, explained by a key,
    has a second version in the dark colours of the key."""
    from PIL import Image

    def as_address(image: Any) -> str:
        file = io.BytesIO()
        image.save(file, format="png", optimize=True)
        return base64.b64encode(file.getvalue()).decode("ascii")

    with Image.open(io.BytesIO(base64.b64decode(found[2]))) as image:
        seen = image.convert("RGBA")
    day = Image.alpha_composite(Image.new("RGBA", seen.size, PAPER), seen).convert("RGB").quantize(_SHADES)
    element = found[1].replace("<image ", '<image class="{}" ') + "{}" + found[3]
    if len(day.getcolors() or []) > _KEYS:
        return element.format("shades", as_address(day))
    night, palette = day.copy(), bytes(day.getpalette() or [])
    night.putpalette(b"".join(bytes.fromhex(by_night(f"#{palette[k : k + 3].hex()}")[1:]) for k in range(0, len(palette), 3)))
    hidden = re.sub(r' id="[^"]*"', "", element).replace("<image ", '<image style="display:none" ')
    return element.format("day", as_address(day)) + hidden.format("night", as_address(night))


def _flowing(body: str) -> str:
    """Letters of one look and line as words in reading order, instead of separately positioned letters."""
    letter = re.compile(r'<tspan x="([^"]*)" y="([^"]*)" style="([^"]*)">([^<]*)</tspan>')

    def words(found: re.Match[str]) -> str:
        letters = sorted(letter.findall(found[2]), key=lambda one: float(one[0].split()[0]))
        return found[1] + "".join(word(list(run)) for _, run in groupby(letters, key=lambda one: one[1:3]))

    def word(run: list[tuple[str, str, str, str]]) -> str:
        x, y, style, _ = run[0]
        return f'<tspan x="{x}" y="{y}" style="{style}" xml:space="preserve">{"".join(one[3] for one in run)}</tspan>'

    return re.sub(r"(<text[^>]*>)\s*((?:<tspan[^>]*>[^<]*</tspan>\s*)+)", words, body)


def _once(body: str) -> str:
    """The common style of marks of one kind moved to their group."""

    def hoisted(found: re.Match[str]) -> str:
        styles = set(re.findall(r' style="([^"]*)"', found[2]))
        if len(styles) > 1:
            return found[0]
        return f'<g{found[1]} style="{styles.pop()}">' + re.sub(r' style="[^"]*"', "", found[2]) + "</g>"

    return re.sub(r"<g((?: clip-path=\"[^\"]*\")?)>((?:<use [^>]*/>)+)</g>", hoisted, body)


def _unwrapped(body: str) -> str:
    """Without empty groups; successive marks of one look in one group."""
    speaks, found = list[bool](), list[str]()
    for part in re.split(r"(<g>|<g [^>]*>|</g>)", body):
        if part == "</g>":
            said = speaks.pop()
        else:
            said = part != "<g>"
            speaks += [said] * part.startswith("<g")
        found += [part] * said
    return _MARKS.sub(lambda same: same[1] + same[0].replace(f"</g>{same[1]}", "").removeprefix(same[1]), "".join(found))


def _own_ids(body: str, name: str) -> str:
    """`body` with only the ids that are referred to, each beginning with `name`."""
    used = dict.fromkeys(re.findall(r"(?:href=\"#|url\(#)([^\")]+)", body))
    own = {old: f"{name}-{n}" for n, old in enumerate(used)}
    body = re.sub(r' id="([^"]+)"', lambda found: f' id="{own[found[1]]}"' if found[1] in own else "", body)
    return re.sub(r"(href=\"#|url\(#)([^\")]+)", lambda found: found[1] + own[found[2]], body)


def inline(svg: str, name: str) -> str:
    """The element as part of a page, which declares namespace and colours; its ids begin with the short `name`."""
    known = re.sub(r"var\((--c[0-9a-f]{6}),#[0-9a-f]{6}\)", r"var(\1)", svg.replace(' xmlns="http://www.w3.org/2000/svg"', "", 1))
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


def contrast(one: str, other: str) -> float:
    """Contrast ratio of two colours, 1 to 21 (WCAG)."""

    def luminance(color: str) -> float:
        linear = (x / 12.92 if x <= 0.04045 else ((x + 0.055) / 1.055) ** 2.4 for x in _channels(color))
        return sum(weight * x for weight, x in zip((0.2126, 0.7152, 0.0722), linear, strict=True))

    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


def by_night(color: str) -> str:
    """The colour of the same hue for a dark background, with the same contrast if it is a line's."""
    if color == PAPER:
        return DARK_PAPER
    hue, light, depth = colorsys.rgb_to_hls(*_channels(color))
    least, low = _channels(DARK_PAPER)[0], 1.0 - light
    turned = _hex(colorsys.hls_to_rgb(hue, least + low * (0.93 - least), depth))
    return legible(turned, DARK_PAPER) if contrast(color, PAPER) >= LEAST_CONTRAST else turned


def legible(color: str, paper: str = PAPER, least: float = LEAST_CONTRAST) -> str:
    """The nearest colour of the same hue with enough contrast: darker on white, lighter on dark paper."""
    return next((shade for shade in _shades(color, paper) if contrast(shade, paper) >= least), color)


def _shades(color: str, paper: str) -> Iterator[str]:
    hue, light, depth = colorsys.rgb_to_hls(*_channels(color))
    end = 0.0 if contrast(paper, "#000000") > contrast(paper, "#ffffff") else 1.0
    for k in range(101):
        yield _hex(colorsys.hls_to_rgb(hue, light + (end - light) * k / 100.0, depth)) if k else color


def _channels(color: str) -> tuple[float, float, float]:
    red, green, blue = (int(color[k : k + 2], 16) / 255.0 for k in (1, 3, 5))
    return red, green, blue


def _hex(channels: Iterable[float]) -> str:
    return "#" + "".join(f"{round(255 * min(1.0, max(0.0, x))):02x}" for x in channels)
