"""Maps for a paper: colours that everyone can tell apart, verdicts by name, boundaries, clocks, hatches, sizes."""

import itertools
import json
import math
import struct
from dataclasses import replace

import matplotlib
import numpy as np
import pytest
import xarray
from matplotlib.backends.backend_agg import FigureCanvasAgg

import slipwave as sw
from slipwave.errors import SceneError
from validation.chart import Chart, Panel, Scale, cell_edges
from validation.chart.draw import draw
from validation.data.datasets import as_flags
from validation.sweep.map_figures import HATCHES, REGIMES, SIZES, _bare, chart_of_sweep, figures_on_clock, in_print, onset_lines
from validation.sweep.measures import VERDICTS

RELAXING = sw.read("viscous", {"slab.viscosity": {"kind": "standard-linear", "time": 1e-5, "ratio": 1.0}})
SEEN = {
    "everyone": np.eye(3),
    "without red": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "without green": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    "without blue": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
}
"""Linear RGB as eyes without one kind of cones see it (Machado, Oliveira and Fernandes 2009, severity 1)."""
TO_XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])


def linear(color):
    sent = np.array([int(color[k : k + 2], 16) / 255.0 for k in (1, 3, 5)])
    return np.where(sent <= 0.04045, sent / 12.92, ((sent + 0.055) / 1.055) ** 2.4)


def lab(rgb):
    """CIE L*a*b* of linear RGB, in which a difference of 2.3 is just seen."""
    xyz = TO_XYZ @ np.clip(rgb, 0.0, 1.0) / [0.9505, 1.0, 1.089]
    x, y, z = np.where(xyz > 216.0 / 24389.0, np.cbrt(xyz), (24389.0 / 27.0 * xyz + 16.0) / 116.0)
    return np.array([116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)])


def test_regimes_differ_in_grey_and_for_the_colour_blind():
    pairs = list(itertools.combinations(REGIMES.values(), 2))
    assert min(abs(lab(linear(one))[0] - lab(linear(other))[0]) for one, other in pairs) > 7.5
    for matrix in SEEN.values():
        apart = [np.linalg.norm(lab(matrix @ linear(one)) - lab(matrix @ linear(other))) for one, other in pairs]
        assert min(apart) > 10.0
    patterns = [HATCHES[word] for word in ("too short", "no figures", "not computed")]
    assert len(set(patterns)) == 3


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    """A map of six points of slabs in SI, and its folder."""
    folder = tmp_path_factory.mktemp("map") / "out"
    vary = {"thickness": ["2 cm", "5 cm", "10 cm"], "drive.velocity": [100.0, 2000.0]}
    return sw.sweep("paper-si", vary=vary, models="block8", until=400.0, tol=1e-6, workers=1, out=folder), folder


def test_verdicts_have_names_in_xarray_and_numbers_in_files(swept, tmp_path):
    found, folder = swept
    data = found.dataset
    assert (data.verdict == "periodic").values.sum() == found.regimes[0].periodic
    sw.sweep(folder, gather=True)
    with xarray.open_dataset(folder / "sweep.nc") as file:
        assert file["verdict"].dtype == np.int8
        assert file["verdict"].attrs["flag_meanings"].split()[8] == VERDICTS[8].replace(" ", "_")
        told = [VERDICTS[number] if number >= 0 else "" for number in file["verdict"].values.ravel()]
        assert told == data["verdict"].values.ravel().tolist()
    for source in (folder, folder / "sweep.nc", found):
        again = sw.map(source, plain=True).dataset
        assert again["verdict"].values.tolist() == data["verdict"].values.tolist()
    assert np.array_equal(
        as_flags(data)["verdict"], [[VERDICTS.index(word) if word else -1 for word in row] for row in data["verdict"].values]
    )


def test_a_point_that_is_too_short_says_how_long_it_would_take(swept):
    data = swept[0].dataset
    short = data.verdict == "too short"
    assert short.values.any()
    for reason, needed, seconds in zip(*(data[name].values[short] for name in ("reason", "needed", "needed_s")), strict=True):
        assert reason == f"too short: about {needed:.2g} transits ({seconds:.2g} s) would do"
    assert (data["reason"].values[~short.values & (data["status"].values == 0)] == "").all()
    longest = float(data["needed"].max())
    assert f"runs that are too short have enough cycles with --until {float(f'{longest:.2g}'):g}" in [
        *swept[0].lines(swept[0].summary)
    ]


def test_a_scene_in_si_has_its_periods_in_seconds(swept):
    data = swept[0].dataset
    panels = chart_of_sweep(data).panels
    assert [panel.traces[-1].name for panel in panels] == ["regime", "period / s", "stress drop / Pa"]
    assert np.array_equal(panels[1].traces[-1].value, data["period_s"].values.T, equal_nan=True)
    assert (panels[0].x.second.label, panels[0].y.second.label) == ("r", "V / (m/s)")
    assert [data[name].attrs["units"] for name in ("period_s", "stress_drop_Pa", "v_max_m_per_s")] == ["s", "Pa", "m s-1"]


def test_periods_along_a_changing_transit_are_on_a_clock_that_does_not_change():
    found = sw.sweep("paper", vary={"log10_r": [-2.7, -2.5, -2.3]}, models="block8", until=3000.0, tol=1e-6, workers=1).dataset
    panel = chart_of_sweep(found).panels[0]
    assert panel.y.label == "period / (L/V*)"
    assert panel.traces[0].y == pytest.approx(found["period"].values * 10.0 ** found["log10_r"].values, rel=1e-12, nan_ok=True)
    fixed = sw.sweep("paper", vary={"V": [500.0, 2000.0]}, models="block8", until=600.0, tol=1e-6, workers=1).dataset
    panel = chart_of_sweep(fixed).panels[0]
    assert panel.y.label == "period / transits"
    assert np.array_equal(panel.traces[0].y, fixed["period"].values, equal_nan=True)


def test_exponents_are_told_on_that_clock_and_a_transient_keeps_its_verdict():
    """Before, they were in no table, per transits that differ, and a point that returns to steady sliding had failed."""
    result = sw.sweep("grip", vary={"slab.r": [0.0018, 0.003]}, models="quasidynamic", measure="lyapunov", workers=1)
    found, summary = result.dataset, result.summary
    assert (found["verdict"].values.tolist(), summary["done"]) == (["decaying", "periodic"], 2)
    values, label = figures_on_clock(found, "exponent")
    assert (np.isnan(values.values).tolist(), label) == ([True, False], "exponent / (V*/L)")
    assert values.values[1] == pytest.approx(found["exponent"].values[1] / 0.003, rel=1e-12)
    assert [panel.y.label for panel in chart_of_sweep(found).panels[:2]] == [label, "period / (L/V*)"]
    assert "slab.r   verdict  exponent / (V*/L)  period / (L/V*)" in "\n".join(result.lines(summary))
    given = {"vary": {"slab.thickness": [0.06]}, "models": "quasidynamic", "measure": "lyapunov", "until": 3000.0}
    data = sw.sweep("paper-si", **given, workers=1).dataset
    transit = 2.0 * 0.06 / (1e6 / 784.0) ** 0.5
    assert data["exponent_per_s"].values == pytest.approx(data["exponent"].values / transit, rel=1e-9)
    assert np.isfinite(data["exponent"].values).all()
    assert figures_on_clock(data, "exponent")[1] == "exponent / (1/s)"


def test_periods_over_variables_of_ones_own_are_on_that_clock_too():
    """q and p set both round trips: at each point the period in transits times the upper slab's."""
    sets = {"upper.r": "0.002*(1+q)/(q+p)", "lower.r": "0.002*p*(1+q)/(q+p)"}
    axes = {"q": (np.array([1.0, 3.0]), "q", "1"), "p": (np.array([1.0, 2.0, 4.0]), "p", "1")}
    data = lattice(axes, scene_toml=sw.show("unlike"), manifest=json.dumps({"set": sets}))
    data["period"] = data["status"].copy(data=np.full((2, 3), 50.0)).assign_attrs(in_units_of="transit")
    values, label = figures_on_clock(data, "period")
    q, p = np.array([[1.0], [3.0]]), np.array([1.0, 2.0, 4.0])
    assert label == "period / (L/V*)"
    assert values.values == pytest.approx(50.0 * 0.002 * (1.0 + q) / (q + p), rel=1e-12)


def lattice(axes, **attrs):
    return xarray.Dataset(
        {"status": (tuple(axes), np.zeros([len(values) for values, *_ in axes.values()], dtype=int))},
        coords={name: (name, values, {"long_name": key, "units": unit}) for name, (values, key, unit) in axes.items()}
        | {"model": "delay"},
        attrs=attrs,
    )


def test_the_boundary_over_thickness_is_that_over_the_round_trip():
    """paper-si: r is proportional to the thickness, V to the velocity in m/s."""
    scene = sw.read_scene("paper-si")
    thick, rates = np.geomspace(2.0, 8.0, 5), np.geomspace(50.0, 2000.0, 4)
    trips = [sw.read("paper-si", {"slab.thickness": f"{value} cm"}).transit for value in thick.tolist()]
    speeds = rates * scene.units.reference_velocity
    text = sw.show("paper-si")
    physical = lattice({"h": (thick, "slab.thickness", "cm"), "v": (speeds, "drive.velocity", "m/s")}, scene_toml=text)
    plain = lattice({"r": (np.log10(trips), "slab.log10_r", "1"), "v": (rates, "drive.velocity", "1")}, scene_toml=text)
    ours, theirs = (onset_lines(data)[0][0] for data in (physical, plain))
    per_cm = trips[0] / thick[0]
    at = np.log10(np.geomspace(60.0, 1900.0, 9))
    curve = np.interp(
        at,
        *np.array(sorted(zip(np.log10(ours.up / scene.units.reference_velocity), np.log10(ours.across * per_cm), strict=True))).T,
    )
    assert curve == pytest.approx(
        np.interp(at, *np.array(sorted(zip(np.log10(theirs.up), theirs.across, strict=True))).T), abs=2e-3
    )


def test_a_curve_lies_on_the_boundary_over_an_axis_in_another_unit(tmp_path):
    """The curve's numbers are in m and V*, the axes in mm and um/s; V* is 2 um/s."""
    scene = sw.read("paper-si", {"interface.reference_velocity": 2e-6, "V": 50.0})
    of = {"of": "HB", "over": "slab.thickness=0.02:0.06", "along": "V=40:60"}
    written = sw.curve(scene, model="block8", **of)
    assert [written.dataset[name].attrs["units"] for name in ("slab_thickness", "V", "bracket")] == ["m", "1", "m"]
    written.to_netcdf(tmp_path / "hb.nc")
    vary = {"slab.thickness": ["20 mm", "60 mm"], "V": ["80 um/s", "120 um/s"]}
    found = sw.sweep(scene, vary=vary, models="block8", measure="stability", workers=1)
    onset, curve = sw.map(found, curve=[str(tmp_path / "hb.nc")]).boundaries
    other = sw.sweep(scene, settings=["a=0.036"], vary=vary, models="block8", measure="stability", workers=1)
    with pytest.raises(SceneError, match=r"of another scene, whose friction law differs from the sweep's"):
        sw.map(other, curve=[str(tmp_path / "hb.nc")])
    assert curve.name == "HB, block8"
    assert 80.0 <= min(curve.up) < max(curve.up) <= 120.0
    assert curve.across == pytest.approx(np.interp(curve.up, *np.array(sorted(zip(onset.up, onset.across, strict=True))).T), 1e-3)
    grip = {"face.kind": "grip", "face.impedance": 3.0, "face.stiffness": "20 MPa/m"}
    held = sw.sweep(scene, vary={"face.stiffness": ["20 MPa/m", "40 MPa/m"]}, set=grip, models="block8", until=1.0, workers=1)
    with pytest.raises(SceneError, match="has no unit there; the sweep has it in MPa/m"):
        _bare(held.dataset["slab_face_stiffness"], sw.read(scene, grip))


def test_curves_of_files_that_can_be_continued_are_drawn_each_with_its_own_line(tmp_path, printed):
    """Files of all kinds but HB; before, they held no curve, on the command line there was room for one file, and one over
    log10 r was none over r."""
    ranges = {"over": "log10_r=-2.72:-2.69", "along": "V=100:101", "model": "kelvin-voigt"}
    folds = sw.curve("paper", of="LP", tol=1e-3, most_points=2, out=tmp_path / "lp.nc", **ranges)
    sw.curve("paper", of="HB", out=tmp_path / "hb.nc", **ranges)
    how, velocities = {"models": "delay", "measure": "stability", "workers": 1}, {"V": [100.0, 101.0]}
    found = sw.sweep("paper", vary={"log10_r": [-2.72, -2.69]} | velocities, out=tmp_path / "out", **how)
    _, drawn = sw.map(found, curve=tmp_path / "lp.nc").boundaries
    assert drawn.across.tolist() == [one["log10_r"] for one in folds.summary["points"]]
    assert drawn.up.tolist() == [one["V"] for one in folds.summary["points"]]
    (over_r,) = sw.map(sw.sweep("paper", vary={"r": [0.0019, 0.0021]} | velocities, **how), curve=tmp_path / "lp.nc").boundaries[
        -1:
    ]
    assert over_r.across == pytest.approx(10.0**drawn.across, rel=1e-12)
    sw.curve("paper", of="HB", over="r=0.0019:0.0021", along="V=100:101", model="kelvin-voigt", out=tmp_path / "r.nc")
    assert sw.map(found, curve=tmp_path / "r.nc").boundaries[-1].across == pytest.approx(-2.69955, abs=0.003)
    files = [str(tmp_path / name) for name in ("lp.nc", "hb.nc")]
    told = printed("map", str(tmp_path / "out"), "--curve", *files, "--plot", str(tmp_path / "map.svg"))
    assert "boundary: LP, kelvin-voigt\nboundary: HB, kelvin-voigt\n" in told
    lines = {one.name: str(one.look.dashes) for one in sw.map(found, curve=files).chart().panels[0].traces[1:] if one.name}
    assert [*lines] == ["onset of instability", "LP, kelvin-voigt", "HB, kelvin-voigt"]
    assert len({*lines.values()}) == 3


def test_the_boundary_over_variables_is_that_of_the_scenes_written_out():
    """q changes the impedance of one slab and s, on a logarithmic axis, both round trips."""
    sets = {"upper.epsilon": "2.8e-5*q", "lower.epsilon": 2.8e-5, "upper.r": "0.002*s", "lower.r": "0.0028*s"}
    data = lattice(
        {"q": (np.linspace(0.5, 3.0, 5), "q", "1"), "s": (np.geomspace(0.2, 3.0, 5), "s", "1")},
        scene_toml=sw.show("paper"),
        manifest=json.dumps({"set": sets}),
    )
    (line, *_), notes = onset_lines(data)
    assert notes == []
    for q, s in list(zip(line.across.tolist(), line.up.tolist(), strict=True))[1:-1:9]:
        slabs = {"upper.epsilon": 2.8e-5 * q, "lower.epsilon": 2.8e-5, "upper.r": 0.002 * s, "lower.r": 0.0028 * s}
        root = sw.stability("paper", **slabs).summary["leading_roots"][0]
        assert abs(root[0]) < 1e-6 * abs(root[1])


def test_a_slab_that_is_set_keeps_its_value_along_an_axis_over_both():
    axes = {"q": (np.linspace(0.5, 3.0, 5), "q", "1"), "e": (np.geomspace(1e-5, 1e-4, 5), "slab.epsilon", "1")}
    ((line, *_), _) = onset_lines(
        lattice(axes, scene_toml=sw.show("paper"), manifest=json.dumps({"set": {"lower.epsilon": "2.8e-5*q"}}))
    )
    for q, epsilon in list(zip(line.across.tolist(), line.up.tolist(), strict=True))[1:-1:9]:
        root = sw.stability("paper", **{"slab.epsilon": epsilon, "lower.epsilon": 2.8e-5 * q}).summary["leading_roots"][0]
        assert abs(root[0]) < 1e-6 * abs(root[1])


@pytest.mark.parametrize(
    ("axes", "note"),
    [
        (
            {"h": ([1.0, 2.0], "slab.density", "g/cm3"), "v": ([1.0, 2.0], "drive.velocity", "1")},
            "slab.density = 1000: must come with interface.normal_stress, memory_length and reference_velocity (SI), or be "
            "replaced by epsilon and r",
        ),
        (
            {"w": (["ageing", "slip"], "interface.law", "1"), "v": ([1.0, 2.0], "drive.velocity", "1")},
            "it is not computed over w",
        ),
        (
            {"r": ([-2.5, -2.4], "slab.log10_r", "1"), "v": ([100.0, 110.0], "drive.velocity", "1")},
            "steady sliding does not change its stability on this map",
        ),
    ],
)
def test_a_map_without_boundary_says_why(axes, note):
    lines, notes = onset_lines(lattice(axes, scene_toml=sw.show("paper")))
    assert (lines, [one.partition(": ")[2] for one in notes]) == ((), [note])


def test_the_boundary_over_a_coefficient_is_where_the_stability_changes():
    axes = {
        "r": (np.linspace(-2.72, -2.6, 5), "slab.log10_r", "1"),
        "c": (np.linspace(0.99, 1.0, 3), "slab.face.coefficient", "1"),
    }
    (line,) = onset_lines(lattice(axes, scene_toml=sw.show("reflection")))[0]
    at = len(line.up) // 2
    stable = [
        sw.stability("reflection", log10_r=float(line.across[at]) + beside, **{"face.coefficient": float(line.up[at])}).stable
        for beside in (-1e-4, 1e-4)
    ]
    assert stable == [True, False]


def test_only_curves_beyond_which_no_other_root_grows_are_boundaries():
    """Equation (39): pairs cross at r = (2/w_c)(atan(r_* w_c/2) + n pi); from n = 1 on another grows already."""
    axes = {"r": (np.linspace(0.001, 0.015, 3), "slab.r", "1"), "v": (np.linspace(300.0, 1000.0, 3), "drive.velocity", "1")}
    (line,), notes = onset_lines(lattice(axes, scene_toml=sw.show("paper")))
    half = 0.5 * line.up * math.sqrt(0.014 / 0.0349)
    assert notes == []
    assert line.across == pytest.approx(np.arctan(2.8e-5 / 0.014 * half) / half, rel=1e-9)


def test_without_a_spring_a_single_root_crosses_on_a_boundary_too():
    """Z(0) = (epsilon/2)(1 + R)/(1 - R) is (b - a)/V at R = 9/11. The pair's curve is in one corner of the map."""
    axes = {
        "c": (np.linspace(-0.9, 0.9, 3), "slab.face.coefficient", "1"),
        "r": (np.linspace(-2.9, -1.0, 3), "slab.log10_r", "1"),
    }
    pair, single = onset_lines(lattice(axes, scene_toml=sw.show("reflection")))[0]
    assert single.across == pytest.approx(np.full(len(single.up), 9.0 / 11.0), rel=1e-9)
    for r in pair.up[[len(pair.up) // 4, len(pair.up) // 2]].tolist():
        coefficient = float(pair.across[pair.up == r][0])
        stable = [
            sw.stability("reflection", **{"log10_r": r + beside, "face.coefficient": coefficient}).stable
            for beside in (-1e-4, 1e-4)
        ]
        assert stable == [True, False]


@pytest.mark.parametrize("key", ["slab.log10_r", "slab.thickness"])
def test_the_boundary_over_slabs_leaves_a_machine_as_it_is(key):
    """A machine in Pa/m keeps its spring where slabs get thicker: the points of a sweep do, and so does the boundary."""
    face = {"kind": "machine", "stiffness": 2e8, "impedance": 0.0, "mass": 0.0}
    scene = sw.read_scene("paper-si", **{"slab.face": face})
    along = np.linspace(-2.9, -2.5, 5) if key == "slab.log10_r" else np.linspace(0.02, 0.05, 5)
    axes = {"r": (along, key, "1"), "v": (np.linspace(80.0, 150.0, 5), "drive.velocity", "1")}
    (line,) = onset_lines(lattice(axes, scene_toml=sw.show(scene)))[0]
    at = len(line.up) // 2
    root = sw.stability(scene, **{key: float(line.across[at]), "V": float(line.up[at])}).summary["leading_roots"][0]
    assert abs(root[0]) < 1e-6 * abs(root[1])


@pytest.mark.parametrize(
    ("scene", "key", "label"),
    [
        ("paper-si", "slab.thickness", "thickness H / m"),
        ("paper-si", "interface.normal_stress", "normal stress σ / Pa"),
        ("steel-on-pmma", "upper.face.stiffness", "stiffness of the face's spring of the upper slab / (Pa/m)"),
        ("machine", "slab.face.stiffness", "stiffness of the face's spring / (ε/r)"),
        ("paper-si", "machine.k", "stiffness of the whole sample over normal stress k / (1/m)"),
        ("paper", "machine.k", "stiffness of the whole sample over normal stress k / (1/L)"),
        ("grip", "slab.face.stiffness", "stiffness of the face's spring / (ε/r)"),
        ("viscous", "slab.viscosity.time", "retardation time / (L/V*)"),
        (RELAXING, "slab.viscosity.time", "relaxation time / (L/V*)"),
    ],
)
def test_an_axis_of_bare_numbers_says_their_unit(scene, key, label):
    axes = {"x": (np.array([1.0, 2.0]), key, "1")}
    assert chart_of_sweep(lattice(axes, scene_toml=sw.show(scene))).panels[0].x.label == label


def test_a_sweep_of_stability_shows_stability_and_its_figures():
    single, double = (
        sw.sweep("paper", vary=axes, measure="stability", workers=1)
        for axes in ({"log10_r": [-2.72, -2.6]}, {"log10_r": [-2.72, -2.6], "V": [100.0, 120.0]})
    )
    assert [panel.y.label for panel in sw.map(single).chart().panels] == ["unstable roots", "stable"]
    assert [panel.name for panel in sw.map(double, plain=True).chart().panels] == ["delay: stable"]


def test_an_axis_of_words_is_drawn_with_its_words():
    data = lattice(
        {"w": (["ageing", "slip", "own"], "interface.law", "1"), "v": ([1.0, 2.0, 4.0], "drive.velocity", "1")},
        scene_toml=sw.show("paper"),
    )
    data["period"] = data["status"].copy(data=np.arange(9.0).reshape(3, 3))
    (panel, *_) = chart_of_sweep(data.isel(v=0), "period").panels
    assert (panel.x.ticks, panel.x.limits) == ({0.0: "ageing", 1.0: "slip", 2.0: "own"}, (-0.5, 2.5))
    draw(chart_of_sweep(data.isel(v=0), "period"))
    (panel,) = chart_of_sweep(data, "period").panels  # beside numbers each word is a curve
    assert [trace.name for trace in panel.traces] == ["delay, ageing", "delay, slip", "delay, own"]
    assert [list(trace.y) for trace in panel.traces] == np.arange(9.0).reshape(3, 3).tolist()


def test_points_without_a_regime_are_hatched_by_their_reason():
    data = lattice({"a": ([1.0, 2.0, 3.0, 4.0], "a", "1"), "b": ([1.0, 2.0], "b", "1")})
    words = [["periodic", ""], ["too short", ""], ["periodic", "steady"], ["irregular", "torus"]]
    data["verdict"] = data["status"].copy(data=np.array(words))
    data["verdict"].attrs["flag_meanings"] = " ".join(word.replace(" ", "_") for word in VERDICTS)
    data["status"].values[:2, 1] = -1, 2
    (cells,) = chart_of_sweep(data, "verdict").panels[0].traces
    told = [[list(cells.look.colors)[number] for number in row] for row in cells.value]
    assert told == [["periodic", "too short", "periodic", "irregular"], ["not computed", "no figures", "steady", "torus"]]
    hatched = [one.get_hatch() for one in draw(chart_of_sweep(data, "verdict")).axes[0].patches]
    assert sorted(hatched) == sorted(HATCHES.values())


def test_differences_of_models_are_drawn_and_chosen(tmp_path):
    vary = {"log10_r": (-2.7, -2.6, 3), "V": [90.0, 100.0]}
    options = {"models": "block8,block12,kelvin-voigt", "until": 1500, "tol": 1e-6, "workers": 1}
    found = sw.sweep("paper", vary=vary, out=tmp_path / "out", **options)
    panels = sw.map(found, against="block12").chart().panels
    assert [panel.name.partition(":")[0] for panel in panels] == ["block8"] * 3 + ["kelvin-voigt"] * 3
    assert panels[1].traces[-1].name == "period / that of block12 − 1"
    one = sw.map(found, against="block12", model="block8")
    assert [row["model"] for row in one.summary["differences"]] == ["block8"]
    assert len(one.chart().panels) == 3
    with pytest.raises(SceneError, match="model = 'block12': must be a model to compare with block12, block8, kelvin-voigt"):
        sw.map(found, against="block12", model="block12")
    with pytest.raises(SceneError, match="is no netCDF file"):
        sw.map(found, against="block12", curve=["none.nc"])


@pytest.mark.parametrize("size", SIZES)
def test_a_figure_has_the_size_of_a_column(swept, tmp_path, size):
    found = sw.map(swept[0], size=size, title="Slabs in SI", plain=True)
    found.save_plot(tmp_path / "map.png")
    width = struct.unpack(">I", (tmp_path / "map.png").read_bytes()[16:20])[0]
    assert width / 300.0 * 2.54 == pytest.approx(SIZES[size], abs=0.01)
    figure = found.plot()
    assert figure.get_suptitle() == "Slabs in SI"
    assert max(text.get_fontsize() for text in figure.findobj(matplotlib.text.Text)) < 9.0
    with pytest.raises(SceneError, match="must be single or double"):
        sw.map(swept[0], size="huge")


def texts_of(figure):
    """All that is written: legend, titles, labels, and ticks within their axes."""
    every = [axes for outer in figure.axes for axes in (outer, *outer.child_axes)]
    found = [text for legend in figure.legends for text in legend.get_texts()]
    for axes in every:
        found += [getattr(axes, "_left_title", axes.title), axes.title]
        for axis in (axes.xaxis, axes.yaxis):
            low, high = sorted(axis.get_view_interval())
            places = zip(axis.get_majorticklocs(), axis.get_majorticklabels(), strict=False)
            found += [axis.label, *(text for at, text in places if low <= at <= high)]
    return [text for text in found if text.get_visible() and text.get_text().strip()]


def colliding(chart):
    """The pairs of texts that overlap, the number of all, and those that leave the figure."""
    figure = draw(chart)
    renderer = FigureCanvasAgg(figure).get_renderer()
    figure.draw(renderer)
    boxes = [(text.get_text(), text.get_window_extent(renderer)) for text in texts_of(figure)]
    outside = [text for text, box in boxes if box.y0 < 0.0 or box.y1 > figure.bbox.y1]
    return [(one, other) for (one, a), (other, b) in itertools.combinations(boxes, 2) if a.overlaps(b)], len(boxes), outside


def test_labels_do_not_collide(swept):
    chart = sw.map(swept[0]).chart()
    for one in (chart, *(in_print(chart, size) for size in SIZES)):
        pairs, count, _ = colliding(one)
        assert count > 40
        assert pairs == []


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize(
    ("scene", "vary", "until", "panels"),
    [("paper", {"V": [500.0, 2000.0]}, 600.0, 3), ("paper-si", {"thickness": ["3 cm", "4 cm", "6 cm"]}, 20.0, 1)],
)
def test_labels_over_one_axis_do_not_collide_in_a_column(size, scene, vary, until, panels):
    """Neither those of figures nor those of a strip of regimes alone, where no point has figures."""
    found = sw.sweep(scene, vary=vary, models="block8,kelvin-voigt", until=until, tol=1e-6, workers=1)
    chart = sw.map(found).chart()
    assert len(chart.panels) == panels
    pairs, _, outside = colliding(in_print(chart, size))
    assert (pairs, outside) == ([], [])


@pytest.mark.parametrize(("low", "high", "told"), [(1e-5, 1e-4, 3), (50.0, 1000.0, 4), (2e-7, 3e-6, 3), (1.0, 6.0, 4)])
def test_a_short_logarithmic_scale_has_labelled_ticks(low, high, told):
    figure = draw(Chart([Panel("", Scale("x", "log", (low, high)), Scale("y", limits=(0.0, 1.0)), [])]))
    axis = figure.axes[0].xaxis
    labels = axis.get_major_formatter().format_ticks([at for at in axis.get_majorticklocs() if low <= at <= high])
    assert len(labels) >= told
    assert all(labels)


def test_an_axis_of_scenes_has_ticks_at_whole_numbers():
    for count, last in ((3, "2"), (25, "24")):
        ticks = chart_of_sweep(lattice({"scene": (np.arange(count), "scene", "1")}).drop_vars("scene")).panels[0].x.ticks
        assert (ticks[0.0], [*ticks.values()][-1], len(ticks) <= 10) == ("0", last, True)


def test_edges_of_cells_lie_half_way_on_their_scale():
    assert cell_edges([1.0, 2.0, 4.0]).tolist() == [0.5, 1.5, 3.0, 5.0]
    assert cell_edges([1.0, 100.0], "log") == pytest.approx([0.1, 10.0, 1000.0])
    assert cell_edges([0.0]).tolist() == [-0.5, 0.5]
    assert cell_edges([100.0, 1000.0]).tolist() == [50.0, 550.0, 1450.0]


def test_one_axis_shows_figures_and_regimes_and_one_point_its_run():
    one = sw.sweep("paper", vary={"V": [500.0, 2000.0]}, models="block8,kelvin-voigt", until=600.0, tol=1e-6, workers=1)
    *figures, strip = one.chart().panels
    assert [panel.y.label for panel in figures] == ["period / transits", "stress drop / normal stress"]
    assert [[VERDICTS[number] for number in row] for row in strip.traces[0].value] == one.dataset["verdict"].values.tolist()
    assert list(strip.y.ticks.values()) == ["block8", "kelvin-voigt"]
    point = sw.sweep("paper", vary={"V": [2000.0]}, models="kelvin-voigt", until=200.0, workers=1)
    assert "friction stress" in point.chart().panels[0].y.label
    row = [line.split() for line in point.lines(point.summary)][-1]
    assert row[:3] == ["kelvin-voigt", "2000", "periodic"]
    assert float(row[3]) == pytest.approx(float(point.dataset["period"].values[0]), rel=1e-6)


def test_a_size_keeps_the_figure_in_one_column_or_two():
    chart = Chart([Panel(str(k), Scale(), Scale(), []) for k in range(3)], 3.6, 3, 12.0)
    single, double = in_print(chart, "single"), in_print(chart, "double")
    assert (single.columns, double.columns) == (1, 2)
    assert single.height == pytest.approx(3.0 * 3.6 * (8.5 / 2.54) / 4.0)
    assert double.height == pytest.approx(2.0 * 3.6 * (8.5 / 2.54) / 4.0)
    assert replace(double, height=1.0).is_exact
