"""The README's table of models is what the families' facts say."""

from pathlib import Path

from slipwave.family import ANYTHING, FEATURES, NOTHING
from validation.registry.families import FAMILIES

README = Path(__file__).parents[2] / "README.md"


def row(family):
    numbers, letter = family.numbers, family.pattern[-1]
    told = f"{numbers[0]} to {numbers[-1]}" if isinstance(numbers, range) else ", ".join(map(str, numbers))
    name = f"`{family.pattern}`" + (f", {letter} = {told}" if numbers else "")
    scenes = {ANYTHING: "all", NOTHING: "two alike, plain slabs"}.get(family.honours)
    return f"| {name} | {family.title} | {family.error} | {scenes or ', '.join(f for f in FEATURES if f in family.honours)} |"


def test_the_table_of_models_is_read_from_the_facts():
    table = [
        "| name | what it is | error | scenes |",
        "|---|---|---|---|",
        *(row(family) for family in FAMILIES),
        "| `auto` | the first of these that is exact for the scene (default) | | all |",
    ]
    assert "\n".join(table) in README.read_text(encoding="utf-8")
