"""Words of a look, and labels without the markup of formulas."""

import re
import unicodedata
from collections import Counter
from collections.abc import Iterable, Iterator

from validation.chart import Look

_DOTTED = 2.0  # a dash of less, in line widths, is a dot
_STYLES = {"-": "solid", "--": "dashed", ":": "dotted", "-.": "dash-dotted", "": "points"}
_WORDLESS = ("cells", "area", "text")


def look_in_words(look: Look) -> str:
    """Look of a trace except its colour, as in the file: dashes, kind unless it is a line, marker."""
    if look.kind in _WORDLESS:
        return look.kind
    tuples = "dashed" if isinstance(look.dashes, str) or look.dashes[1][0] >= _DOTTED else "dotted"
    words = _STYLES.get(look.dashes, tuples) if isinstance(look.dashes, str) else tuples
    return " ".join(word for word in (words, look.kind if look.kind != "line" else "", look.marker) if word)


def look_from_words(words: str, color: str) -> Look:
    """Inverse of `look_in_words`, but for widths and sizes."""
    style, *others = words.split(" ")
    if style in _WORDLESS:
        return Look(color, kind=style)
    kinds = [word for word in others if word in ("steps-pre", "smooth", "guide")]
    marker = "".join(word for word in others if word not in kinds)
    dashes = next(dashes for dashes, word in _STYLES.items() if word == style)
    return Look(color, dashes, marker, kind=kinds[0] if kinds else "line")


def plain_label(text: str) -> str:
    r"""A label without the markup of formulas: "$\log_{10} r$" as "log10 r"."""
    return " ".join(re.sub(r"\$([^$]*)\$", lambda found: _plain_formula(found[1]), text).split())


def _plain_formula(text: str) -> str:
    text = re.sub(r"\\(rm|mathrm|mathit)\b\s*", "", text).replace(r"\,", " ").replace(r"\%", "%").replace("\\ ", " ")
    text = re.sub(r"\\sqrt\{(\w+)\}", "√\\1", text).replace(r"\log_", "log")
    text = re.sub(r"\\([A-Za-z]+)\s?", lambda found: _greek(found[1]), text)
    return re.sub(r"[{}_]|\^(?=\*)", "", text).replace("^*", "*")


def _greek(name: str) -> str:
    """The Greek letter of this name, or the name."""
    size = "CAPITAL" if name[0].isupper() else "SMALL"
    try:
        return unicodedata.lookup(f"GREEK {size} LETTER {name}")
    except KeyError:
        return f"{name} "


def numbered(names: Iterable[str]) -> Iterator[str]:
    """Plain names, numbered where several are the same."""
    seen = Counter[str]()
    for name in map(plain_label, names):
        seen[name] += 1
        yield name + (f" ({seen[name]})" if seen[name] > 1 else "")
