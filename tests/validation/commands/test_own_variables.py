"""Variables of one's own in branches, curves and fits: the scenes that they mean, files that are gone on with, one line for
whatever is wrong."""

import json

import numpy as np
import pytest
import xarray

import slipwave as sw
from slipwave.errors import SceneError
from validation.commands.cli import main

UNLIKE = {
    "upper.epsilon": "1.4e-5*(1+q)/q",
    "lower.epsilon": "1.4e-5*(1+q)",
    "upper.r": "0.00209*(1+q)/(q+p)",
    "lower.r": "0.00209*p*(1+q)/(q+p)",
}
"""Unlike slabs: q the ratio of impedances, p that of round trips, at one impedance and stiffness of the interface."""
ALIKE = {key: UNLIKE[key] for key in ("upper.epsilon", "lower.epsilon")}


def unlike(q, p):
    return sw.read(
        "paper",
        {
            "upper.epsilon": 1.4e-5 * (1.0 + q) / q,
            "lower.epsilon": 1.4e-5 * (1.0 + q),
            "upper.r": 0.00209 * (1.0 + q) / (q + p),
            "lower.r": 0.00209 * p * (1.0 + q) / (q + p),
        },
    )


def words(sets):
    return [word for key, text in sets.items() for word in ("--set", f"{key}={text}")]


@pytest.mark.parametrize("q", [1.0, 3.0, 10.0])
def test_with_equal_round_trips_unlike_slabs_are_alike_ones_of_twice_the_impedance(q):
    """1/Z = 1/epsilon_1 + 1/epsilon_2; Z = 1.4e-5 here."""
    period = sw.orbit("paper", **{"slab.r": 0.00209, "slab.epsilon": 2.8e-5}).period
    found = sw.sweep("paper", vary={"q": [q]}, set=UNLIKE | {"p": 1}, measure="orbit", workers=1)
    assert found.dataset["period"].item() == pytest.approx(period, rel=1e-12)


def test_a_branch_over_a_variable_is_one_of_the_scenes_written_out(tmp_path):
    out = str(tmp_path / "p.nc")
    found = sw.branch("paper", over=("p", 1.05, 1.5), set=UNLIKE | {"q": 2}, most_points=5, out=out)
    assert [point.scene for point in found.points] == [unlike(2.0, point["p"]) for point in found.points]
    assert found.summary["set"] == UNLIKE | {"q": 2}
    own = sw.orbit(unlike(2.0, 1.05))
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


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("branch paper --over q=1:10", "'q' is no parameter; must be one of"),
        ("branch paper --over q=0:10 --set slab.r=0.002/q", "slab.r = '0.002/q': division by zero at q = 0"),
        ("branch paper --over q=-1:10 --set slab.r=0.002*q", "slab.r = -0.002: must be"),
        ("branch paper --over q=1:10 --set slab.r=0.002*sin(q)", "'sin' is no function"),
        ("branch paper --over q=1:10 --set slab.rr=0.002*q", "slab.rr = '0.002*q': unknown key"),
        ("branch paper --over q=1:10 --set q=2 --set slab.r=0.002*q", "--set q: is varied"),
        ("branch paper --over a=0.03:0.04 --set slab.r=0.002*a", "a: a variable must have a name"),
        ("branch paper --over 'q=1m:2m' --set slab.r=0.002*q", "slab.r = '0.002 m': must be a number from"),
        ("curve paper --of LP --over log10_r=-2.72:-2.68 --and q=1:0 --set slab.epsilon=2.8e-5/q", "division by zero at q = 0"),
        ("curve paper --of LP --over q=1:2 --and q=1:3 --set slab.epsilon=2.8e-5/q", "--and 'q': must be another parameter"),
        ("curve paper --of LP --over q=1:2 --and p=1:3 --set slab.epsilon=2.8e-5/q", "'p' is no parameter"),
    ],
)
def test_bad_variables_are_one_line(line, told, refused):
    import shlex

    assert told in refused(*shlex.split(line))
