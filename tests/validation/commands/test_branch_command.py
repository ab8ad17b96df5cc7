"""`slipwave branch` and `curve`: special points against AUTO-07p, DDE-BIFTOOL and closed forms; what is stopped and goes on."""

import json
import math
import re
import signal
import tomllib
from dataclasses import replace
from itertools import islice
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray
from scipy.optimize import minimize_scalar

import slipwave as sw
from reduced.stability.critical import critical_round_trip
from tests.copies import interrupted
from validation.commands.branch import BranchOptions, BranchResult
from validation.commands.cli import INTERRUPTED
from validation.data.variables import EVENTS, cycle_in_si
from validation.models import followed
from validation.models.branch import FollowedBranch
from validation.models.curve import Curve
from validation.models.ends import SpecialEnds
from validation.models.followed import ends_of, read_branch
from validation.models.orbits import find_orbit
from validation.models.parameter import over_range
from validation.models.points import StopAt
from validation.references.onset import onset_of
from validation.references.published import reference_orbit

RANGE = "log10_r=-2.72:-2.68"
AROUND = ("--over", RANGE, "--tol", "1e-4")
COARSE = ("paper", "--model", "kelvin-voigt", *AROUND)
SHORT = (*COARSE, "--most-points", "24")
FOR_GOOD = ", and does not return within a quarter of the range"


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    path = tmp_path_factory.mktemp("branch") / "x.nc"
    return sw.branch("paper", RANGE, "kelvin-voigt", tol=1e-4, out=path), path


@pytest.mark.parametrize(
    ("model", "hopf", "born", "fold", "turn"),
    [
        ("kelvin-voigt", -2.69954994745, 49.66821032, -2.700213011, 58.471805),
        ("delay", -2.6995497159, 49.66818383, -2.700251703, 59.107433),
    ],
)
def test_a_branch_is_born_and_turns_where_other_programs_say(answer, whole, model, hopf, born, fold, turn):
    """Measured: folds 4e-9 off on this mesh; at a fold the period hardly matters, 1.3e-6. One of them stops there."""
    stops = model == "delay"
    found = answer("branch", "paper", "--model", model, *AROUND, "--stop-at", "LP") if stops else whole[0].summary
    birth, first_fold = found["special"]
    assert [birth["type"], first_fold["type"]] == ["HB", "LP"]
    assert (birth["log10_r"], birth["period"]) == (pytest.approx(hopf, abs=1e-10), pytest.approx(born, abs=1e-7))
    assert first_fold["log10_r"] == pytest.approx(fold, abs=5e-8)
    assert first_fold["period"] == pytest.approx(turn, rel=2e-5)
    assert first_fold["bracket"] < 1e-9
    assert [(one["unstable_before"], one["unstable_after"]) for one in (birth, first_fold)] == [(0, 2), (1, 0)]
    states = [(point["unstable"], point["stable"]) for point in found["points"]]
    above = states.count((0, True))
    assert (states, above == 1) == ([(1, False)] * (len(states) - above) + [(0, True)] * above, stops)


def test_it_passes_through_known_orbits_and_its_file_holds_it(whole):
    result, path = whole
    found = result.summary
    upper = [point for point in found["points"] if point["stable"]][-3:]
    known, values = reference_orbit("kelvin-voigt", -2.68), np.array([point["log10_r"] for point in upper])
    for name in ("period", "stress_drop", "elastic_stress_drop"):
        _, value = np.polyfit(values + 2.68, [point[name] for point in upper], 1)
        assert value == pytest.approx(known[name], rel=2e-3)
    assert all(-2.72 <= point["log10_r"] <= -2.68 for point in found["points"])
    with xarray.open_dataset(path) as data:
        assert data.attrs["complete"] == 1
        assert data["point_period"].values[: len(found["points"])].tolist() == [point["period"] for point in found["points"]]
        assert data["special_kind"].values.tolist() == [special["type"] for special in found["special"]]
        assert data["special_value"].values.tolist() == [special["log10_r"] for special in found["special"]]


def test_pieces_of_one_stability_meet_at_special_points(whole):
    found = read_branch(whole[1], "--branch")
    for panel, name in zip(
        BranchResult(found, BranchOptions(), 0.0).chart().panels, ("period", "stress_drop", "elastic_stress_drop"), strict=True
    ):
        ends = {trace.name: np.column_stack([trace.x, trace.y])[[0, -1]].tolist() for trace in panel.traces}
        stable, unstable = ends["stable"], ends["unstable"]
        birth, fold = ([special.value, getattr(special, name)] for special in found.special)
        assert (unstable, stable[0]) == ([birth, fold], fold)


def test_a_branch_stopped_before_its_first_point_names_no_file_that_is_not_there():
    nothing = BranchResult(None, BranchOptions(), 0.0)
    told = "--resume a.nc goes on from there"
    assert nothing.to_go_on(BranchOptions(out=Path("x.nc"))) == ""
    assert nothing.to_go_on(BranchOptions(resume=Path("a.nc"))) == told
    assert nothing.to_go_on(BranchOptions(resume=Path("a.nc"), out=Path("x.nc"))) == told


@pytest.mark.parametrize(("by", "kept"), [(signal.SIGINT, True), (signal.SIGKILL, True), (signal.SIGINT, False)])
def test_a_branch_that_was_stopped_goes_on_to_the_same_points(by, kept, tmp_path, answer, whole, monkeypatch):
    done = interrupted(["branch", *SHORT, "--json", *(["--out", "x.nc"] if kept else [])], 12.0, tmp_path, by)
    if by is signal.SIGINT:
        way = "--resume x.nc goes on from there" if kept else "no file was kept: --out FILE.nc keeps one to go on from"
        assert (done.returncode, done.stderr.splitlines()[-1]) == (INTERRUPTED, f"slipwave: interrupted after 12 points; {way}")
        assert len(json.loads(done.stdout)["points"]) == 12
    if not kept:
        return
    monkeypatch.chdir(tmp_path)
    with xarray.open_dataset("x.nc") as data:
        assert (data.attrs["complete"], data.sizes["point"]) == (0, 12)
    resumed, at_once = answer("branch", *SHORT, "--resume", "x.nc"), whole[0].summary
    assert resumed["points"] == at_once["points"][:24]
    assert resumed["special"] == at_once["special"][:1]


def test_without_a_hopf_point_it_begins_with_an_orbit(answer):
    found = answer("branch", "paper", "--model", "kelvin-voigt", "--over", "log10_r=-2.68:-2.69", "--tol", "1e-4")
    values = [point["log10_r"] for point in found["points"]]
    assert (found["special"], values[0]) == ([], -2.68)
    assert found["points"][0]["period"] == pytest.approx(reference_orbit("kelvin-voigt", -2.68)["period"], rel=1e-6)
    assert values == sorted(values, reverse=True)
    assert values[-1] >= -2.69
    assert found["notes"] == [f"the branch leaves the range at log10_r = -2.69{FOR_GOOD}"]


def test_on_a_coarse_grid_whose_own_hopf_point_lies_elsewhere_it_begins_with_an_orbit():
    """That of two cells of `dg:1` is -2.6996196, 7e-5 before that of the waves; before, the steady state "does not oscillate"."""
    found = sw.branch("paper", "log10_r=-2.7:-2.68", "dg:1", cells=2, tol=1e-4, most_points=1).summary
    orbit = sw.orbit("paper", "dg:1", cells=2, tol=1e-4, settings=["slab.log10_r=-2.68"]).summary
    assert (found["special"], found["points"][0]["log10_r"]) == ([], -2.68)
    assert found["points"][0]["period"] == pytest.approx(orbit["period"], rel=1e-6)
    assert found["notes"][0].endswith("is not that of the waves, log10_r = -2.699549716: more --cells bring it nearer")


def test_over_one_round_trip_it_begins_where_a_first_mesh_cannot_follow_the_slip_event():
    """A mesh for both ends of the range, none of whose steps is a wave's time, needs shorter steps than that of the orbit."""
    slabs = {"upper.log10_r": -2.632, "lower.log10_r": -2.622, "upper.epsilon": 2.34e-5, "lower.epsilon": 2.31e-5}
    found = sw.branch(sw.read("unlike", slabs), "upper.r=0.0024439249845710424:0.0021995", most_points=2)
    orbit = sw.orbit("unlike", **slabs | {"upper.r": 0.0024439249845710424}).summary
    assert found.summary["points"][0]["period"] == pytest.approx(orbit["period"], rel=1e-10)


def test_a_branch_that_dips_out_of_its_range_comes_back(whole, tmp_path):
    """Its fold at -2.70021 is not listed, its orbits there are in the file alone, and the chart has a gap."""
    found = sw.branch("paper", "log10_r=-2.70:-2.69", "kelvin-voigt", tol=1e-4, out=tmp_path / "x.nc")
    values = [point["log10_r"] for point in found.points]
    assert (min(values) >= -2.70, min(point.value for point in found.followed.points)) == (
        True,
        pytest.approx(-2.700213, abs=1e-5),
    )
    assert [special["type"] for special in found.special] == ["HB"]
    periods = [point["period"] for point in found.points]
    left = next(k for k, period in enumerate(periods) if period > 56.0)
    assert (found.points[left - 1]["unstable"], found.points[left]["unstable"]) == (1, 0)
    assert periods[left - 1] < 55.5 < 60.5 < periods[left] < periods[-1]
    other = [(one["log10_r"], one["period"]) for one in whole[0].summary["points"] if one["stable"]]
    expected = np.interp(-2.691, *zip(*other, strict=True))
    assert np.interp(-2.691, values[left:], periods[left:]) == pytest.approx(expected, rel=1e-3)
    assert found.summary["notes"] == [f"the branch leaves the range at log10_r = -2.69{FOR_GOOD}"]
    drawn = [np.asarray(trace.y) for trace in found.chart().panels[0].traces[:2]]
    assert [bool(((y > 55.5) & (y < 60.5)).any()) for y in drawn] == [False, False]


def test_a_branch_may_end_where_scenes_do():
    scene = sw.read("paper", {"slab.face": {"kind": "reflection", "coefficient": 0.999}})
    found = sw.branch(scene, "face.coefficient=0.9999:1", tol=1e-4)
    assert found.followed.points[-1].value == pytest.approx(1.0, abs=1e-9)
    assert found.summary["notes"][-1].startswith("the branch leaves the range at face.coefficient = 1: the branch cannot ")


def test_undecided_stability_is_null_with_its_reason(answer, tmp_path):
    """Unlike slabs of irrational ratio have motions that friction never damps. A file keeps what is not counted."""
    words, file = ["unlike-irrational", "--over", "log10_r=-2.6:-2.5", "--tol", "1e-3", "--most-points"], str(tmp_path / "u.nc")
    answer("branch", *words, "2", "--out", file)
    found = answer("branch", *words, "3", "--resume", file)
    assert [(point["stable"], point["unstable"]) for point in found["points"]] == [(None, None)] * 3
    assert found["notes"][0].startswith("stability is not decided where the essential radius is 1")
    assert found["notes"][0].endswith("so of the special points only HB and LP are found")


def test_stability_is_said_without_idle_modes():
    """Round trips in a ratio of 1:3: neutral modes that the interface does not feel. The orbit called stable is where a run
    settles; on the way the unstable pair of orbits between two folds is told apart."""
    scene = sw.read("unlike", ["upper.r=0.00244", "lower.r=0.00732"])
    found = sw.branch(scene, "log10_r=-2.78:-2.69", tol=1e-4)
    points = found.summary["points"]
    assert all(point["idle"] for point in points)
    assert [special["type"] for special in found.special] == ["HB", "LP", "LP", "LP"]
    assert {(point["stable"], point["unstable"]) for point in points} == {(False, 1), (True, 0)}
    assert found.summary["notes"][0].startswith(
        "stability, numbers of unstable multipliers, and PD and NS found by them, are said "
    )
    last = found.points[-1]
    orbit, run = sw.orbit(last, tol=1e-6), sw.run(last.scene)
    assert (orbit.stable, last["stable"]) == (True, True)
    assert any("but for which the orbit is stable" in note for note in orbit.notes)
    assert (run.summary["verdict"], run.summary["period"]["mean"]) == ("periodic", pytest.approx(orbit.period, rel=1e-4))


def test_it_ends_where_orbits_shrink_to_steady_sliding():
    """The first small orbit, followed the wrong way: the Hopf point is met again, and nothing is counted twice."""
    found = FollowedBranch(over_range(RANGE, "paper"), "kelvin-voigt", 1e-4)
    end = found.begin()
    list(found.follow(end._replace(point=replace(end.point, tangent=-end.point.tangent)), StopAt(points=50)))
    assert [special.kind for special in found.special] == ["HB", "HB"]
    assert found.special[0].value == pytest.approx(found.special[1].value, abs=1e-12)
    assert found.notes == ["the branch ends where its orbits shrink to steady sliding"]
    assert len(found.points) < 10


@pytest.mark.parametrize("beyond", [-1e-10, 1e-12, 1e-10, 1e-9])
def test_an_onset_at_the_edge_of_the_range_begins_a_branch(beyond):
    """A root that grows by less than rounding errors is not counted, so that the onset may lie just outside of the range."""
    onset = -2.69954994745
    found = FollowedBranch(over_range(f"log10_r={onset + beyond!r}:-2.69", "paper"), "kelvin-voigt", 1e-4)
    assert len(list(islice(ends_of(found, StopAt()), 4))) == len(found.points) == 4
    assert (found.special[0].kind, found.special[0].value) == ("HB", pytest.approx(onset, abs=1e-10))


def test_a_range_may_have_units(printed):
    """As the key itself; a bare velocity is in V*. Listed values that differ are printed so, and periods in seconds beside."""
    over = over_range("slab.thickness=31 mm:34 mm", "paper-si")
    assert (over.first, over.last, over.written(0.032)) == (0.031, 0.034, "0.032 m")
    assert over.scene_at(0.032) == sw.read("paper-si", {"slab.thickness": 0.032})
    fast = over_range("drive.velocity=0.1 mm/s:0.2 mm/s", "paper-si")
    assert (fast.name, fast.first, fast.last) == ("V", pytest.approx(100.0), pytest.approx(200.0))
    assert fast.scene_at(150.0).velocity == 150.0
    words = ["paper-si", "--model", "kelvin-voigt", "--tol", "1e-4", "--most-points", "2"]
    printed = printed("branch", *words, "--over", "slab.thickness=31 mm:34 mm").splitlines()
    special, first, second = (line.split() for line in (printed[-7], printed[-4], printed[-3]))
    assert special[:2] == ["HB", "Hopf"]
    assert float(special[2]) == pytest.approx(0.03357797353158276 * 10 ** (2.68 - 2.69954994745), rel=1e-9)
    assert first[0] != second[0]
    transit = over.scene_at(float(first[0])).transit * sw.read("paper-si").units.time
    assert float(first[2]) == pytest.approx(float(first[1]) * transit, rel=1e-6)


@pytest.mark.parametrize(
    ("over", "changed"), [("slab.thickness=31 mm:34 mm", "period"), ("interface.normal_stress=900 Pa:1.1 kPa", "stress_drop")]
)
def test_figures_in_si_are_those_of_the_scene_of_their_point(over, changed):
    """The one parameter changes the length of a transit, the other the unit of stress."""
    found = sw.branch("paper-si", over, "kelvin-voigt", tol=1e-4, most_points=3)
    data, point = found.dataset, found.points[-1]
    known = cycle_in_si({name: point[name] for name in ("period", "stress_drop", "v_max")}, point.scene)["si"]
    del known["transit_s"]
    assert {name: float(data[name][-1]) for name in known} == pytest.approx(known, rel=1e-12)
    assert {name for name in EVENTS if name in data and "si_factor" not in data[name].attrs} >= {changed}


def test_a_branch_ends_at_its_longest_period(answer):
    short = answer("branch", *COARSE, "--longest-period", "51")
    assert short["points"][-2]["period"] < 51.0 < short["points"][-1]["period"]


def test_switched_it_follows_the_doubled_orbits_from_doubling_to_doubling(answer):
    found = answer(
        "branch", *["paper", "--model", "kelvin-voigt", "--over", "log10_r=-2.6:-2.57", "--tol", "1e-5", "--switch", "PD"]
    )
    born = [(special["type"], special["log10_r"], special["period"]) for special in found["special"]]
    assert born == [("PD", pytest.approx(-2.595727667, abs=1e-8), pytest.approx(2.0 * 78.994716174, abs=1e-6))]
    values, periods = np.array([[point["log10_r"], point["period"]] for point in found["points"]]).T
    assert np.all(np.diff(values) > 0.0)
    assert values[0] == pytest.approx(-2.595727667, abs=1e-5)
    assert values[-1] == pytest.approx(-2.579381814, abs=6e-4)  # the second doubling of the pair
    assert periods[[0, -1]] == pytest.approx([2.0 * 78.994716174, 2.0 * 79.26000895], rel=1e-4)
    assert all(point["stable"] for point in found["points"])
    assert found["notes"] == ["the branch ends at a period doubling, where both halves of its orbits become the same"]


def test_a_branch_goes_on_with_another_tolerance(answer, tmp_path):
    """The points that it has stay; the next ones lie on a finer mesh, and it passes through the known fold all the same."""
    path = str(tmp_path / "x.nc")
    few = answer("branch", *SHORT[:-1], "5", "--out", path)
    found = answer("branch", *COARSE[:-1], "1e-7", "--stop-at", "LP", "--resume", path)
    assert found["points"][:5] == few["points"]
    told = (
        f"points up to log10_r = {few['points'][-1]['log10_r']:.10g}, 5 in all, were computed with tol = 0.0001, those after it "
    )
    assert f"{told}with 1e-07" in found["notes"]
    assert found["special"][-1]["log10_r"] == pytest.approx(-2.700213011, abs=1e-9)


@pytest.mark.parametrize("name", ["mesh_levels", "monodromy", "metric"])
def test_a_damaged_file_is_not_gone_on_from(whole, tmp_path, refused, name):
    path = tmp_path / "x.nc"
    path.write_bytes(whole[1].read_bytes())
    with netCDF4.Dataset(path, "a") as file:
        file["resume"][name][:] = np.nan
    assert "x.nc': is no file of a branch, or damaged: its contents have changed since it was written" in refused(
        "branch", *COARSE, "--resume", str(path)
    )


@pytest.mark.parametrize("unit", [1.0, 1e-5])
def test_a_branch_is_the_same_whatever_the_unit_of_its_parameter(unit):
    """With V* smaller by `unit`, epsilon and r are, and V is larger. Before, the branch over an epsilon near 1e-10 had no unique
    direction; and brackets were 1e-13 and 1e-12 of any parameter, in Pa too."""
    scene = sw.read_scene("paper", slab={"epsilon": 2.8e-5 * unit, "r": 10**-2.68 * unit}, drive={"velocity": 100.0 / unit})
    over = ("epsilon", 2.4e-5 * unit, 2.95e-5 * unit)
    hopf, fold = sw.branch(scene, over, "block8", stop_at="LP").special
    assert (hopf.type, fold.type) == ("HB", "LP")
    assert (hopf.epsilon / unit, hopf.period) == (pytest.approx(2.931430996e-5, rel=1e-9), pytest.approx(47.481951929, abs=1e-8))
    assert (fold.epsilon / unit, fold.period) == (pytest.approx(2.938040675e-5, rel=1e-9), pytest.approx(55.9751305, abs=3e-6))
    assert (hopf.bracket, fold.bracket) == (pytest.approx(1e-13 * hopf.epsilon), pytest.approx(1e-12 * fold.epsilon))


def test_a_branch_begins_at_the_other_unstable_end_if_the_run_at_the_first_leads_to_no_orbit():
    """1 % beyond the onset cycles become smaller for hundreds of periods; before, the branch ended before it began."""
    friction, slabs = {"law": "slip", "a_star": 0.5, "a": 0.029, "b": 0.0338}, {"epsilon": 9.6e-6, "log10_r": -2.7}
    scene = {"interface": friction, "slab": slabs, "drive": {"velocity": 33.0}}
    critical = sw.stability(scene, model="quasidynamic").epsilon_c
    with pytest.raises(sw.NumericsError, match="each smaller than the one before: no orbit near it"):
        find_orbit("quasidynamic", sw.read_scene(scene, slab={"epsilon": 0.99 * critical}), 1e-5)
    found = sw.branch(scene, ("epsilon", 0.99 * critical, 0.96 * critical), "quasidynamic", tol=1e-5, most_points=2)
    first, second = found.points
    assert (first.epsilon, first.period) == (pytest.approx(0.96 * critical), pytest.approx(278.258983, abs=1e-4))
    assert second.epsilon > first.epsilon
    assert second.stable


FIRST, SECOND = (over_range(text, "paper") for text in (RANGE, "V=100:120"))


def test_a_curve_ends_at_the_edge_of_its_ranges():
    """The first torus point of the delay system in r and epsilon."""
    result = sw.curve("paper", "NS", "log10_r=-2.72:-2.64", "epsilon=2.8e-5:2.806e-5")
    points = result.summary["points"]
    assert points[0]["log10_r"] == pytest.approx(-2.6575457126, abs=5e-9)
    assert points[0]["period"] == pytest.approx(78.2632597, abs=2e-6)
    assert points[0]["multiplier"] == pytest.approx([-0.111491, 0.993765], abs=2e-6)
    assert all(2.8e-5 <= point["epsilon"] <= 2.806e-5 and point["bracket"] < 1e-9 for point in points)
    assert result.summary["notes"] == ["the curve leaves the rectangle of both ranges at epsilon = 2.806e-05"]
    assert result.dataset.attrs["command"] == "curve"


def test_a_curve_of_hopf_points_counts_the_roots_that_grow_already():
    """Equation (39): a second pair crosses at r = (2/w_c)(atan(r_* w_c/2) + pi), where the first one grows."""
    points = sw.curve("paper", of="HB", over="r=0.008:0.015", along="V=800:1000").summary["points"]
    half = 0.5 * points[0]["V"] * math.sqrt(0.014 / 0.0349)
    assert points[0]["r"] == pytest.approx((math.atan(2.8e-5 / 0.014 * half) + math.pi) / half, rel=1e-9)
    assert {(point["unstable_before"], point["unstable_after"]) for point in points} == {(2, 4)}


def test_hopf_points_are_those_of_the_closed_form(tmp_path, monkeypatch):
    """r_c = (2/omega_c) atan(r_* omega_c/2) (39) and T = 2 pi/(omega_c r_c), also in the file, and computed again from it."""
    file = tmp_path / "hopf.nc"
    points = sw.curve("paper", "HB", "log10_r=-2.8:-2.6", "V=90:110", "delay", out=file).summary["points"]
    with xarray.open_dataset(file) as data:
        assert data["period"].values.tolist() == [point["period"] for point in points]
    assert len(points) > 5
    for point in points:
        closed = onset_of(sw.read("paper").law, 2.8e-5, point["V"])
        assert 10.0 ** point["log10_r"] == pytest.approx(closed["delay"], rel=1e-10)
        assert point["period"] == pytest.approx(2.0 * math.pi / (closed["omega_c"] * closed["delay"]), rel=1e-10)
    few = sw.curve("paper", "HB", "log10_r=-2.8:-2.6", "V=90:110", "delay", most_points=3).summary
    assert (few["points"], few["notes"]) == (points[:3], ["stopped after 3 points: --most-points goes further"])
    monkeypatch.setattr("validation.commands.curve.pursue", lambda *parts: (None, "", False))
    again, other = sw.curve(file), sw.curve(file, along="V=90:91", tol=1e-4)
    call = {"of": "HB", "over": "log10_r=-2.8:-2.6", "and": "V=90:110", "tol": 1e-6, "most_points": 100, "point": None}
    assert (again.options.stored, again.followed.model, again.followed.kind) == (call, "delay", "HB")
    assert (other.options.stored, other.followed.second.ends) == (call | {"and": "V=90:91", "tol": 1e-4}, (90.0, 91.0))


def test_a_curve_begins_at_any_point_of_a_branch(whole):
    """Of a file or of a result in Python; it is the curve that begins with the first point of this kind."""
    first = sw.curve("paper", "LP", RANGE, "V=100:120", "kelvin-voigt", tol=1e-4, most_points=3).followed.points
    for start in whole:
        found = sw.curve(start=start, point="LP1", along="V=100:120", tol=1e-4, most_points=3).followed.points
        for one, other in zip(found, first, strict=True):
            assert one[:7] == pytest.approx(other[:7], rel=1e-7)
            assert (one.kind, one.unstable_before, one.unstable_after) == ("LP", 1, 0)
    assert first[0].first == pytest.approx(-2.700213011, abs=5e-8)
    hopf = sw.curve(start=start, point="HB1", along="V=100:101").followed.points
    assert min(abs(one.first + 2.69954994745) for one in hopf) < 1e-6


def test_a_curve_of_period_doublings_begins_at_its_second_point(tmp_path):
    """The scene's own branch doubles at -2.595727667 and returns at -2.579381814. A curve needs no guess."""
    scene = sw.branch("paper", "log10_r=-2.6:-2.57", "kelvin-voigt", tol=1e-5, out=tmp_path / "x.nc").summary["scene"]
    found = sw.curve(start=tmp_path / "x.nc", point="PD2", along="V=100:101", tol=1e-5, most_points=3).summary
    assert (scene, found["type"], found["points"][0]["log10_r"]) == ("paper", "PD", pytest.approx(-2.579381814, abs=1e-8))
    for point in found["points"]:
        assert point["multiplier"] == pytest.approx([-1.0, 0.0], abs=1e-6)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--point", "NS9"], "--point 'NS9': must be one of the branch's special points: HB1, LP1"),
        (["--point", "LP1", "--and", "V=90:100"], "--and V=90:100: FROM must be the value that the branch of --from has"),
        (["--point", "LP1", "--model", "delay"], "--model: leave it out; --from gives the scene and the model"),
        (["--point", "LP1", "--of", "HB"], "--of 'HB': leave it out; LP1 has its own kind"),
        (["--point", "LP1", "--from", "run.nc"], "--from 'run.nc': no such file"),
        (["--from", "README.md", "--point", "LP1"], "--from 'README.md': holds no scene that can be computed again"),
    ],
)
def test_a_point_that_is_not_there_is_one_line(words, told, whole, refused):
    usual = {"--from": str(whole[1]), "--and": "V=100:110"}
    assert told in refused("curve", *words, *(word for key in usual.keys() - set(words) for word in (key, usual[key])))


def test_a_curve_of_folds_ends_at_a_cusp(answer):
    """At an impedance of 203.3271, measured from 1000 too; right before it both folds have nearly one place."""
    words = ["paper", "--of", "LP", "--over", "log10_r=-2.75:-2.55", "--and", "face.impedance=205:1"]
    for key in ("kind=grip", "stiffness=20", "impedance=205"):
        words += ["--set", f"face.{key}"]
    found = answer("curve", *words)
    *folds, cusp = found["points"]
    assert ({one["type"] for one in folds}, cusp["type"]) == ({"LP"}, "CP")
    assert (cusp["log10_r"], cusp["face.impedance"]) == (pytest.approx(-2.68318631, abs=2e-8), pytest.approx(203.32709, abs=2e-4))
    assert cusp["period"] == pytest.approx(57.5874, abs=1e-3)
    assert (cusp["unstable_before"], cusp["unstable_after"], cusp["bracket"]) == (0, 0, pytest.approx(2e-8))
    (note,) = found["notes"]
    assert note.startswith(
        "the curve ends at a cusp, where two folds meet and are no more; right before it they lie at log10_r = "
    )
    places = [float(value) for value in re.findall(r"log10_r = (-2\.\d+)", note)]
    assert places == pytest.approx([cusp["log10_r"]] * 2, abs=1e-6)


@pytest.mark.slow
def test_where_special_points_end():
    """Behind these grips two folds meet at an impedance of 203.3271, from wherever a curve begins; the Hopf point goes on."""
    scene = sw.read("paper", ["face.kind=grip", "face.stiffness=20", "face.impedance=230"])
    result = sw.branch(scene, "log10_r=-2.69:-2.68", ends="face.impedance=205,200", tol=1e-4)
    ends = result.summary["ends"]
    kinds = [[special["type"] for special in row["special"]] for row in ends["values"]]
    assert (ends["parameter"], [row["face.impedance"] for row in ends["values"]]) == ("face.impedance", [205.0, 200.0])
    assert kinds == [["HB", "LP", "LP"], ["HB"]]
    assert ends["values"][0]["special"] == result.summary["special"]
    fold, hopf = ends["extremes"]["LP"], ends["extremes"]["HB"]
    assert (fold["face.impedance"], fold["log10_r"]) == (pytest.approx(203.32709, abs=1e-4), pytest.approx(-2.68318631, abs=1e-7))
    assert [curve["points"] for curve in fold["curves"]] == [["LP1"], ["LP2"]]
    assert [curve["face.impedance"] for curve in fold["curves"]] == [pytest.approx(203.32709, abs=1e-4)] * 2
    assert (hopf["face.impedance"], hopf["reason"]) == (None, "HB1: the curve leaves the range at face.impedance = 200")
    table = "\n".join(result.lines({})).splitlines()
    assert [line.split() for line in table if line.startswith("20")] == [["205", "1", "2", "0", "0"], ["200", "1", "0", "0", "0"]]


def test_a_hopf_point_ends_where_its_curve_turns():
    """At the largest critical round trip of all impedances of the grips."""
    scene = sw.read("paper", ["face.kind=grip", "face.stiffness=20", "face.impedance=30"])
    over, second = over_range("log10_grip_impedance=0:4", scene), over_range("log10_r=-2.75:-1.5", scene)
    curve = Curve("HB", over, second, "delay", 1e-6)
    curve.begin()
    found = SpecialEnds(second, (-2.75, -1.5)).of_hopf(curve, "HB1")
    best = minimize_scalar(lambda one: -critical_round_trip(over.scene_at(one))[0], bracket=(2.3, 2.5, 2.7), tol=1e-6)
    assert (found.extreme, found.first) == (pytest.approx(math.log10(-best.fun), abs=1e-8), pytest.approx(best.x, abs=1e-3))
    assert (found.points, found.reason) == (("HB1",), "")


OTHER = over_range(RANGE, sw.read("paper", {"interface.a": 0.03491}))


@pytest.mark.parametrize(
    ("kind", "fact", "changes"),
    [
        ("branch", "scene", {"over": OTHER}),
        ("branch", "model", {"model": "modal:1"}),
        ("branch", "cells", {"cells": 9}),
        ("branch", "sources", {}),
        ("curve", "type", {"kind": "NS"}),
        ("curve", "rectangle", {"over": over_range("log10_r=-2.72:-2.69", "paper")}),
    ],
)
def test_every_fact_of_another_curve_is_refused(tmp_path, monkeypatch, kind, fact, changes):
    path = tmp_path / "x.nc"
    own = Curve("LP", FIRST, SECOND, "delay", 1e-6) if kind == "curve" else FollowedBranch(FIRST, "kelvin-voigt", 1e-4)
    monkeypatch.setattr(type(own), "saved", lambda *parts: {})
    followed.write_followed(path, own, None, False, {})
    same = own if kind == "curve" else replace(own, over=over_range("log10_r=-2.71:-2.6", "paper"))
    with pytest.raises(sw.SceneError, match=f"is no file of a {kind}, or damaged"):  # no points, but the same facts
        next(ends_of(same, StopAt(), path))
    if fact == "sources":
        monkeypatch.setattr(f"validation.models.{kind}.source_digest", lambda: "of another version")
    with pytest.raises(sw.SceneError, match=rf"x\.nc': {fact} is "):
        next(ends_of(replace(own, **changes), StopAt(), path))


@pytest.mark.parametrize("text", ["log10_r=-2.7:-2.6", "slab.r=0.002:0.0025", "slab.thickness=0.02:0.05"])
@pytest.mark.parametrize("face", ["grip", "machine"])
def test_a_branch_over_the_slabs_leaves_a_face_in_units_of_its_own_as_it_is(face, text):
    """The scenes of a branch are those of `--set`, also where special points are given to other commands."""
    own = {"kind": face, "stiffness": "200 MPa/m", "impedance": 0.0} | ({"mass": 0.0} if face == "machine" else {})
    scene = sw.read_scene("paper-si", **{"slab.face": own})
    over, key = over_range(text, scene), text.partition("=")[0]
    wanted = sw.read_scene(scene, **{key: over.last})
    assert over.written_at(over.last).digest == wanted.digest
    there = over.scene_at(over.last).upper
    assert there.round_trip == pytest.approx(wanted.upper.round_trip, rel=1e-12)
    for slab in (wanted.upper, there):
        assert slab.termination.spring == pytest.approx(scene.upper.termination.spring, rel=1e-12)


@pytest.mark.parametrize("name", ["log10_r", "r", "epsilon", "ratio_r", "ratio_epsilon"])
@pytest.mark.parametrize("face", [{"stiffness": "200 MPa/m", "impedance": 0.5}, {"stiffness": 2.0, "impedance": "20 kPa s/m"}])
def test_a_branch_over_slabs_that_differ_leaves_faces_in_units_of_their_own_as_they_are(face, name):
    """Both slabs change by one factor, or the lower one alone; a face does in what was given relative to its slab."""
    slab = {"density": 784.0, "shear_modulus": 1e6, "thickness": 0.03, "face": {"kind": "grip", **face}}
    tables = tomllib.loads(sw.show("paper-si")) | {"upper": slab, "lower": slab | {"thickness": 0.06, "density": 1000.0}}
    del tables["slab"]
    scene = sw.read(tables)
    over = over_range(f"{name}=0.002:0.004" if not name.startswith("log10") else f"{name}=-2.7:-2.4", scene)
    there = over.scene_at(over.last)
    factors = [
        tuple(getattr(new, key) / getattr(old, key) for new, old in ((there.upper, scene.upper), (there.lower, scene.lower)))
        for key in ("round_trip", "epsilon")
    ]
    here = {"ratio_r": scene.lower.round_trip / scene.transit, "ratio_epsilon": scene.lower.epsilon / scene.upper.epsilon}
    here |= {"log10_r": scene.transit, "r": scene.transit, "epsilon": scene.upper.epsilon}
    factor = (10.0**over.last if name == "log10_r" else over.last) / here[name]
    changed, kept = factors if name.endswith("_r") or name == "r" else reversed(factors)
    assert changed == pytest.approx((1.0 if name.startswith("ratio") else factor, factor), rel=1e-12)
    assert kept == pytest.approx((1.0, 1.0), rel=1e-12)
    for new, old in ((there.upper, scene.upper), (there.lower, scene.lower)):
        own, relative = ("spring", "impedance") if face["impedance"] == 0.5 else ("dashpot", "stiffness")
        assert getattr(new.termination, own) == pytest.approx(getattr(old.termination, own), rel=1e-12)
        assert getattr(new.face, relative) == getattr(old.face, relative)


def test_where_a_single_real_root_crosses_no_orbit_begins():
    """Slabs that neither hold their load nor reflect, epsilon below and above that of neutral sliding, 2.8e-4."""
    face = {"slab.face.kind": "reflection", "slab.face.coefficient": 0.0}
    said = "a single real root crosses between epsilon = 0.0002 and 0.001, and no orbit begins there; delay: a run of"
    with pytest.raises(sw.NumericsError, match=said):
        sw.branch("paper", over="epsilon=2e-4:1e-3", **face)
