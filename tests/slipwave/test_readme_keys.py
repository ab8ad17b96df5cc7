"""README's table of scene keys is what the schema says, row by row; `python tests/slipwave/test_readme_keys.py` writes it."""

import re
from typing import get_args

from slipwave.input.schema import Numbers, allowed_in, scene_keys, tables_in
from slipwave.sources import ROOT

SAME_AS_SLAB = ("upper", "lower")
README = ROOT / "README.md"


def told(field):
    """What is allowed: a range as 1e-12..1e6, the words of a text, or a sentence."""
    allowed = next(allowed_in(field), None)
    if isinstance(allowed, Numbers):
        ends = "..".join(f"{end:g}".replace("e+", "e") for end in (allowed.low, allowed.high))
        return re.sub(r"e(-?)0+", r"e\1", ends) + (f", or in {' or '.join(allowed.units)}" if allowed.units else "")
    return allowed or in_code(get_args(field.annotation))


def in_code(words):
    return ", ".join(f"`{word}`" for word in words)


def rows(table, above="", kind=""):
    """A row for each key of `table` and of the tables in it; keys that several laws share are rows more than once."""
    for key, field in table.model_fields.items():
        inner, name = tables_in(field.annotation), f"{above}{key}"
        if len(inner) > 1:
            first, word = next((one, word) for table in inner.values() for word, one in table.model_fields.items())
            yield f"| `{name}.{word}` | {first.description} | {in_code(inner)} |"
        elif name in SAME_AS_SLAB:
            yield f"| `{name}` | {field.description} | |"
        elif not inner and key not in ("law", kind and "kind"):
            of = f" (`{kind}`)" if kind and above != "interface." else ""
            yield f"| `{name}`{of} | {field.description} | {told(field)} |"
        for one, below in inner.items():
            yield from rows(below, f"{name}.", one if len(inner) > 1 else "") if name not in SAME_AS_SLAB else ()


TABLE = "\n".join(["| key | meaning | allowed |", "|---|---|---|", *dict.fromkeys(rows(scene_keys()))])


def test_the_table_of_keys_is_read_from_the_schema():
    assert TABLE in README.read_text(encoding="utf-8")


if __name__ == "__main__":
    before, _, after = README.read_text(encoding="utf-8").partition(TABLE.partition("\n")[0])
    rest = after.partition("\n\n")[2]
    README.write_text(f"{before}{TABLE}\n\n{rest}", encoding="utf-8")
