"""README's table of scene keys names every key, with the range or the words that the schema allows."""

import re
from collections.abc import Iterator
from typing import Any, get_args

import pytest
from pydantic import BaseModel

from slipwave.friction import LAWS
from slipwave.friction.ageing import Ageing
from slipwave.input import schema
from slipwave.input.complain import _allowed, _tables
from slipwave.input.number import Range
from slipwave.input.validate import _interface_table
from slipwave.sources import ROOT

_, _, _TABLE = (ROOT / "README.md").read_text(encoding="utf-8").partition("| key | meaning | allowed |\n")
ROWS = [row for row in _TABLE.partition("\n\n")[0].splitlines()[1:] if row]


def keys(table: type[BaseModel], top: str) -> Iterator[tuple[str, str, Any]]:
    """(first table, key, its field) of every key below a table that holds no table itself."""
    for key, field in table.model_fields.items():
        inner = _tables(field.annotation)
        if not inner:
            yield top, key, field
        for one in inner:
            yield from keys(one, top or key)


KEYS = [*keys(_interface_table(Ageing), "interface"), *keys(schema.SceneTable, "")]
NAMED = [(top, key, field) for top, key, field in KEYS if top not in ("", "lower", "upper")]


def told(allowed: Range) -> str:
    """As README writes a range: 1e-12..1e6."""
    ends = (f"{end:g}".replace("e+", "e") for end in (allowed.low, allowed.high))
    return "..".join(re.sub(r"e(-?)0*", r"e\1", end) for end in ends)


@pytest.mark.parametrize(("top", "key", "field"), NAMED, ids=[f"{top}.{key}" for top, key, _ in NAMED])
def test_a_key_stands_in_readme_with_what_is_allowed(top: str, key: str, field: Any) -> None:
    beside = [row for row in ROWS if row.startswith(f"| `{top}") and re.search(rf"[`.]{key}`", row)]
    assert beside
    ranges = [told(allowed) for allowed in _allowed(field) if isinstance(allowed, Range)]
    words = [word for word in get_args(field.annotation) if isinstance(word, str)]
    assert any(all(f"`{word}`" in row for word in words) for row in beside)
    assert any(all(re.search(rf"(?<![\w.]){re.escape(one)}(?!\w)", row.split("|")[-2]) for one in ranges) for row in beside)


def test_the_laws_stand_in_readme() -> None:
    (row,) = (row for row in ROWS if row.startswith("| `interface.law`"))
    assert all(f"`{law}`" in row for law in LAWS)


def test_no_key_stands_there_that_is_not_one() -> None:
    known = {f"{top}.{key}" for top, key, _ in KEYS} | {"slab.layers", "slab.face.kind", "slab.viscosity.kind", "upper", "lower"}
    assert {name for row in ROWS for name in re.findall(r"`([a-z.0-9_]+)`", row.split("|")[1]) if "." in name} <= known
