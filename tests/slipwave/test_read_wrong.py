"""Every key wrong in every way is one SceneError of one line that names the key, and is refused by the JSON Schema."""

import copy
import json
import math
import os
import random
import re
import tomllib
from functools import reduce

import pytest
from hypothesis import given
from hypothesis import strategies as st

import slipwave
from slipwave.errors import SceneError
from slipwave.input.schema import json_schema
from slipwave.sources import ROOT
from validation.commands.cli import main

LAYERS = [{"fraction": 0.5, "impedance": 1.0}, {"fraction": 0.5, "impedance": 2.0}]
SLAB = {"epsilon": 2.8e-5, "r": 0.002, "viscosity": {"kind": "standard-linear", "time": 1e-3, "ratio": 1.0}, "layers": LAYERS}
FULL = {
    "name": "full",
    "interface": {"law": "slip", "a_star": 0.369, "a": 0.0349, "b": 0.0489},
    "upper": SLAB | {"face": {"kind": "grip", "stiffness": 1.0, "impedance": 1.0}},
    "lower": {"epsilon": 1e-5, "log10_r": -2.5, "face": {"kind": "reflection", "coefficient": 0.5}},
    "drive": {"velocity": 100.0},
    "start": {"kind": "jump", "size": 0.1},
    "run": {"until": 10.0, "record": ["events"]},
}
SI = {
    "interface": FULL["interface"] | {"normal_stress": 1e3, "memory_length": 0.9e-6, "reference_velocity": 1e-6},
    "slab": {"density": 784.0, "shear_modulus": 1e6, "thickness": 0.03, "viscosity": {"kind": "kelvin-voigt", "time": 1e-5}}
    | {"face": {"kind": "machine", "stiffness": 1e9, "impedance": 1e5, "mass": 9.0}},
    "drive": {"velocity": 100.0},
}
HELD = {"interface": FULL["interface"], "slab": {"epsilon": 1e-5, "r": 0.002}, "machine": {"k": 1e-3}, "drive": {"velocity": 1.0}}
NUMBERS = [
    *((FULL, key) for key in ("interface.a_star", "interface.a", "interface.b", "upper.epsilon", "upper.r", "lower.log10_r")),
    *((FULL, key) for key in ("upper.face.stiffness", "upper.face.impedance", "lower.face.coefficient")),
    *((FULL, key) for key in ("upper.viscosity.time", "upper.viscosity.ratio", "drive.velocity", "start.size", "run.until")),
    *((FULL, key) for key in ("upper.layers.0.fraction", "upper.layers.1.impedance")),
    *((SI, f"interface.{key}") for key in ("normal_stress", "memory_length", "reference_velocity")),
    *((SI, key) for key in ("slab.density", "slab.shear_modulus", "slab.thickness", "slab.viscosity.time")),
    *((SI, f"slab.face.{key}") for key in ("stiffness", "impedance", "mass")),
    (HELD, "machine.k"),
]
WORDS = ["interface.law", "upper.face.kind", "upper.viscosity.kind", "start.kind"]
TABLES = ["interface", "upper", "lower", "upper.face", "upper.viscosity", "upper.layers", "drive", "start", "run"]
NOT_NUMBERS = [True, False, "1", "", "nan", [1.0], [], {}, {"x": 1}, math.nan, math.inf, -math.inf, 1e300, -1e300, 10**400, "\n"]


def changed(data, key, value):
    result = copy.deepcopy(data)
    place = result
    *above, last = key.split(".")
    for part in above:
        place = place[int(part) if part.isdigit() else part]
    if value is ...:
        del place[last]
    else:
        place[last] = value
    return result


def complaint(source, overrides=()):
    with pytest.raises(SceneError) as caught:
        slipwave.read(source, overrides)
    message = str(caught.value)
    assert len(message.splitlines()) == 1
    assert message.isprintable()
    assert len(message) < 500
    return message


@pytest.mark.parametrize(("key", "wrong"), [
    ("interface.a_star", "astar"), ("drive.velocity", "velocty"), ("upper.epsilon", "epsilom"),
    ("upper.layers.1.impedance", "impedence"),
    ("upper.face.stiffness", "stifness"), ("upper.viscosity.ratio", "ratios"), ("interface", "interfaces"), ("drive", "drives"),
])  # fmt: skip
def test_a_misspelt_key_is_named_before_the_one_that_is_then_missing(key, wrong):
    above, _, right = key.rpartition(".")
    misspelt = f"{above}.{wrong}".lstrip(".")
    value = reduce(lambda table, part: table[int(part) if part.isdigit() else part], key.split("."), FULL)
    told = complaint(changed(changed(FULL, misspelt, value), key, ...))
    assert told.startswith(f"{misspelt} = ")
    assert told.endswith(f"unknown key; did you mean {right}?")


def outcome(source, overrides=()):
    try:
        return slipwave.read(source, overrides), ""
    except SceneError as error:
        return None, str(error)


@pytest.mark.parametrize(("data", "key"), NUMBERS, ids=[key for _, key in NUMBERS])
@pytest.mark.parametrize("value", NOT_NUMBERS, ids=repr)
def test_numbers(data, key, value):
    message = complaint(changed(data, key, value))
    assert key in message
    assert "must be a" in message


MAY_BE_NEGATIVE = ("interface.a_star", "lower.log10_r", "lower.face.coefficient", "start.size")


@pytest.mark.parametrize(("data", "key"), NUMBERS, ids=[key for _, key in NUMBERS])
def test_signs(data, key):
    if key not in MAY_BE_NEGATIVE:
        assert f"{key} = -1" in complaint(changed(data, key, -1.0))
    if key not in (*MAY_BE_NEGATIVE, "interface.b", "upper.face.impedance") and not key.startswith("slab.face"):
        assert f"{key} = 0" in complaint(changed(data, key, 0))


@pytest.mark.parametrize(("key", "values"), [
    *((key, [1, True, "", "Slip", "grips", [], ["slip"], {}, "x" * 10_000, "a\nb"]) for key in WORDS),
    *((key, [1, True, "x", [1], math.nan, [[1]]]) for key in TABLES),
    ("drive.velocity", [[], [[]], [1, 2], [[0, 1], [0, 2], [0, 3]], [[1, 1], [0, 2]], [[0, 0], [1, 2]], [[0, 1], [1, -2]]]),
    ("drive.velocity", [[[0, 1, 2]], [[0, True]], [["0", 1]], [[math.nan, 1]], [[0, math.inf]], [[-1, 1]], {"x": 1}, ...]),
    ("upper.layers", [[], LAYERS[:1], [LAYERS[0]] * 3, [{}, {}], [[0.5, 1], [0.5, 1]], [{"fraction": 1e-9}] * 200]),
])  # fmt: skip
def test_words_tables_and_lists(key, values):
    for value in values:
        assert re.search(rf"{key}.*(must|missing)", complaint(changed(FULL, key, value)))


@pytest.mark.parametrize("key", [key for data, key in NUMBERS if data is FULL and key not in ("start.size", "run.until")])
def test_missing(key):
    named = "lower.r" if key == "lower.log10_r" else key
    assert f"{named}: missing; must be" in complaint(changed(FULL, key, ...))


BOTH = {"epsilon": 1e-5, "r": 1e-3}


@pytest.mark.parametrize(
    ("data", "key", "value", "told"),
    [
        (FULL, "interface", ..., "interface: missing; must be a table"),
        (changed(FULL, "upper", ...), "lower", ..., "slab: missing; must be [slab] (both alike) or both [upper] and [lower]"),
        (FULL, "lower", ..., "lower: missing; [upper] needs [lower] too"),
        (FULL, "slab", BOTH, "upper: must not be given together with slab"),
        (FULL, "upper.log10_r", -2, "upper.log10_r = -2: must not be given together with upper.r"),
        (SI, "slab.epsilon", 1e-5, "slab.density = 784: must not be given together with slab.epsilon"),
        (SI, "interface.memory_length", ..., "interface.memory_length: missing"),
        (SI, "interface", FULL["interface"], "slab.density = 784: must come with"),
        (changed(FULL, "upper.thickness", 0.1), "upper.r", ..., "upper.thickness = 0.1: must come with"),
        (FULL, "upper.log_r", 1.0, "did you mean log10_r?"),
        (FULL, "start.sise", 1.0, "did you mean size?"),
        (FULL, "log10_r", 1.0, "did you mean slab.log10_r?"),
        (FULL, "lower.face.stiffness", 1.0, 'it belongs to kind "grip" or "machine", not to kind "reflection"'),
        (changed(FULL, "interface.law", "ageing-cutoff"), "interface.saturation_velocity", 1.0, 'belongs to law "spinodal"'),
        (FULL, "start.stop", 1.0, "[start] takes kind, size"),
        (FULL, "interface.law", ..., "interface.law: missing; must be "),
        (FULL, "interface.law", "aging", 'must be "ageing", "slip", '),
    ],
)  # fmt: skip
def test_keys_that_are_missing_unknown_or_do_not_fit_together(data, key, value, told):
    assert told in complaint(changed(data, key, value))


EPSILON_KEYS = {"slab.density", "slab.shear_modulus", "interface.normal_stress", "interface.reference_velocity"}
ROUND_TRIP_KEYS = EPSILON_KEYS - {"interface.normal_stress"} | {"slab.thickness", "interface.memory_length"}


@pytest.mark.parametrize(
    ("key", "value", "result", "sources"),
    [
        ("slab.density", 1e-15, "epsilon = 3.16227766e-14, which must be a number from 1e-12 to 1e+06", EPSILON_KEYS),
        ("interface.reference_velocity", 1e15, "epsilon = 2.8e+16", EPSILON_KEYS),
        ("slab.thickness", 1e15, "r = 6.2", ROUND_TRIP_KEYS),
        ("interface.memory_length", 2.0, "r = 8.4e-10, which must be a number from 1e-09 to 1e+06", ROUND_TRIP_KEYS),
    ],
)
def test_a_derived_number_out_of_range_names_all_it_came_from(key, value, result, sources):
    message = complaint(changed(SI, key, value))
    assert f"{key} = {value:g}" in message
    assert f"result in {result}" in message
    assert set(re.findall(r"[a-z]+\.[a-z_]+", message)) == sources


@pytest.mark.parametrize(("excess", "accepted"), [(0.0, True), (9e-10, True), (-9e-10, True), (1.1e-9, False), (-1.1e-9, False)])
def test_fractions_add_up_to_one_but_for_rounding(excess, accepted):
    scene = changed(FULL, "upper.layers", [LAYERS[0], LAYERS[1] | {"fraction": 0.5 + excess}])
    if accepted:
        assert sum(layer.fraction for layer in slipwave.read(scene).upper.layers) == pytest.approx(1.0, abs=1e-15)
    else:
        assert "must be fractions of the round trip that add up to 1, not " in complaint(scene)


@pytest.mark.parametrize("text", ["", "=", "x", "=1", "slab", "slab..r=1", "slab.r", "slab r=1", "slab.r=", "slab.r=1 2", "é=1"])
def test_override_texts(text):
    complaint("paper", [text])


@pytest.mark.parametrize(
    ("overrides", "told"),
    [
        *((wrong, "must be KEY=VALUE, as in slab.log10_r=-2.3") for wrong in (3, [3], (1, 2))),
        (["slab.r=1\nx=2"], "slab.r = '1\\n"),
        (["slab.epsilon.x=1"], "slab.epsilon.x"),
        (["slob.x=1"], "slob"),
        ({"slab.epsilom": 1}, "slab.epsilom"),
    ],
)
def test_overrides_that_name_no_key(overrides, told):
    assert told in complaint("paper", overrides)


@pytest.mark.parametrize("key", [3, 2.5, None, (1, 2), b"a"], ids=repr)
@pytest.mark.parametrize("table", ["", "slab", "slab.face"])
def test_keys_that_are_no_text(key, table):
    source = reduce(lambda below, name: {name: below}, filter(None, reversed(table.split("."))), {key: 1.0})
    assert complaint(source) == f"{table}{'.' * bool(table)}{key!r}: must be a text, as every key of a scene"


@pytest.mark.parametrize(
    "source", ["papr", "no-such.toml", "", ".", "/", os.devnull, "\0", "x" * 5000, "a/b/c", 3, None, ["paper"]], ids=repr
)
def test_sources_that_are_no_scene(source):
    assert "SCENE" in complaint(source)
    assert 'did you mean "paper-si"' in complaint("papersi")


@pytest.mark.parametrize(
    "content",
    [
        b"\xff\xfe",
        random.Random(0).randbytes(10_000_000),
        b"x" * 1_000_001,
        b"a = " + b"[" * 5000,
        b"x = 1" + b"0" * 5000,
        b"",
        b"slab = 1\n[slab]\n",
        b"x = 2026-01-01",
    ],
    ids=lambda content: repr(content[:8]) + str(len(content)),
)
def test_files_that_are_no_scene(tmp_path, content):
    path = tmp_path / "bad.toml"
    path.write_bytes(content)
    complaint(path)


junk = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20) | st.dates(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=10), inner, max_size=4),
    max_leaves=8,
)
places = st.sampled_from([(FULL, key) for key in [*WORDS, *TABLES]] + NUMBERS)


@given(places, junk)
def test_junk_anywhere_is_read_or_refused_in_one_line(place, value):
    data, key = place
    read, message = outcome(changed(data, key, value))
    if read is None:
        assert len(message.splitlines()) == 1
        assert key.partition(".")[0] in message
    else:
        assert all(math.isfinite(x) and x > 0 for slab in (read.upper, read.lower) for x in (slab.epsilon, slab.round_trip))
        assert 0 < read.velocity < math.inf


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
