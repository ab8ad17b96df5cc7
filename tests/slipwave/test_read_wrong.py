"""Every key wrong in every way is one SceneError of one line that names the key."""

import copy
import math
import os
import random
import re
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

import slipwave
from slipwave.errors import NumericsError, SceneError
from slipwave.input.wording import nearest, shorten
from slipwave.scene import Scene

LAYERS = [{"fraction": 0.5, "impedance": 1.0}, {"fraction": 0.5, "impedance": 2.0}]
SLAB = {"epsilon": 2.8e-5, "r": 0.002, "viscosity": {"kind": "standard-linear", "time": 1e-3, "ratio": 1.0}, "layers": LAYERS}
FULL: dict[str, Any] = {
    "name": "full",
    "interface": {"law": "slip", "a_star": 0.369, "a": 0.0349, "b": 0.0489},
    "upper": SLAB | {"face": {"kind": "grip", "stiffness": 1.0, "impedance": 1.0}},
    "lower": {"epsilon": 1e-5, "log10_r": -2.5, "face": {"kind": "reflection", "coefficient": 0.5}},
    "drive": {"velocity": 100.0},
    "start": {"kind": "jump", "size": 0.1},
    "run": {"until": 10.0, "record": ["events"]},
}
SI: dict[str, Any] = {
    "interface": FULL["interface"] | {"normal_stress": 1e3, "memory_length": 0.9e-6, "reference_velocity": 1e-6},
    "slab": {"density": 784.0, "shear_modulus": 1e6, "thickness": 0.03, "viscosity": {"kind": "kelvin-voigt", "time": 1e-5}},
    "drive": {"velocity": 100.0},
}
NUMBERS = [
    *((FULL, key) for key in ("interface.a_star", "interface.a", "interface.b", "upper.epsilon", "upper.r", "lower.log10_r")),
    *((FULL, key) for key in ("upper.face.stiffness", "upper.face.impedance", "lower.face.coefficient")),
    *((FULL, key) for key in ("upper.viscosity.time", "upper.viscosity.ratio", "drive.velocity", "start.size", "run.until")),
    *((FULL, key) for key in ("upper.layers.0.fraction", "upper.layers.1.impedance")),
    *((SI, f"interface.{key}") for key in ("normal_stress", "memory_length", "reference_velocity")),
    *((SI, key) for key in ("slab.density", "slab.shear_modulus", "slab.thickness", "slab.viscosity.time")),
]
WORDS = ["interface.law", "upper.face.kind", "upper.viscosity.kind", "start.kind"]
TABLES = ["interface", "upper", "lower", "upper.face", "upper.viscosity", "upper.layers", "drive", "start", "run"]
NOT_NUMBERS = [True, False, "1", "", "nan", [1.0], [], {}, {"x": 1}, math.nan, math.inf, -math.inf, 1e300, -1e300, 10**400, "\n"]


def changed(data: dict[str, Any], key: str, value: Any) -> dict[str, Any]:
    result = copy.deepcopy(data)
    place: Any = result
    *above, last = key.split(".")
    for part in above:
        place = place[int(part) if part.isdigit() else part]
    if value is ...:
        del place[last]
    else:
        place[last] = value
    return result


def complaint(source: Any, overrides: Any = ()) -> str:
    with pytest.raises(SceneError) as caught:
        slipwave.read(source, overrides)
    message = str(caught.value)
    assert len(message.splitlines()) == 1
    assert message.isprintable()
    assert len(message) < 500
    return message


def outcome(source: Any, overrides: Any = ()) -> tuple[Scene | None, str]:
    try:
        return slipwave.read(source, overrides), ""
    except SceneError as error:
        return None, str(error)


def test_the_scenes_that_are_about_to_be_spoilt_are_right() -> None:
    assert slipwave.read(FULL).name == "full"
    assert slipwave.read(SI).units is not None
    assert not issubclass(SceneError, NumericsError)


@pytest.mark.parametrize(("data", "key"), NUMBERS, ids=[key for _, key in NUMBERS])
@pytest.mark.parametrize("value", NOT_NUMBERS, ids=repr)
def test_numbers(data: dict[str, Any], key: str, value: Any) -> None:
    message = complaint(changed(data, key, value))
    assert key in message
    assert "must be a" in message


@pytest.mark.parametrize(("data", "key"), NUMBERS, ids=[key for _, key in NUMBERS])
def test_signs(data: dict[str, Any], key: str) -> None:
    if key not in ("interface.a_star", "lower.log10_r", "lower.face.coefficient", "start.size"):
        assert f"{key} = -1" in complaint(changed(data, key, -1.0))
    if key not in (
        "interface.a_star",
        "interface.b",
        "upper.face.impedance",
        "lower.log10_r",
        "lower.face.coefficient",
        "start.size",
    ):
        assert f"{key} = 0" in complaint(changed(data, key, 0))


@pytest.mark.parametrize("key", WORDS)
@pytest.mark.parametrize(
    "value", [1, True, "", "Slip", "grips", [], ["slip"], {}, "x" * 10_000, "a\nb"], ids=lambda v: repr(v)[:12]
)
def test_words(key: str, value: Any) -> None:
    message = complaint(changed(FULL, key, value))
    assert key in message
    assert "must be" in message


@pytest.mark.parametrize("key", TABLES)
@pytest.mark.parametrize("value", [1, True, "x", [1], math.nan, [[1]]], ids=repr)
def test_tables(key: str, value: Any) -> None:
    assert key in complaint(changed(FULL, key, value))


@pytest.mark.parametrize("key", [key for data, key in NUMBERS if data is FULL and key not in ("start.size", "run.until")])
def test_missing(key: str) -> None:
    named = "lower.r" if key == "lower.log10_r" else key
    assert f"{named}: missing; must be" in complaint(changed(FULL, key, ...))


@pytest.mark.parametrize("key", ["interface", "upper", "lower", "drive", "interface.law", "upper.viscosity.kind"])
def test_missing_tables(key: str) -> None:
    assert key in complaint(changed(FULL, key, ...))


def test_slabs_are_given_once_for_both_or_once_for_each() -> None:
    neither = changed(changed(FULL, "upper", ...), "lower", ...)
    assert "slab: missing; must be [slab] (both alike) or both [upper] and [lower]" in complaint(neither)
    assert "lower: missing; [upper] needs [lower] too" in complaint(changed(FULL, "lower", ...))
    assert "upper: missing; [lower] needs [upper] too" in complaint(changed(FULL, "upper", ...))


@pytest.mark.parametrize(
    ("key", "near"),
    [
        ("interface.astar", "a_star"),
        ("upper.epsilom", "epsilon"),
        ("upper.log_r", "log10_r"),
        ("upper.face.stifness", "stiffness"),
        ("upper.layers.1.impedence", "impedance"),
        ("upper.viscosity.ratios", "ratio"),
        ("drive.velocty", "velocity"),
        ("start.sise", "size"),
        ("run.unti", "until"),
        ("runs", "run"),
        ("log10_r", "slab.log10_r"),
        ("lower.face.stiffness", '"grip"'),
    ],
)
def test_an_unknown_key_names_the_nearest(key: str, near: str) -> None:
    message = complaint(changed(FULL, key, 1.0))
    assert key in message
    assert near in message.partition("unknown key")[2]


def test_keys_that_exclude_each_other() -> None:
    slab = {"epsilon": 1e-5, "r": 1e-3}
    assert "upper" in complaint(FULL | {"slab": slab})
    assert "lower" in complaint(changed(FULL, "upper", ...) | {"slab": slab})
    assert "upper.log10_r" in complaint(changed(FULL, "upper.log10_r", -2))
    assert "slab.density" in complaint(changed(SI, "slab.epsilon", 1e-5))
    assert "slab.shear_modulus: missing" in complaint(changed(SI, "slab.shear_modulus", ...))
    assert "interface.memory_length" in complaint(changed(SI, "interface.memory_length", ...))
    assert "slab.density" in complaint(SI | {"interface": FULL["interface"]})
    assert "upper.thickness" in complaint(changed(changed(FULL, "upper.thickness", 0.1), "upper.r", ...))


EPSILON_KEYS = {"slab.density", "slab.shear_modulus", "interface.normal_stress", "interface.reference_velocity"}
ROUND_TRIP_KEYS = {
    "slab.density",
    "slab.shear_modulus",
    "slab.thickness",
    "interface.memory_length",
    "interface.reference_velocity",
}


@pytest.mark.parametrize(
    ("key", "value", "result", "sources"),
    [
        ("slab.density", 1e-15, "epsilon = 3.16227766e-14, which must be a number from 1e-12 to 1e+06", EPSILON_KEYS),
        ("slab.shear_modulus", 1e-15, "epsilon = 8.85", EPSILON_KEYS),
        ("interface.normal_stress", 1e15, "epsilon = 2.8e-17", EPSILON_KEYS),
        ("interface.reference_velocity", 1e15, "epsilon = 2.8e+16", EPSILON_KEYS),
        ("slab.thickness", 1e15, "r = 6.2", ROUND_TRIP_KEYS),
        ("interface.memory_length", 2.0, "r = 8.4e-10, which must be a number from 1e-09 to 1e+06", ROUND_TRIP_KEYS),
        ("interface.memory_length", 1e-15, "r = 1680000", ROUND_TRIP_KEYS),
        ("interface.reference_velocity", 1e-13, "r = 1.86666667e-10", ROUND_TRIP_KEYS),
    ],
)
def test_a_derived_number_out_of_range_names_all_it_came_from(key: str, value: float, result: str, sources: set[str]) -> None:
    message = complaint(changed(SI, key, value))
    assert f"{key} = {value:g}" in message
    assert f"result in {result}" in message
    assert set(re.findall(r"[a-z]+\.[a-z_]+", message)) == sources


@pytest.mark.parametrize(
    "ramps",
    [
        [],
        [[]],
        [1, 2],
        [[0, 1], [0, 2], [0, 3]],
        [[1, 1], [0, 2]],
        [[0, 0], [1, 2]],
        [[0, 1], [1, -2]],
        [[0, 1, 2]],
        [[0, True]],
        [["0", 1]],
        [[math.nan, 1]],
        [[0, math.inf]],
        [[-1, 1]],
        {"x": 1},
    ],
    ids=repr,
)
def test_ramps(ramps: Any) -> None:
    assert "drive.velocity" in complaint(changed(FULL, "drive.velocity", ramps))


@pytest.mark.parametrize(
    "layers", [[], LAYERS[:1], [LAYERS[0]] * 3, [{}, {}], [[0.5, 1], [0.5, 1]], [{"fraction": 1e-9}] * 200], ids=len
)
def test_layers(layers: Any) -> None:
    assert "upper.layers" in complaint(changed(FULL, "upper.layers", layers))


@pytest.mark.parametrize(("excess", "accepted"), [(0.0, True), (9e-10, True), (-9e-10, True), (1.1e-9, False), (-1.1e-9, False)])
def test_fractions_add_up_to_one_but_for_rounding(excess: float, accepted: bool) -> None:
    scene = changed(FULL, "upper.layers", [LAYERS[0], LAYERS[1] | {"fraction": 0.5 + excess}])
    if accepted:
        assert sum(layer.fraction for layer in slipwave.read(scene).upper.layers) == pytest.approx(1.0, abs=1e-15)
    else:
        assert "must be fractions of the round trip that add up to 1, not " in complaint(scene)


def test_what_is_nested_is_shown_to_the_second_level() -> None:
    assert shorten([[[[1]], 2], 3]) == "[[[...], 2], 3]"
    assert shorten(list(range(9))) == "[0, 1, 2, ...]"


@pytest.mark.parametrize("text", ["", "=", "x", "=1", "slab", "slab..r=1", "slab.r", "slab r=1", "slab.r=", "slab.r=1 2", "é=1"])
def test_override_texts(text: str) -> None:
    complaint("paper", [text])


def test_a_monstrous_value_is_cut_short_after_its_control_characters_are_spelled_out() -> None:
    monster = {f"{letter * 40}": "\x85" * 40 for letter in "\x81\x82\x83"}
    assert len(complaint(changed(FULL, "upper.epsilon", monster))) < 300


def test_overrides_that_name_no_key() -> None:
    for wrong in (3, [3], (1, 2)):
        assert "must be KEY=VALUE, as in slab.log10_r=-2.3" in complaint("paper", wrong)
    assert "slab.r = '1\\n" in complaint("paper", ["slab.r=1\nx=2"])
    assert "slab.epsilon.x" in complaint("paper", ["slab.epsilon.x=1"])
    assert "slob" in complaint("paper", ["slob.x=1"])
    assert "slab.epsilom" in complaint("paper", {"slab.epsilom": 1})


@pytest.mark.parametrize(
    "source", ["papr", "no-such.toml", "", ".", "/", os.devnull, "\0", "x" * 5000, "a/b/c", 3, None, ["paper"]], ids=repr
)
def test_sources_that_are_no_scene(source: Any) -> None:
    assert "SCENE" in complaint(source)


def test_an_unknown_name_is_told_the_nearest() -> None:
    assert 'did you mean "paper-si"' in complaint("papersi")


@pytest.mark.parametrize(
    "content",
    [
        b"\xff\xfe",
        random.Random(0).randbytes(10_000_000),
        b"x" * 1_000_001,
        b"[",
        b"a = ",
        b"[" * 100_000,
        b"a = " + b"[" * 5000,
        b"x = 1" + b"0" * 5000,
        b"",
        b"\0",
        b"slab = 1\n[slab]\n",
        b'{"json": 1}',
        b"import os",
        b"a = 1\na = 2",
        b"x = 2026-01-01",
    ],
    ids=lambda content: repr(content[:8]) + str(len(content)),
)
def test_files_that_are_no_scene(tmp_path: Path, content: bytes) -> None:
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
def test_junk_anywhere_is_read_or_refused_in_one_line(place: tuple[dict[str, Any], str], value: Any) -> None:
    data, key = place
    read, message = outcome(changed(data, key, value))
    if read is None:
        assert len(message.splitlines()) == 1
        assert key.partition(".")[0] in message
    else:
        assert all(math.isfinite(x) and x > 0 for slab in (read.upper, read.lower) for x in (slab.epsilon, slab.round_trip))
        assert 0 < read.velocity < math.inf


@given(st.dictionaries(st.text(max_size=12), junk, max_size=5))
def test_junk_scenes_are_refused_in_one_line(data: dict[str, Any]) -> None:
    complaint(data)


@given(st.sampled_from(["slab.r", "drive.velocity", "interface", "x"]), st.text(max_size=30))
def test_junk_overrides_are_read_or_refused_in_one_line(key: str, text: str) -> None:
    _, message = outcome("paper", [f"{key}={text}"])
    assert len(message.splitlines()) <= 1


@pytest.mark.parametrize(("cutoff", "found"), [(0.5, "velocity"), (0.7, None)])
def test_how_much_like_a_known_word_another_must_be(cutoff: float, found: str | None) -> None:
    """Two thirds of the letters of `velo` and `velocity` together are common to both."""
    assert nearest("velo", ["epsilon", "velocity"], cutoff) == found


def test_half_like_a_known_word_is_enough() -> None:
    assert nearest("stop", ["size"]) is None
    assert nearest("rabc", ["redc"]) == "redc"
