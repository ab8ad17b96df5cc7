"""Variables of one's own in branches, curves and fits: the scenes that they mean, files that are gone on with."""

import json

import numpy as np
import pytest
import xarray

import slipwave as sw
from slipwave.errors import SceneError
from tests.validation.sweep.test_variables import UNLIKE, unlike
from validation.commands.cli import main

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
    """A curve of folds over log10 r and q with equal round trips: log10 r is the same for all q; then again from its file."""
    out = tmp_path / "c.nc"
    found = sw.curve("paper", of="LP", over="log10_r=-2.72:-2.68", along="q=1.5:6", set=ALIKE, most_points=4, out=out)
    points = found.summary["points"]
    assert len(points) == 4
    assert points[-1]["q"] > 1.52
    assert np.ptp([point["log10_r"] for point in points]) < 1e-8
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
    assert (
        sw.fit("velocity-steps", free={"s": 0.013, "q": 1.2, "h": "8 um"}, set=sets, **call).summary["parameters"]
        == found.summary["parameters"]
    )
    rows = found.summary["parameters"]
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
