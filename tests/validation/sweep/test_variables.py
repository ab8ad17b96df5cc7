"""Variables of one's own in sweeps, branches, curves and fits, axes of words, mixed units: the scenes that they mean."""

import json

import numpy as np
import pytest
import xarray

import slipwave as sw
from slipwave.errors import SceneError
from slipwave.friction import LAWS
from validation.commands.cli import main
from validation.models.expression import Undefined, value_at

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


ENV = {"q": (3.0, ""), "zero": (0.0, ""), "h": (0.2, "m")}


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


GOUGE = """
import math
from typing import NamedTuple
from slipwave.friction import register

class Gouge(NamedTuple):
    a: float = 0.0349
    b: float = 0.0489
    r: float = 0.0
    thickness: float = 1.0

def respond(law, z, psi):
    v, age, a, b = math.exp(z), math.exp(psi), law.a + law.r, law.b * law.thickness
    return v, v, 0.4 + a * z + b * psi, a, b, 1.0 / age - v, -v, -1.0 / age

register("gouge", Gouge, respond)
"""


def test_parameters_of_a_law_may_have_the_names_of_keys_of_a_slab(tmp_path):
    """Before, to set `interface.r` put `interface.thickness` back to its default, and figures said that it was a length in m."""
    (tmp_path / "gouge.py").write_text(GOUGE)
    scene = {**sw.read("paper").tables, "interface": {"law": "gouge", "thickness": 1.05}}
    axes = {"interface.r": [0.0, 0.002], "interface.thickness": [1.0, 1.05]}
    own = {"law": str(tmp_path / "gouge.py")}
    try:
        weaker, stronger = (sw.stability(scene, **own, **{"interface.r": r}).summary["epsilon_c"] for r in axes["interface.r"])
        # epsilon_c = (b - a) tan(r w_c/2)/(w_c/2), (40): here b is 1.05 times as large, and a larger by r
        for found, a in ((weaker, 0.0349), (stronger, 0.0369)):
            half = 50.0 * np.sqrt(0.0489 * 1.05 / a - 1.0)
            assert found == pytest.approx((0.0489 * 1.05 - a) * np.tan(10**-2.68 * half) / half, rel=1e-9)
        found = sw.sweep(scene, vary=axes, measure="stability", workers=1, **own)
        assert found.dataset["epsilon_c"].values.ravel()[[1, 3]] == pytest.approx([weaker, stronger], rel=1e-12)
        assert [axis.label_in(found.plan.scenes.base) for axis in found.plan.axes] == list(axes)
    finally:
        LAWS.pop("gouge", None)


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
    with pytest.raises(SceneError, match=r"^refine: interface\."):
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


TRIPS = {"upper.r": "0.00209*s", "lower.r": "0.00209*s"}
ALIKE = {key: UNLIKE[key] for key in ("upper.epsilon", "lower.epsilon")}


def words(sets):
    return [word for key, text in sets.items() for word in ("--set", f"{key}={text}")]


@pytest.mark.parametrize("q", [1.0, 3.0, 10.0])
def test_with_equal_round_trips_unlike_slabs_are_alike_ones_of_twice_the_impedance(q):
    """1/Z = 1/epsilon_1 + 1/epsilon_2; Z = 1.4e-5 here."""
    alike = sw.orbit("paper", **{"slab.r": 0.00209, "slab.epsilon": 2.8e-5})
    found = sw.sweep("paper", vary={"q": [q]}, set=UNLIKE | {"p": 1}, measure="orbit", workers=1).dataset
    assert (alike.stable, found["stable"].item()) == (True, "yes")
    for name in ("period", "stress_drop"):
        assert found[name].item() == pytest.approx(alike.facts[name], rel=1e-12)


def test_a_branch_over_a_variable_is_one_of_the_scenes_written_out(tmp_path):
    out = str(tmp_path / "p.nc")
    found = sw.branch("paper", over=("p", 1.05, 1.5), set=UNLIKE | {"q": 2}, most_points=5, out=out)
    assert [point.scene for point in found.points] == [sw.read("paper", unlike(2.0, point["p"])) for point in found.points]
    assert found.summary["set"] == UNLIKE | {"q": 2}
    own = sw.orbit("paper", **unlike(2.0, 1.05))
    assert found.points[0]["period"] == pytest.approx(own.period, rel=1e-5)
    again = sw.branch(out)  # with the expressions that the file holds
    assert again.summary["points"] == found.summary["points"]
    further = sw.branch("paper", over="p=1.05:1.5", set=UNLIKE | {"q": 2}, most_points=7, resume=out)
    assert further.summary["points"][:5] == found.summary["points"]
    with pytest.raises(SceneError, match=r"set is .*'q': 2.*this branch has .*'q': 3"):
        sw.branch("paper", over="p=1.05:1.5", set=UNLIKE | {"q": 3}, most_points=8, resume=out)
    assert list(xarray.load_dataset(out).attrs["parameter"]) == ["p"]


def test_a_fold_does_not_see_the_ratio_of_impedances(tmp_path):
    """A curve of folds over log10 r and q with equal round trips: log10 r is that of alike slabs, which other programs know, for
    all q; then again from its file."""
    out = tmp_path / "c.nc"
    found = sw.curve("paper", of="LP", over="log10_r=-2.72:-2.68", along="q=1.5:6", set=ALIKE, most_points=4, out=out)
    points = found.summary["points"]
    assert len(points) == 4
    assert points[-1]["q"] > 1.52
    assert [point["log10_r"] for point in points] == pytest.approx([-2.7002517033] * 4, abs=5e-9)
    again = sw.curve(out).summary["points"]
    assert again == points


def test_a_curve_of_hopf_points_over_variables_is_where_roots_are_neutral(capsys):
    sets = {**ALIKE, "upper.r": "s*0.002", "lower.r": "1.4*s*0.002"}
    assert main(["curve", "paper", "--of", "HB", "--over", "s=0.3:1.5", "--and", "q=1:9", *words(sets), "--json"]) == 0
    points = json.loads(capsys.readouterr().out)["points"]
    assert len(points) > 10
    for point in points[:: len(points) // 4]:
        q, s = point["q"], point["s"]
        upper, lower = {"epsilon": 1.4e-5 * (1.0 + q) / q, "r": s * 0.002}, {"epsilon": 1.4e-5 * (1.0 + q), "r": 1.4 * s * 0.002}
        changes = {f"{slab}.{key}": one for slab, own in (("upper", upper), ("lower", lower)) for key, one in own.items()}
        scene = sw.read("paper", changes)
        root = sw.stability(scene).summary["leading_roots"][0]
        assert abs(root[0]) < 1e-7 * abs(root[1])


def test_a_curve_begins_on_a_branch_over_variables(tmp_path):
    """With its expressions; what the branch sets and the curve varies is no longer set."""
    sets, out = ALIKE | {"q": 2}, tmp_path / "b.nc"
    branch = sw.branch("paper", over="s=0.912:1", set=sets | TRIPS, stop_at="LP", out=out)
    assert [one["type"] for one in branch.special][-1] == "LP"
    own = sw.curve(start=out, point="LP1", along="q=2:3", most_points=2)
    assert own.summary["points"][0]["s"] == pytest.approx(branch.special[-1]["s"], abs=1e-7)
    assert own.summary["set"] == ALIKE | TRIPS


def test_a_fit_finds_a_variable(tmp_path):
    """a = s, b = q s, L = 2 h: the same scenes as those of a, b and L, so that the intervals agree; then again from its file."""
    times, thin = np.linspace(0.0, 119.0, 1500), {"slab.thickness": "20 cm"}
    run = sw.run("velocity-steps", "quasidynamic", interface=True, **thin)
    transit = sw.read("velocity-steps", thin).units.size("transit", sw.read("velocity-steps", thin).transit)
    friction = np.interp(times, run.dataset["time"].values * transit, run.dataset["interface_stress"].values)
    noise = 1e-4 * np.random.default_rng(3).standard_normal(times.size)
    np.savetxt(tmp_path / "steps.csv", np.column_stack([times, friction + noise]))
    call = {"data": [str(tmp_path / "steps.csv")], "columns": "time,friction", "model": "quasidynamic"}
    sets = {**thin, "interface.a": "s", "interface.b": "q*s", "interface.memory_length": "2*h"}
    found = sw.fit("velocity-steps", free=["s=0.013", "q=1.2,h=8 um"], set=sets, **call)
    rows = found.summary["parameters"]
    assert sw.fit("velocity-steps", free={"s": 0.013, "q": 1.2, "h": "8 um"}, set=sets, **call).summary["parameters"] == rows
    for name, value in {"s": 0.01, "q": 1.5, "h": 5e-6}.items():
        assert rows[name]["low"] < value < rows[name]["high"], name
        assert rows[name]["high"] - rows[name]["low"] < 0.05 * value
    assert (rows["h"]["unit"], rows["h"]["start"]) == ("m", 8e-6)
    keys = ["interface.a", "interface.b", "interface.memory_length"]
    aside = {**thin, "interface.a": 0.013, "interface.memory_length": "16 um"}
    own = sw.fit("velocity-steps", free=keys, **aside, **call).summary
    assert rows["s"]["value"] == pytest.approx(own["parameters"]["interface.a"]["value"], rel=1e-4)
    assert rows["s"]["high"] == pytest.approx(own["parameters"]["interface.a"]["high"], rel=1e-3)
    assert rows["q"]["value"] == pytest.approx(own["parameters"]["interface.b"]["value"] / rows["s"]["value"], rel=1e-4)
    found.to_netcdf(tmp_path / "fit.nc")
    again = sw.fit(tmp_path / "fit.nc")
    assert again.summary["parameters"]["q"]["start"] == pytest.approx(rows["q"]["value"], rel=1e-12)
    assert again.summary["evaluations"] < found.summary["evaluations"]
