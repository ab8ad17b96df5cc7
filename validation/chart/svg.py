"""A drawing as SVG for a page: text as text, own ids, title and description, colours that a dark page can change; reproducible
byte for byte."""

import base64
import copy
import io
import re
from collections.abc import Iterable, Iterator
from itertools import groupby
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree

from validation.chart.colors import PAPER, by_night

if TYPE_CHECKING:
    from validation.chart.draw import Drawing

FONTS = "'STIX Two Text','STIXGeneral','Times New Roman','Liberation Serif',Tinos,serif"
_SVG, _LINK = "http://www.w3.org/2000/svg", "{http://www.w3.org/1999/xlink}href"
_COLOR, _REFERRED = re.compile(r"#[0-9a-f]{6}"), re.compile(r"url\(#(.*)\)|#(.*)")
_FILL = re.compile(r"url\(#(.*?)\)")  # in a style: a hatch
_MARKS = (f"{{{_SVG}}}use", f"{{{_SVG}}}path")
_PLACES = ("d", "x", "y", "width", "height", "transform", "viewBox")
_SHADES, _KEYS = 256, 16  # colours of a picture; of one whose colours a key explains
_RASTER_DOTS = 72  # per inch, of pictures within a drawing


def svg_of(figure: "Drawing", name: str, title: str, description: str) -> str:
    """The drawing as one <svg> element, whose ids begin with `name`."""
    raw = io.StringIO()
    figure.savefig(raw, format="svg", dpi=_RASTER_DOTS, metadata={"Date": None})
    ElementTree.register_namespace("", _SVG)
    root = ElementTree.fromstring(raw.getvalue())
    root.remove(root[0])  # who made it
    own = {old: f"{name}-{n}" for n, old in enumerate(dict.fromkeys(_referred(root)))}
    for element in root.iter():
        element.text, element.tail = element.text if (element.text or "").strip() else None, None
        _shorten(element, own)
    for parent in [one for one in root.iter() if one.find(f"{{{_SVG}}}image") is not None]:
        _day_and_night(parent)
    _regroup(root)
    known = {"role": "img", "aria-labelledby": f"{name}-title", "aria-describedby": f"{name}-desc"}
    root.attrib.update(known | {"style": f"font-family:{FONTS};fill:#000000"})
    for place, (tag, words) in enumerate((("title", title), ("desc", description))):
        element = ElementTree.Element(f"{{{_SVG}}}{tag}", {"id": f"{name}-{tag}"})
        element.text, element.tail = words, "\n"
        root.insert(place, element)
    text = ElementTree.tostring(root, encoding="unicode")
    return _COLOR.sub(lambda found: f"var({variable(found[0])},{found[0]})", text) + "\n"


def _referred(root: ElementTree.Element) -> Iterator[str]:
    """The ids that attributes refer to."""
    for name, value in (pair for element in root.iter() for pair in element.attrib.items()):
        if name == "style":
            yield from _FILL.findall(value)
        elif name != "fill" and (match := _REFERRED.fullmatch(value)):
            yield match[1] or match[2]


def _regroup(parent: ElementTree.Element) -> None:
    """Groups without attributes go; neighbours of one style, as the marks of a curve, become a group that has it."""
    for child in parent:
        _regroup(child)
    inner = [one for child in parent for one in (child if child.tag == f"{{{_SVG}}}g" and not child.attrib else [child])]
    parent[:] = []
    for (tag, style), group in groupby(inner, lambda one: (one.tag, one.get("style"))):
        alike = list(group)
        if len(alike) > 1 and style and tag in _MARKS and parent.tag != f"{{{_SVG}}}defs":
            for one in alike:
                del one.attrib["style"]
            ElementTree.SubElement(parent, f"{{{_SVG}}}g", {"style": style}).extend(alike)
        else:
            parent.extend(alike)


def _shorten(element: ElementTree.Element, own: dict[str, str]) -> None:
    """Only the ids that are referred to, renamed; places to a tenth of a point; the fonts of the page."""
    words = dict(element.attrib)
    element.attrib.clear()
    if words.get("id") in own:
        element.set("id", own[words["id"]])
    for name, value in ((name, value) for name, value in words.items() if name != "id"):
        match = _REFERRED.fullmatch(value)
        if name == "fill":  # behind a hatch
            name, value = "style", f"fill:{value}"
        elif match and name != "style":
            value = value.replace(match[1] or match[2], own[match[1] or match[2]])
        elif name in _PLACES:
            value = " ".join(map(_tenths, value.split()))
        elif name == "style":
            value = _FILL.sub(lambda fill: f"url(#{own[fill[1]]})", value)
            value = ";".join(part.replace(": ", ":") for part in value.split("; ") if not part.startswith("font-family"))
        element.set("href" if name == _LINK else name, value)


def _tenths(word: str) -> str:
    try:
        return f"{float(word):.1f}".removesuffix(".0")
    except ValueError:
        return word


def _day_and_night(parent: ElementTree.Element) -> None:
    """Pictures with palettes. A dark page inverts their shades; one of few colours, explained by a key, has a second version in
    the dark colours of the key."""
    from PIL import Image

    def address(image: Any) -> str:
        file = io.BytesIO()
        image.save(file, format="png", optimize=True)
        return "data:image/png;base64," + base64.b64encode(file.getvalue()).decode("ascii")

    for element in parent.findall(f"{{{_SVG}}}image"):
        with Image.open(io.BytesIO(base64.b64decode(element.attrib["href"].partition("base64,")[2]))) as image:
            seen = image.convert("RGBA")
        day = Image.alpha_composite(Image.new("RGBA", seen.size, PAPER), seen).convert("RGB").quantize(_SHADES)
        is_key = len(day.getcolors() or []) <= _KEYS
        element.attrib.update({"class": "day" if is_key else "shades", "href": address(day)})
        if is_key:
            other, night, palette = copy.deepcopy(element), day.copy(), bytes(day.getpalette() or [])
            colors = (by_night(f"#{palette[k : k + 3].hex()}") for k in range(0, len(palette), 3))
            night.putpalette(b"".join(bytes.fromhex(color[1:]) for color in colors))
            other.attrib.update({"class": "night", "style": "display:none", "href": address(night)})
            parent.append(other)


def inline(svg: str, name: str) -> str:
    """The element as part of a page, which declares namespace and colours; its ids begin with the short `name`."""
    known = re.sub(r"var\((--c[0-9a-f]{6}),#[0-9a-f]{6}\)", r"var(\1)", svg.replace(f' xmlns="{_SVG}"', "", 1))
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
