"""`slipwave curve`: where curves begin, the closed form of the Hopf curve, and what is refused."""

import math
from dataclasses import replace

import pytest
import xarray

import slipwave as sw
from validation.branches import followed
from validation.branches.curve import Curve
from validation.branches.followed import Ended, read_followed
from validation.branches.parameter import over_range
from validation.cli import NUMERICS_FAILED
from validation.references.onset import onset_of

KEYS = {"schema", "scene", "model", "clock", "type", "parameters", "points", "wall_s", "notes"}
GIVEN = {"of": "LP", "over": "log10_r=-2.72:-2.68", "and": "V=100:120"}
FOLDS = ("paper", "LP", "log10_r=-2.72:-2.69", "V=100:120", "kelvin-voigt")
FIRST, SECOND = (over_range(text, "paper") for text in ("log10_r=-2.72:-2.68", "V=100:120"))


def words(**changes):
    """The command line of a curve of the paper's scene."""
    given = (GIVEN | changes).items()
    return ["curve", "paper", *(word for name, value in given if value for word in (f"--{name}", value))]


def test_the_first_fold_of_the_delay_system():
    """Its place at V = 100 is that of other programs; towards larger V its period falls."""
    found = sw.curve("paper", "LP", "log10_r=-2.72:-2.68", "V=100:120", most_points=4).summary
    assert found.keys() == KEYS
    assert (found["type"], found["parameters"], found["model"]) == ("LP", ["log10_r", "V"], "delay")
    first, *others = found["points"]
    assert (first["log10_r"], first["V"]) == (pytest.approx(-2.7002517033, abs=5e-9), 100.0)
    assert first["period"] == pytest.approx(59.1074327, abs=1e-5)
    assert (first["unstable_before"], first["unstable_after"]) == (1, 0)
    assert [a["V"] < b["V"] and a["period"] > b["period"] for a, b in zip([first, *others], others, strict=False)] == [True] * 3
    assert found["notes"] == ["stopped after 4 points: --most-points goes further"]


def test_a_curve_ends_at_the_edge_of_its_ranges():
    """The first torus point of the delay system in r and epsilon."""
    result = sw.curve("paper", "NS", "log10_r=-2.72:-2.64", "epsilon=2.8e-5:2.806e-5")
    points = result.summary["points"]
    assert points[0]["log10_r"] == pytest.approx(-2.6575457126, abs=5e-9)
    assert points[0]["period"] == pytest.approx(78.2632597, abs=2e-6)
    assert points[0]["multiplier"] == pytest.approx([-0.111491, 0.993765], abs=2e-6)
    assert all(2.8e-5 <= point["epsilon"] <= 2.806e-5 and point["bracket"] < 1e-9 for point in points)
    assert result.summary["notes"] == ["the curve leaves the rectangle of both ranges"]
    assert result.dataset.attrs["command"] == "curve"


def test_keys_of_the_scene_span_a_plane():
    """In SI, also beside a short name, which is set in the scene that is read."""
    texts = ("slab.thickness=31 mm:34 mm", "interface.normal_stress=1 kPa:1.1 kPa", "V=100:120")
    first, second, over = (over_range(text, "paper-si") for text in texts)
    keyed = {"slab.thickness": 0.032, "interface.normal_stress": 1050.0}
    assert Curve("LP", first, second, "delay", 1e-4).plane.scene_at(0.032, 1050.0) == sw.read("paper-si", keyed)
    mixed = Curve("LP", over, second, "delay", 1e-4).plane.scene_at(110.0, 1050.0)
    assert mixed.velocity == 110.0
    assert mixed.transit == sw.read("paper-si", {"interface.normal_stress": 1050.0}).transit


def test_hopf_points_are_those_of_the_closed_form(tmp_path, monkeypatch):
    """r_c = (2/omega_c) atan(r_* omega_c/2) (39) at every V, and T = 2 pi/(omega_c r_c). The file holds them, and the call that
    computes them again; what is given holds instead."""
    file = tmp_path / "hopf.nc"
    points = sw.curve("paper", "HB", "log10_r=-2.8:-2.6", "V=90:110", "delay", out=file).summary["points"]
    with xarray.open_dataset(file) as data:
        assert data["period"].values.tolist() == [point["period"] for point in points]
    assert len(points) > 5
    for point in points:
        closed = onset_of(sw.read("paper").law, 2.8e-5, point["V"])
        assert 10.0 ** point["log10_r"] == pytest.approx(closed.r_delay, rel=1e-10)
        assert point["period"] == pytest.approx(2.0 * math.pi / (closed.omega_c * closed.r_delay), rel=1e-10)
    monkeypatch.setattr("validation.results.curve.pursue", lambda *parts: Ended(0.0, None, "", False))
    again, other = sw.curve(file), sw.curve(file, along="V=90:91", tol=1e-4)
    call = {"of": "HB", "over": "log10_r=-2.8:-2.6", "and": "V=90:110", "tol": 1e-6, "most_points": 100}
    assert (again.options.stored, again.found.model, again.found.kind) == (call, "delay", "HB")
    assert (other.options.stored, other.found.second.ends) == (call | {"and": "V=90:91", "tol": 1e-4}, (90.0, 91.0))


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        ({"of": "XX"}, "--of 'XX': must be one of HB, LP, PD, NS"),
        ({"and": "V=100"}, "--and 'V=100': must be KEY=FROM:TO"),
        ({"and": "V=100:100"}, "--and 'V=100:100': FROM and TO must differ"),
        ({"and": "log10_r=-2:-3"}, "--and 'log10_r': must be another parameter than --over"),
        (
            {"of": "HB", "and": "interface.a_star=0.3:0.4"},
            "--and 'interface.a_star': a curve of Hopf points needs one of r, epsilon, V",
        ),
        ({"and": "V=-5:7"}, "drive.velocity = -5.0: must be a number from 1e-12"),
        ({"of": "HB", "resume": "x.nc"}, "--resume: a curve of Hopf points is computed at once"),
        *(({name: None}, f"--{name}: missing; must be given, as in --{name} {GIVEN[name]}") for name in GIVEN),
    ],
)
def test_what_is_refused(refused, changes, line):
    assert refused(*words(**changes)).startswith(f"slipwave: {line}")


def test_a_curve_needs_a_beginning(refused):
    told = refused(*words(of="PD", over="log10_r=-2.72:-2.695"), "--tol", "1e-4", status=NUMERICS_FAILED)
    assert "no period doubling was found on the branch over log10_r from -2.72 to -2.695" in told


def test_a_curve_goes_on_to_the_same_points(tmp_path, monkeypatch):
    """Stopped after one point and after three, when the secant is part of the state; then the whole file is as without a stop.
    Until the last point is there, the file says that it is not complete."""
    file, whole, complete, write = tmp_path / "part.nc", tmp_path / "whole.nc", [], followed.write_followed
    monkeypatch.setattr(followed, "write_followed", lambda *parts: [complete.append(parts[3]), write(*parts)])
    expected = sw.curve(*FOLDS, tol=1e-4, most_points=4, out=whole).found.points
    assert (len(expected), complete) == (4, [False] * 4 + [True])
    for most in (1, 3, 4):
        found = sw.curve(*FOLDS, tol=1e-4, most_points=most, out=file, resume=file if most > 1 else None)
        assert found.found.points == expected[:most]
        assert found.summary["notes"] == [f"stopped after {most} points: --most-points goes further"]
    with xarray.open_dataset(file) as resumed, xarray.open_dataset(whole) as direct:
        xarray.testing.assert_equal(resumed, direct)
        assert resumed["point_second"].values.tolist() == [point.second for point in expected]


@pytest.mark.parametrize(
    ("fact", "changes"),
    [
        ("scene", {"over": over_range("log10_r=-2.72:-2.68", sw.read("paper", {"interface.a": 0.03491}))}),
        ("model", {"model": "kelvin-voigt"}),
        ("type", {"kind": "NS"}),
        ("rectangle", {"over": over_range("log10_r=-2.72:-2.69", "paper")}),
        ("rectangle", {"second": over_range("V=100:121", "paper")}),
        ("rectangle", {"second": over_range("epsilon=100:120", "paper")}),
        ("sources", {}),
    ],
)
def test_every_fact_of_another_curve_is_refused(tmp_path, monkeypatch, fact, changes):
    path, own = tmp_path / "x.nc", Curve("LP", FIRST, SECOND, "delay", 1e-6)
    monkeypatch.setattr(Curve, "saved", lambda *parts: {})
    followed.write_followed(path, own, None, False, {})
    with pytest.raises(sw.SceneError, match="is no file of a curve, or damaged"):  # no points, but the same facts
        read_followed(path, own)
    if fact == "sources":
        monkeypatch.setattr("validation.branches.curve.source_digest", lambda: "of another version")
    with pytest.raises(sw.SceneError, match=rf"x\.nc': {fact} is "):
        read_followed(path, replace(own, **changes))
