"""The JSON Schema of scene files accepts every scene of the gallery, and refuses what reading it refuses by its shape."""

import json
import re
import tomllib

import pytest

from slipwave.input.schema import json_schema
from slipwave.sources import ROOT
from tests.slipwave.test_read_wrong import FULL, LAYERS, SI, changed
from validation.commands.cli import main

SCHEMA = json_schema()
TYPES = {"object": dict, "array": list, "string": str, "number": (int, float)}


def accepts(schema, value):
    """Whether `value` is valid by `schema`, for the words of JSON Schema that the schema of scenes uses."""
    if "$ref" in schema:
        return accepts(SCHEMA["$defs"][schema["$ref"].rpartition("/")[2]], value)
    checks = {
        "type": lambda name: isinstance(value, TYPES[name]) and not isinstance(value, bool),
        "const": lambda word: value == word,
        "enum": lambda words: value in words,
        "minimum": lambda low: value >= low,
        "maximum": lambda high: value <= high,
        "minItems": lambda least: len(value) >= least,
        "maxItems": lambda most: len(value) <= most,
        "minLength": lambda least: len(value) >= least,
        "maxLength": lambda most: len(value) <= most,
        "pattern": lambda pattern: re.search(pattern, value),
        "required": lambda keys: set(keys) <= set(value),
        "properties": lambda known: all(accepts(known[key], item) for key, item in value.items() if key in known),
        "additionalProperties": lambda no: set(value) <= set(schema["properties"]),
        "items": lambda item: all(accepts(item, one) for one in value),
        "prefixItems": lambda items: all(map(accepts, items, value)),
        "anyOf": lambda some: any(accepts(one, value) for one in some),
        "oneOf": lambda some: sum(accepts(one, value) for one in some) == 1,
    }
    silent = {"$defs", "$schema", "title", "description", "examples", "default", "discriminator"}
    return all(checks[word](schema[word]) for word in sorted(schema, key=lambda word: word != "type") if word not in silent)


@pytest.mark.parametrize("path", sorted((ROOT / "slipwave" / "gallery").glob("*.toml")), ids=lambda path: path.stem)
def test_every_scene_of_the_gallery_is_valid(path):
    assert accepts(SCHEMA, tomllib.loads(path.read_text()))


@pytest.mark.parametrize(
    ("data", "key", "value", "valid"),
    [
        (FULL, "upper.epsilon", 1e-5, True),
        (FULL, "upper.epsilon", 0.0, False),
        (FULL, "upper.epsilom", 1.0, False),
        (FULL, "interface.b", ..., False),
        (FULL, "upper.face.kind", "machine", False),
        (FULL, "upper.layers", LAYERS[:1], False),
        (FULL, "drive.velocity", [["0 s", "1 um/s"], [5.0, 0.0]], True),
        (FULL, "run.until", "60 s", True),
        (FULL, "name", "n" * 201, False),
        (SI, "slab.density", "2.7 g/cm3", True),
    ],
)
def test_a_change_of_one_key(data, key, value, valid):
    assert accepts(SCHEMA, changed(data, key, value)) is valid


def test_the_command_prints_it(capsys):
    assert main(["schema"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert (printed, printed["$schema"]) == (SCHEMA, "https://json-schema.org/draft/2020-12/schema")
