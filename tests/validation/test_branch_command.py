"""`slipwave branch`: special points against those of AUTO-07p and DDE-BIFTOOL; branches that are stopped and go on."""

import json
import signal
from dataclasses import fields, is_dataclass, replace
from itertools import islice
from pathlib import Path

import numpy as np
import pytest
import xarray
from hooked_process import interrupted
from matplotlib.image import imread

import slipwave
from reduced.continuation.point import Point
from slipwave.errors import NumericsError
from validation.branches.branch import Branch
from validation.branches.drawing import figure_of_branch
from validation.branches.followed import Limits, heads, read
from validation.branches.parameter import over_range
from validation.cli import INPUT_WRONG, INTERRUPTED, NUMERICS_FAILED, main
from validation.references.published import reference_orbit
from validation.results.branch import _telling

RANGE = "log10_r=-2.72:-2.68"
SHORT = ("paper", "--model", "kelvin-voigt", "--over", RANGE, "--tol", "1e-4", "--most-points", "24")
COARSE = ("paper", "--model", "kelvin-voigt", "--over", RANGE, "--tol", "1e-4")


def branch(capsys: pytest.CaptureFixture[str], *words: str) -> dict[str, object]:
    assert main(["branch", *words, "--json"]) == 0
    found: dict[str, object] = json.loads(capsys.readouterr().out)
    return found


@pytest.mark.parametrize(
    ("model", "hopf", "born", "fold", "turn"),
    [
        ("kelvin-voigt", -2.69954994745, 49.66821032, -2.700213011, 58.471805),
        ("delay", -2.6995497159, 49.66818383, -2.700251703, 59.107433),
    ],
)
def test_a_branch_is_born_and_turns_where_other_programs_say(capsys, model, hopf, born, fold, turn):
    """Measured: folds 4e-9 off on this mesh; at a fold the period hardly matters, 1.3e-6."""
    words = ["paper", "--model", model, "--over", RANGE, "--tol", "1e-4", "--stop-at", "LP"]
    found = branch(capsys, *words)
    birth, first_fold = found["special"]
    assert birth["type"] == "HB"
    assert birth["log10_r"] == pytest.approx(hopf, abs=1e-10)
    assert birth["period"] == pytest.approx(born, abs=1e-7)
    assert (birth["unstable_before"], birth["unstable_after"]) == (0, 2)
    assert first_fold["type"] == "LP"
    assert first_fold["log10_r"] == pytest.approx(fold, abs=5e-8)
    assert first_fold["period"] == pytest.approx(turn, rel=2e-5)
    assert first_fold["bracket"] < 1e-9
    assert (first_fold["unstable_before"], first_fold["unstable_after"]) == (1, 0)
    assert all(point["unstable"] == 1 and point["stable"] is False for point in found["points"][:-1])
    assert found["points"][-1]["stable"] is True


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> tuple[dict[str, object], Path]:
    folder = tmp_path_factory.mktemp("branch")
    with pytest.MonkeyPatch.context() as patch:
        lines: list[str] = []
        patch.setattr("builtins.print", lambda *words, **_: lines.append(" ".join(map(str, words))))
        assert main(["branch", *COARSE, "--json", "--out", str(folder / "x.nc"), "--plot", str(folder / "x.png")]) == 0
    return json.loads("\n".join(lines)), folder


def test_it_passes_through_known_orbits(whole):
    points = whole[0]["points"]
    upper = [point for point in points if point["stable"]]
    values = [point["log10_r"] for point in upper]
    known = reference_orbit("kelvin-voigt", -2.68)
    for name in ("period", "stress_drop", "elastic_stress_drop"):
        slope, value = np.polyfit(np.array(values[-3:]) + 2.68, [point[name] for point in upper[-3:]], 1)
        assert value == pytest.approx(known[name], rel=2e-3), slope
    assert all(-2.72 <= point["log10_r"] <= -2.68 for point in points)


def test_its_file_has_all_points_and_special_points(whole):
    found, folder = whole
    with xarray.open_dataset(folder / "x.nc") as data:
        assert data.attrs["complete"] == 1
        count = len(found["points"])
        assert data["point_period"].values[:count].tolist() == [point["period"] for point in found["points"]]
        assert data["special_kind"].values.tolist() == [special["type"] for special in found["special"]]
        assert data["special_value"].values.tolist() == [special["log10_r"] for special in found["special"]]
    assert sorted(path.name for path in folder.iterdir()) == ["x.nc", "x.png"]


def test_its_figure_has_three_panels_with_marks(whole):
    """Colour appears only where the fold is marked, once in each panel, and in the legend."""
    pixels = imread(whole[1] / "x.png")[:, :, :3]
    colourful = np.ptp(pixels, axis=2) > 0.3
    rows = np.flatnonzero(colourful.any(axis=1))
    assert 1 + int((np.diff(rows) > 5).sum()) == 4


def test_pieces_of_one_stability_meet_at_special_points(whole):
    found = Branch(over_range(RANGE, "paper"), "kelvin-voigt", 1e-4)
    read(whole[1] / "x.nc", found)
    for axes, name in zip(figure_of_branch(found).axes, ("period", "stress_drop", "elastic_stress_drop"), strict=True):
        unstable, stable = [line for line in axes.lines if len(line.get_xdata()) > 2]
        birth, fold = ((special.value, getattr(special, name)) for special in found.special)
        assert (unstable.get_linestyle(), stable.get_linestyle()) == ("--", "-")
        assert (unstable.get_xdata()[0], unstable.get_ydata()[0]) == birth
        assert (unstable.get_xdata()[-1], unstable.get_ydata()[-1]) == fold
        assert (stable.get_xdata()[0], stable.get_ydata()[0]) == fold


@pytest.mark.parametrize("by", [signal.SIGINT, signal.SIGKILL])
def test_a_branch_that_was_stopped_goes_on_to_the_same_points(by, tmp_path, capsys, monkeypatch):
    done = interrupted(["branch", *SHORT, "--json", "--out", "x.nc"], 12.0, tmp_path, by)
    if by is signal.SIGINT:
        assert done.returncode == INTERRUPTED
        assert done.stderr.splitlines()[-1] == "slipwave: interrupted after 12 points; --resume x.nc goes on from there"
        assert len(json.loads(done.stdout)["points"]) == 12
    else:
        assert done.returncode == -signal.SIGKILL
    monkeypatch.chdir(tmp_path)
    with xarray.open_dataset("x.nc") as data:
        assert data.attrs["complete"] == 0
        assert data.sizes["point"] == 12
    resumed, at_once = branch(capsys, *SHORT, "--resume", "x.nc"), branch(capsys, *SHORT)
    assert len(resumed["points"]) == 24
    assert resumed["points"] == at_once["points"]
    assert resumed["special"] == at_once["special"]


def test_an_interrupted_branch_without_file_says_so(tmp_path):
    done = interrupted(["branch", *SHORT], 5.0, tmp_path)
    assert done.returncode == INTERRUPTED
    assert done.stderr.splitlines()[-1].endswith("no file was kept: --out FILE.nc keeps one to go on from")


def test_without_a_hopf_point_it_begins_with_an_orbit(capsys):
    words = ["paper", "--model", "kelvin-voigt", "--over", "log10_r=-2.68:-2.69", "--tol", "1e-4"]
    found = branch(capsys, *words)
    assert found["special"] == []
    assert found["points"][0]["log10_r"] == -2.68
    assert found["points"][0]["period"] == pytest.approx(reference_orbit("kelvin-voigt", -2.68)["period"], rel=1e-6)
    values = [point["log10_r"] for point in found["points"]]
    assert values == sorted(values, reverse=True)
    assert values[-1] >= -2.69
    assert found["notes"] == ["the branch leaves the range at log10_r = -2.69"]


def test_undecided_stability_is_null_with_its_reason(capsys, tmp_path):
    """Unlike slabs of irrational ratio have motions that friction never damps. A file keeps what is not counted."""
    words, file = ["unlike-irrational", "--over", "log10_r=-2.6:-2.5", "--tol", "1e-3", "--most-points"], str(tmp_path / "u.nc")
    branch(capsys, *words, "2", "--out", file)
    found = branch(capsys, *words, "3", "--resume", file)
    assert [point["stable"] for point in found["points"]] == [None, None, None]
    assert [point["unstable"] for point in found["points"]] == [None, None, None]
    assert found["notes"][0].startswith("stability is not decided where the essential radius is 1")
    assert found["notes"][0].endswith("so of the special points only HB and LP are found")


def test_another_parameter_stands_under_its_own_name(capsys):
    """The Hopf point in epsilon is that of `stability`."""
    assert main(["stability", "paper", "--model", "block8", "--json"]) == 0
    critical = json.loads(capsys.readouterr().out)["epsilon_c"]
    words = ["paper", "--model", "block8", "--over", "slab.epsilon=2.5e-5:3.5e-5", "--tol", "1e-3", "--stop-at", "HB"]
    found = branch(capsys, *words)
    assert found["parameter"] == "epsilon"
    birth = found["special"][0]
    assert birth["epsilon"] == birth["value"] == pytest.approx(critical, rel=1e-9)
    assert birth["parameter"] == "epsilon"


def test_it_ends_where_orbits_shrink_to_steady_sliding():
    """The first small orbit, followed the wrong way: the Hopf point is met again, and nothing is counted twice."""
    found = Branch(over_range(RANGE, "paper"), "kelvin-voigt", 1e-4)
    head = found.begin()
    back = head._replace(point=replace(head.point, tangent=-head.point.tangent))
    assert isinstance(back.point, Point)
    list(found.follow(back, Limits(points=50)))
    assert [special.kind for special in found.special] == ["HB", "HB"]
    assert found.special[0].value == pytest.approx(found.special[1].value, abs=1e-12)
    assert found.notes == ["the branch ends where its orbits shrink to steady sliding"]
    assert len(found.points) < 10


@pytest.mark.parametrize("beyond", [-1e-10, 1e-12, 1e-10, 1e-9])
def test_an_onset_at_the_edge_of_the_range_begins_a_branch(beyond):
    """A root that grows by less than rounding errors is not counted, so that the onset may lie just outside of the range."""
    onset = -2.69954994745
    found = Branch(over_range(f"log10_r={onset + beyond!r}:-2.69", "paper"), "kelvin-voigt", 1e-4)
    known = list(islice(heads(found, Limits()), 4))
    assert found.special[0].value == pytest.approx(onset, abs=1e-10)
    assert found.special[0].kind == "HB"
    assert len(known) == 4
    assert len(found.points) == 4


def test_a_range_may_have_units(capsys):
    """As the key itself; a bare velocity is in V*. Listed values that differ are printed so, and periods in seconds beside."""
    over = over_range("slab.thickness=31 mm:34 mm", "paper-si")
    assert (over.first, over.last, over.written(0.032)) == (0.031, 0.034, "0.032 m")
    assert over.scene_at(0.032) == slipwave.read("paper-si", {"slab.thickness": 0.032})
    fast = over_range("drive.velocity=0.1 mm/s:0.2 mm/s", "paper-si")
    assert (fast.name, fast.first, fast.last) == ("V", pytest.approx(100.0), pytest.approx(200.0))
    assert fast.scene_at(150.0).velocity == 150.0
    words = ["paper-si", "--model", "kelvin-voigt", "--tol", "1e-4", "--most-points", "2"]
    assert main(["branch", *words, "--over", "slab.thickness=31 mm:34 mm"]) == 0
    printed = capsys.readouterr().out.splitlines()
    special, first, second = (line.split() for line in (printed[-7], printed[-4], printed[-3]))
    assert special[:2] == ["HB", "Hopf"]
    assert float(special[2]) == pytest.approx(0.03357797353158276 * 10 ** (2.68 - 2.69954994745), rel=1e-9)
    assert first[0] != second[0]
    transit = over.scene_at(float(first[0])).transit * slipwave.read("paper-si").units.time
    assert float(first[2]) == pytest.approx(float(first[1]) * transit, rel=1e-6)


@pytest.mark.parametrize(("values", "digits"), [([6.0, 7.0], 8), ([5.99999996758, 5.99999996761], 12), ([1.0, 1.0], 8)])
def test_listed_values_that_differ_are_told_apart(values, digits):
    assert _telling(values) == digits


def failing(after):
    """`heads` that fail after so many points."""

    def steps(*all_of_it):
        yield from islice(heads(*all_of_it), after)
        raise NumericsError("it turns too sharply")

    return steps


def test_a_failed_branch_goes_on_to_the_file_of_one_that_did_not_fail(tmp_path, monkeypatch):
    """Its file is not complete; the one that goes on from it is that of a branch computed at once."""
    monkeypatch.chdir(tmp_path)
    words = ("paper", RANGE, "kelvin-voigt")
    options = {"tol": 1e-4, "most_points": 9}
    slipwave.branch(*words, **options, out="whole.nc")
    with monkeypatch.context() as patch:
        patch.setattr("validation.branches.followed.heads", failing(5))
        with pytest.raises(NumericsError, match="it turns too sharply") as failure:
            slipwave.branch(*words, **options, out="part.nc")
    assert len(failure.value.result.summary["points"]) == 5
    failure.value.result.to_netcdf("again.nc")
    for name in ("part.nc", "again.nc"):
        with xarray.open_dataset(name) as data:
            assert (data.attrs["complete"], data.sizes["point"]) == (0, 5)
    slipwave.branch(*words, **options, resume="part.nc")
    whole, part = xarray.open_datatree("whole.nc"), xarray.open_datatree("part.nc")
    assert part.attrs["complete"] == 1
    for group in ("/", "/resume"):
        assert set(part[group].dataset.variables) == set(whole[group].dataset.variables)
        for name, variable in whole[group].dataset.variables.items():
            assert part[group].dataset[name].values.tolist() == variable.values.tolist(), name
    assert {name: part.attrs[name] for name in ("facts", "notes")} == {name: whole.attrs[name] for name in ("facts", "notes")}


def test_limits_are_kept_and_told(capsys):
    few = branch(capsys, *SHORT[:-1], "7")
    assert len(few["points"]) == 7
    assert few["notes"] == ["stopped after 7 points: --most-points goes further"]
    short = branch(capsys, *COARSE, "--longest-period", "51")
    assert short["points"][-2]["period"] < 51.0 < short["points"][-1]["period"]


def test_switched_it_follows_the_doubled_orbits_from_doubling_to_doubling(capsys):
    found = branch(capsys, "paper", "--model", "kelvin-voigt", "--over", "log10_r=-2.6:-2.57", "--tol", "1e-5", "--switch", "PD")
    assert [special["type"] for special in found["special"]] == ["PD"]
    assert found["special"][0]["log10_r"] == pytest.approx(-2.595727667, abs=1e-8)
    assert found["special"][0]["period"] == pytest.approx(2.0 * 78.994716174, abs=1e-6)  # the doubled orbit's
    values = np.array([point["log10_r"] for point in found["points"]])
    assert np.all(np.diff(values) > 0.0)
    assert abs(values[0] + 2.595727667) < 1e-5
    assert abs(values[-1] + 2.579381814) < 6e-4  # the second doubling of the pair
    periods = np.array([point["period"] for point in found["points"]])
    assert periods[0] == pytest.approx(2.0 * 78.994716174, rel=1e-5)
    assert periods[-1] == pytest.approx(2.0 * 79.26000895, rel=1e-4)
    assert all(point["stable"] for point in found["points"])
    assert found["notes"] == ["the branch ends at a period doubling, where both halves of its orbits become the same"]


@pytest.mark.parametrize(
    ("words", "status", "said"),
    [
        (["paper", "--over", RANGE, "--switch", "LP"], INPUT_WRONG, "--switch 'LP': must be HB or PD"),
        (["paper", "--over", "log10_r=-2.7"], INPUT_WRONG, "must be KEY=FROM:TO"),
        (["paper", "--over", "log10_r=-2.7:x"], INPUT_WRONG, "'x' must be a number"),
        (["paper", "--over", "log10_r=-2.7:-2.7"], INPUT_WRONG, "must differ"),
        (["paper-si", "--over", "slab.thickness=1 cm:2"], INPUT_WRONG, "FROM and TO must both have a unit, or none"),
        (["paper-si", "--over", "slab.thickness=1 cm:2 s"], INPUT_WRONG, "slab.thickness"),
        (
            ["paper", "--over", "nothing=1:2"],
            INPUT_WRONG,
            "'nothing' is no parameter; must be one of r, epsilon, V,",
        ),
        (["paper", "--over", "slab.nothing=1:2"], INPUT_WRONG, "unknown key"),
        (["paper", "--over", "epsilon=-1:1"], INPUT_WRONG, "slab.epsilon = -1.0: must be"),
        (["paper", "--over", "log10_r=-3:-2.8"], INPUT_WRONG, "is stable at both ends"),
        (["paper", "--over", RANGE, "--stop-at", "XX"], INPUT_WRONG, "--stop-at 'XX': must be one of HB, LP, PD, NS"),
        (["paper", "--over", RANGE, "--most-points", "0"], INPUT_WRONG, "most_points = 0: must be at least 1"),
        (["paper", "--over", RANGE, "--longest-period", "-1"], INPUT_WRONG, "--longest-period = -1"),
        (["paper", "--over", RANGE, "--model", "fd"], INPUT_WRONG, "models that do: delay,"),
        (["paper", "--over", RANGE, "--resume", "missing.nc"], INPUT_WRONG, "no such file"),
        (["paper", "--over", RANGE, "--plot", "x.gif"], INPUT_WRONG, "must end in .png or .pdf or .svg"),
        (["ramp", "--over", RANGE], INPUT_WRONG, "needs a constant drive.velocity"),
        (["paper", "--over", "log10_r=-2.6:-2.5", "--set", "start.size=0"], NUMERICS_FAILED, "made 0 cycles"),
    ],
)
def test_what_cannot_be_followed_is_told_in_one_line(capsys, words, status, said):
    assert main(["branch", *words, "--json"]) == status
    out, err = capsys.readouterr()
    assert out == ""
    assert said in err.splitlines()[-1]


def test_a_branch_goes_on_with_another_tolerance(capsys, tmp_path):
    """The points that it has stay; the next ones lie on a finer mesh, and it passes through the known fold all the same."""
    path = str(tmp_path / "x.nc")
    few = branch(capsys, *SHORT[:-1], "5", "--out", path)
    words = [*(word if word != "1e-4" else "1e-7" for word in COARSE), "--stop-at", "LP"]
    found = branch(capsys, *words, "--resume", path)
    assert found["points"][:5] == few["points"]
    last = few["points"][-1]["log10_r"]
    assert (
        f"points up to log10_r = {last:.10g}, 5 in all, were computed with tol = 0.0001, those after it with 1e-07"
        in found["notes"]
    )
    assert found["special"][-1]["log10_r"] == pytest.approx(-2.700213011, abs=1e-9)


def test_a_file_of_another_branch_is_refused(whole, capsys):
    assert main(["branch", "paper", "--over", RANGE, "--resume", str(whole[1] / "x.nc")]) == INPUT_WRONG
    assert "model is 'kelvin-voigt'; this branch has 'delay'" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("fact", "changes"),
    [
        ("scene", {"over": over_range(RANGE, slipwave.read("paper", {"interface.a": 0.03491}))}),
        ("model", {"model": "modal:1"}),
        ("cells", {"cells": 9}),
        ("doubled", {"doubled": True}),
        ("parameter", {"over": over_range("V=100:110", "paper")}),
        ("sources", {}),
    ],
)
def test_every_fact_of_another_branch_is_refused(whole, monkeypatch, fact, changes):
    """Another range of the same parameter is none."""
    path, own = whole[1] / "x.nc", Branch(over_range("log10_r=-2.71:-2.6", "paper"), "kelvin-voigt", 1e-4)
    if fact == "sources":
        read(path, own)
        monkeypatch.setattr("validation.branches.branch.source_digest", lambda: "of another version")
    other = replace(own, **changes, points=[], special=[], notes=[])
    with pytest.raises(slipwave.SceneError, match=rf"x\.nc': {fact} is "):
        read(path, other)
    assert other.points == []


@pytest.mark.parametrize("source", ["paper", "grip", "viscous", "layered", "machine"])
@pytest.mark.parametrize(("name", "key"), [("log10_r", "slab.log10_r"), ("epsilon", "slab.epsilon"), ("V", "drive.velocity")])
def test_a_parameter_that_is_set_gives_the_scene_that_is_read(source, name, key):
    """Also in all that is relative to it: the face's stiffness and mass, the time of viscosity."""
    present = {"log10_r": -2.68, "epsilon": 2.8e-5, "V": 100.0}[name]
    value = present * 1.1
    over = over_range(f"{name}={present}:{value * 1.05}", source)
    known, found = (_numbers(scene) for scene in (slipwave.read(source, {key: value}), over.scene_at(value)))
    assert found == pytest.approx(known, rel=1e-13)


def _numbers(part):
    """All numbers in a scene, in order."""
    if isinstance(part, (int, float)):
        return [part]
    inner = part if isinstance(part, tuple) else [getattr(part, one.name) for one in fields(part)] if is_dataclass(part) else ()
    return [number for one in inner for number in _numbers(one)]


@pytest.mark.parametrize("damage", ["nan", "gone"])
@pytest.mark.parametrize("name", ["mesh_levels", "monodromy", "metric"])
def test_a_damaged_file_is_not_gone_on_from(whole, tmp_path, capsys, name, damage):
    import netCDF4

    path = tmp_path / "x.nc"
    path.write_bytes((whole[1] / "x.nc").read_bytes())
    with netCDF4.Dataset(path, "a") as file:
        if damage == "nan":
            file["resume"][name][:] = np.nan
        else:
            file["resume"].renameVariable(name, "gone")
    capsys.readouterr()
    assert main(["branch", *COARSE, "--resume", str(path)]) == INPUT_WRONG
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert "x.nc': is no file of a branch, or damaged: its contents have changed since it was written" in err
