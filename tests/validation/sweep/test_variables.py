"""Variables of one's own, axes of words and mixed units: the scenes that they mean, and one line for whatever is wrong."""

import json

import numpy as np
import pytest
import xarray

import slipwave as sw
from slipwave.errors import SceneError
from validation.commands.cli import main
from validation.models.expression import Undefined, Value, value_at

UNLIKE = {
    "upper.epsilon": "1.4e-5*(1+q)/q",
    "lower.epsilon": "1.4e-5*(1+q)",
    "upper.r": "0.00209*(1+q)/(q+p)",
    "lower.r": "0.00209*p*(1+q)/(q+p)",
}
"""Unlike slabs: q the ratio of impedances, p that of round trips, at one impedance and stiffness of the interface."""
OURS = "tests.validation.sweep_measures:disc"


def unlike(q, p):
    return {
        "upper.epsilon": 1.4e-5 * (1.0 + q) / q,
        "lower.epsilon": 1.4e-5 * (1.0 + q),
        "upper.r": 0.00209 * (1.0 + q) / (q + p),
        "lower.r": 0.00209 * p * (1.0 + q) / (q + p),
    }


ENV = {"q": Value(3.0), "zero": Value(0.0), "h": Value(0.2, "m")}


@pytest.mark.parametrize(
    ("text", "number", "unit"),
    [
        ("1.4e-5*(1+q)/q", 1.4e-5 * (1.0 + 3.0) / 3.0, ""),
        ("-q**2 + 2**-1 - 2**3**2", -9.0 + 0.5 - 512.0, ""),
        ("sqrt(4) + log10(1e3) + exp(0) + log(1) - - q", 2.0 + 3.0 + 1.0 + 3.0, ""),
        ("10 um/s * q", 1e-5 * 3.0, "m/s"),
        ("1 GPa/m / q", 1e9 / 3.0, "Pa/m"),
        ("2e-3 /um", 2e3, "1/m"),
        ("h + 30 cm", 0.2 + 0.3, "m"),
        ("h / 0.1 m", 2.0, ""),
        ("30 cm * (q/3)", 0.3, "m"),
    ],
)
def test_arithmetic(text, number, unit):
    assert value_at(text, ENV) == (number, unit)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("q +", "ends too early"),
        ("", "ends too early"),
        ("(q", "a parenthesis is not closed"),
        ("q)", "unexpected '\\)'"),
        ("2 q", "unexpected 'q'"),
        ("q.real", "unexpected '.'"),
        ("q // 2", "unexpected '/'"),
        ("__import__('os')", "'__import__' is no function; there are sqrt, exp, log, log10"),
        ("sin(q)", "'sin' is no function"),
        ("s + q", "'s' is no variable; there are q, zero, h"),
        ("2 xyz * q", "'xyz' is neither a variable nor a unit of a scene"),
        ("h + 1", "a number in m and a pure number cannot be added"),
        ("h * h", "a number in m cannot be multiplied by a number in m"),
        ("q ** h", "an exponent must be a pure number"),
        ("log(h)", "the argument of log must be a pure number"),
        ("q / 0 +", "ends too early"),
        ("-" * 200 + "q", "nested more than 50 deep"),
        ("(" * 200 + "q" + ")" * 200, "nested more than 50 deep"),
        ("q+" * 600 + "q", "longer than 1000 characters"),
    ],
)
def test_a_text_that_is_no_arithmetic(text, told):
    with pytest.raises(SceneError, match=told) as caught:
        value_at(text, ENV)
    assert not isinstance(caught.value, Undefined)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("1/zero", "division by zero"),
        ("log(zero)", "no real value"),
        ("(-8)**0.5", "no real value"),
        ("9**9**9**9", "too large"),
        ("exp(1e9)", "too large"),
        ("1e999 * q", "too large"),
    ],
)
def test_arithmetic_without_a_value(text, told):
    with pytest.raises(Undefined, match=told):
        value_at(text, ENV)


def test_a_point_of_a_sweep_over_variables_is_the_scene_written_out(tmp_path):
    """To the bit, also where the folder is gone on with, and in the gathered file."""
    out = str(tmp_path / "one")
    found = sw.sweep("paper", vary={"q": (1, 10, 4), "p": [1, 1.4142, 2]}, set=UNLIKE, measure=OURS, out=out, workers=1)
    for number in range(12):
        q, p = found.plan.axes[0].values[number // 3], found.plan.axes[1].values[number % 3]
        mine, wanted = found.plan.scene(number), sw.read("paper", unlike(q, p))
        assert (mine, mine.digest, mine.tables) == (wanted, wanted.digest, wanted.tables)
    texts = [word for key, text in UNLIKE.items() for word in ("--set", f"{key}={text}")]
    axes = ["--vary", "q=1:10:4", "--vary", "p=1,1.4142,2"]
    line = ["sweep", "paper", *axes, *texts, "--measure", OURS, "--out", out]
    assert main([*line, "--workers", "1"]) == 0  # the same sweep, which is finished
    assert main(["sweep", str(tmp_path / "one"), "--measure", OURS, "--gather"]) == 0
    data = xarray.load_dataset(tmp_path / "one" / "sweep.nc")
    assert data["height"].dims == ("q", "p")
    assert json.loads(data.attrs["manifest"])["set"] == UNLIKE
    again = sw.sweep(tmp_path / "one", measure=OURS)
    assert (again.summary["computed_now"], again.summary["set"]) == (0, UNLIKE)
    assert again.plan.scene(7) == found.plan.scene(7)


def test_another_expression_is_another_sweep(tmp_path, refused):
    words = ["sweep", "paper", "--vary", "q=1:2:2", "--measure", OURS, "--workers", "1", "--out", str(tmp_path / "x")]
    assert main([*words, "--set", "slab.r=0.002*q"]) == 0
    assert "holds another sweep (set: slab.r changed)" in refused(*words, "--set", "slab.r=0.003*q")


def test_variables_defined_by_variables_and_units():
    found = sw.sweep(
        "paper-si",
        vary={"h": "0.02 m:3 cm:2"},
        set={"slab.thickness": "thick", "thick": "h * share", "share": "h / 1 cm", "drive.velocity": "10 um/s * share"},
        measure=OURS,
        workers=1,
    )
    wanted = sw.read("paper-si", {"slab.thickness": f"{0.03 * 3.0!r} m", "drive.velocity": f"{1e-5 * 3.0!r} m/s"})
    assert found.plan.scene(1) == wanted


def test_a_point_without_a_value_has_a_status(capsys):
    found = sw.sweep("paper", vary={"q": [-1.0, 0.0, 1.0]}, set={"slab.r": "0.002/q"}, measure=OURS, workers=1)
    assert found.dataset["status"].values.tolist() == [1, 1, 0]
    reasons = found.dataset["reason"].values
    assert reasons[0].startswith("slab.r = -0.002: must be")
    assert reasons[1] == "slab.r = '0.002/q': division by zero at q = 0"


def test_axes_of_words(tmp_path):
    """Keys that one word needs are ignored where another has none; the words are coordinates."""
    sets = {"face.stiffness": 0.5, "face.impedance": "z"}
    words = {"interface.law": "ageing,slip", "face.kind": "rigid,grip"}
    found = sw.sweep("paper", vary={**words, "z": [0.5, 1.0]}, set=sets, measure="stability", out=tmp_path / "words", workers=1)
    for number, (law, kind, z) in enumerate((a, b, c) for a in ("ageing", "slip") for b in ("rigid", "grip") for c in (0.5, 1.0)):
        face = {"kind": kind} | ({"stiffness": 0.5, "impedance": z} if kind == "grip" else {})
        assert found.plan.scene(number) == sw.read("paper", {"interface.law": law, "slab.face": face})
    found.to_netcdf(tmp_path / "words.nc")
    data = xarray.load_dataset(tmp_path / "words.nc")
    mine = data["log10_r_c"].sel(interface_law="slip", slab_face_kind="grip", z=1.0).item()
    wanted = {"interface.law": "slip", "face.kind": "grip", "face.stiffness": 0.5, "face.impedance": 1.0}
    assert mine == sw.stability("paper", **wanted).summary["log10_r_c"]
    assert np.ptp(data["log10_r_c"].sel(slab_face_kind="rigid").values, axis=-1).max() == 0.0
    shown = sw.map(tmp_path / "words").chart().panels[0].traces
    assert [trace.name for trace in shown] == [
        f"delay, {law}, {kind}" for law in ("ageing", "slip") for kind in ("rigid", "grip")
    ]
    with pytest.raises(SceneError, match=r"^--refine: interface\."):
        sw.sweep("paper", vary=words | {"face.kind": ["rigid"]}, refine=1)


def test_units_may_differ_along_an_axis():
    mixed, metres = (
        sw.sweep("paper-si", vary={"slab.thickness": text}, measure=OURS, workers=1).plan.axes[0]
        for text in ("2 cm:0.05 m:4", "0.02 m:0.05 m:4")
    )
    assert mixed == metres
    assert mixed.unit == "m"


def test_a_table_of_scenes_may_have_variables(tmp_path):
    (tmp_path / "rows.csv").write_text("q,interface.law\n1,ageing\n3,slip\n,slip\n")
    rows = str(tmp_path / "rows.csv")
    found = sw.sweep("paper", rows=rows, set={"slab.epsilon": "2.8e-5*q"}, measure=OURS, out=tmp_path / "rows", workers=1)
    assert found.plan.scene(1) == sw.read("paper", {"slab.epsilon": 2.8e-5 * 3.0, "interface.law": "slip"})
    again = sw.sweep(tmp_path / "rows", measure=OURS, gather=True)
    assert again.dataset["status"].values.tolist() == [0, 0, 1]
    assert again.dataset["reason"].values[2].startswith("slab.epsilon = '2.8e-5*q': 'q' is no variable")
