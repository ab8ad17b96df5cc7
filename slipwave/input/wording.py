"""Parts of one-line messages about input: shortened values, visible control characters, the nearest known word."""

import difflib
import reprlib
from collections.abc import Iterable
from typing import Any

_brief = reprlib.Repr()
_brief.maxstring = _brief.maxother = 40
_brief.maxlevel = 2
_brief.maxlist = _brief.maxdict = _brief.maxtuple = 3
_LONGEST_KEY = 60
_LONGEST_VALUE = 200


def shorten(value: Any) -> str:
    """`value` as a short text without line breaks; never fails."""
    try:
        text = _brief.repr(value)
    except (ValueError, RecursionError):  # integers beyond Python's limit of printable digits
        text = f"<{type(value).__name__} too large to print>"
    return _cut(one_line(text), _LONGEST_VALUE)  # one control character becomes up to ten characters


def sentence(text: str) -> str:
    """Another program's message with control characters made visible; cut only if it is very long."""
    return _cut(one_line(text), _LONGEST_VALUE)


def one_line(text: str) -> str:
    """`text` with line breaks and control characters made visible."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape", "backslashreplace").decode() for c in text)


def key_text(parts: Iterable[str | int]) -> str:
    """Dotted key; a very long one is shortened in the middle."""
    return _cut(one_line(".".join(str(part) for part in parts)), _LONGEST_KEY)


def _cut(text: str, longest: int) -> str:
    return text if len(text) <= longest else f"{text[: longest - 18]}...{text[-15:]}"


def nearest(word: str, known: Iterable[str]) -> str | None:
    """The known word most similar to `word`, or None if none is similar enough."""
    matches = difflib.get_close_matches(word[:_LONGEST_KEY].lower(), list(known), n=1, cutoff=0.5)
    return matches[0] if matches else None


def choices(known: Iterable[str], given: Any = None) -> str:
    """The known words as `"a", "b" or "c"`, and the one that the wrong word `given` resembles."""
    known = list(known)
    words = listed(f'"{word}"' for word in known)
    guess = nearest(given, known) if isinstance(given, str) else None
    return f'{words}; did you mean "{guess}"?' if guess else words


def listed(words: Iterable[str]) -> str:
    """As in "a, b or c"."""
    *first, last = words
    return f"{', '.join(first)} or {last}" if first else last
