"""Converts words and numbers to HTML: a small markup for captions, and aligned numerals."""

import html
import math
import re
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from jinja2 import Environment

Cell: TypeAlias = float | int | str | None
"""One entry of a table; None prints as a dash."""

_MARKS = (
    (re.compile(r"_\{([^}]*)\}"), r"<sub>\1</sub>"),
    (re.compile(r"\^\{([^}]*)\}"), r"<sup>\1</sup>"),
    (re.compile(r"`([^`]*)`"), r"<code>\1</code>"),
    (re.compile(r"~\{([^{}]*)\}"), r'<span class="time">\1</span>'),
    (re.compile(r"(?<![A-Za-z0-9])\*([^*\s](?:[^*]*[^*\s])?)\*(?![A-Za-z0-9])"), r"<em>\1</em>"),
)
_POWER = re.compile(r"^(.*)e([+−])0*(\d+)$")


def markup(text: str) -> str:
    """HTML of `text`: x_{sub}, x^{sup}, *emphasis*, `code` and ~{run time}; everything else is escaped."""
    result = html.escape(text, quote=False).replace("^{-", "^{−").replace(" · 10^", "\u202f·\u202f10^")
    for pattern, replacement in _MARKS:
        result = pattern.sub(replacement, result)
    return result


def number(value: float, spec: str = ".7g") -> str:
    """`value` as HTML by the format `spec`, with a true minus sign and powers of ten instead of e-notation."""
    return markup(plain(value, spec))


def cell(value: Cell, spec: str) -> str:
    """HTML of one entry of a table."""
    if value is None:
        return "–"
    if isinstance(value, str):
        return markup(value)
    return number(float(value), spec) if spec else html.escape(str(value))


def bare(words: str) -> str:
    """`words` without the small markup, for titles and for the terminal."""
    for mark in ("~{", "_{", "^{", "}", "*", "`"):
        words = words.replace(mark, "^" if mark == "^{" else "")
    return words


def _first_sentence(words: str) -> tuple[str, str]:
    """The first sentence of `words`, and the rest."""
    first, *rest = re.split(r"(?<=[.?!])(?<! al\.) +(?=[A-ZΔΨ`*(])", words.strip(), maxsplit=1)
    return first, " ".join(rest)


def places(values: Iterable[float], spec: str = "g") -> str:
    """Several numbers in a sentence: −2.69, −2.68."""
    return minus(", ".join(format(value, spec) for value in values))


def power(value: float) -> str:
    """A power of ten in the small markup: 10^{−9}."""
    return minus(f"10^{{{round(math.log10(value))}}}")


def plain(value: float, spec: str = ".3g") -> str:
    """As `number` in the small markup, for use inside sentences: 1.2 · 10^{-9}."""
    if math.isnan(value):
        return "–"
    if math.isinf(value):
        return "∞" if value > 0 else "−∞"
    return _POWER.sub(lambda power: f"{power[1]} · 10^{{{power[2].replace('+', '')}{power[3]}}}", minus(format(value, spec)))


def around(near: float, measured: float, within: float) -> tuple[str, str]:
    """What is allowed and what was found, with enough digits to distinguish them, in the small markup: both values if they differ
    in the first seven digits, else distances from `near`."""
    size = abs(measured - near)
    if near and math.isfinite(measured) and within > 1e-7 * abs(near):
        fewest = 1 - math.floor(math.log10(within))
        decimals = next((n for n in range(fewest, 15) if round(size, n) != round(within, n)), 15)
        return minus(f"{near:.{decimals}f} ± {plain(within, '.2g')}"), minus(f"{measured:.{decimals}f}")
    digits = next((n for n in range(2, 17) if f"{size:.{n}g}" != f"{within:.{n}g}"), 17)
    return f"below {plain(within, f'.{digits}g')}", plain(size, f".{digits}g")


def minus(text: str) -> str:
    """`text` with true minus signs instead of hyphens."""
    return text.replace("-", "−")


def templates() -> "Environment":
    """The environment of the templates of the page and its files."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined
    from markupsafe import Markup

    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters |= {
        "markup": lambda words: Markup(markup(words).replace(" %", "\u00a0%")),
        "cell": lambda value, spec: Markup(cell(value, spec)),
        "bare": bare,
        "sentences": _first_sentence,
    }
    return environment
