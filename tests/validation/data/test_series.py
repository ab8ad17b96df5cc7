"""A record in whatever shape is read into the same columns in SI, or refused in one line; a pipe to its end."""

import os
import threading
from contextlib import suppress

import numpy as np
import pytest

import slipwave as sw
from slipwave import SceneError, files, read_scene
from slipwave.files import content_of
from slipwave.observe import HistoryObserver
from slipwave.observe.history import named_columns
from slipwave.solve import follow
from validation.data.quantities import heading
from validation.data.series import Series, read_series
from validation.data.variables import stored_name
from validation.models.build import build

TIME, MOVED, FRICTION = [0.0, 0.5, 1.25], [0.0, 5e-6, 1.25e-5], [0.6, 0.61, 0.605]
ROWS = [[0, 0, 0.6], [500, 5, 0.61], [1250, 12.5, 0.605]]  # ms, um, 1


def written(folder, text, encoding="utf-8"):
    path = folder / "steps.csv"
    path.write_bytes(text.encode(encoding))
    return str(path)


def body(between=",", point="."):
    return "".join(between.join(f"{value:g}".replace(".", point) for value in row) + "\n" for row in ROWS)


@pytest.mark.parametrize(
    ("text", "options"),
    [
        ("Time [ms],disp_um,mu\n" + body(), {}),
        ("# a comment\n% another\n\nTime (ms);Displacement (µm);Friction [-]\n" + body(";", ","), {}),
        ("# p4347\n# t_ms  load point displacement [um]  mu\n" + body(" "), {"columns": "t [ms],disp [um],mu"}),
        ("time [ms]  load point displacement [um]   friction coefficient\n" + body("   "), {}),
        ("Time\tDisp\tmu\nms\tmicron\t.\n".replace(".", "-") + body("\t"), {}),
        (body(" "), {"columns": "time,displacement,friction", "units": "ms,um,1"}),
        ("a,b,c\r\n" + body().replace("\n", "\r\n"), {"columns": "time,disp,mu", "units": "disp=um,time=ms"}),
        ('"Time, ms","disp / um","mu"\n' + body(), {}),
        ("Zeit [ms];Kolbenweg [um];Reibung [-]\n" + body(";", ","), {"columns": "time,disp,friction"}),
        ("Zeit;Weg;Reibung\nms;mV;%\n" + body(";"), {"columns": "time,disp,mu", "scale": "disp=1um,mu=100"}),
        ("time [ms],disp [mm],mu\n" + body(), {"scale": "disp = 1e-3"}),
    ],
)
def test_the_same_record_in_many_shapes(text, options, tmp_path):
    for encoding in ("utf-8", "latin-1"):
        found = read_series(written(tmp_path, text, encoding), **options)
        assert found.is_own is False
        for name, values in (("time", TIME), ("load_point_displacement", MOVED), ("friction", FRICTION)):
            np.testing.assert_allclose(found[name], values, rtol=1e-14, err_msg=text)


@pytest.mark.parametrize(
    ("text", "quantity", "unit"),
    [
        ("Disp. load point [\u00b5m]", "load_point_displacement", "\u00b5m"),
        ("\u03b4_lp (um)", "load_point_displacement", "um"),
        ("Ram Disp (mm)", "load_point_displacement", "mm"),
        ("Friction coeff. [-]", "friction", "-"),
        ("\u00b5", "friction", None),
        ("ShearStress_MPa", "shear_stress", "MPa"),
        ("Eff. normal stress (MPa)", "normal_stress", "MPa"),
        ("Normal disp (um)", "", "um"),
        ("Shear displacement (mm)", "", "mm"),
    ],
)
def test_a_heading_says_its_quantity_in_any_order_of_words(text, quantity, unit):
    assert heading(text) == (quantity, unit)


def test_lines_that_mark_missing_values_are_left_out_or_told(tmp_path):
    rows = [f"{k},{0.6 + 0.001 * (k % 3):g},7" for k in range(20)]
    rows[4], rows[9] = "4,-999.00,-999", "9,NaN,7"
    text = "time [s],mu,temperature\n" + "\n".join(rows) + "\n"
    found = read_series(written(tmp_path, text), missing="nan,-999")
    assert found["time"].tolist() == [k for k in range(20) if k not in (4, 9)]
    assert "2 lines with nan,-999 left out" in found.notes
    assert found["friction"].min() == 0.6
    with pytest.raises(SceneError, match=r"line 11: column 2 is 'NaN': must be a finite number \(--missing=nan leaves"):
        read_series(written(tmp_path, text))
    told = (
        "column 2, line 6: friction is -999, all others are from 0.6 to 0.602: if it stands for a missing value, --missing=-999"
    )
    with pytest.raises(SceneError, match=told):
        read_series(written(tmp_path, text), missing="nan")
    high = text.replace("-999.00", "9.5").replace("NaN", "9.5")  # in two lines
    with pytest.raises(SceneError, match=r"line 6: friction is 9\.5"):
        read_series(written(tmp_path, high))
    near = text.replace("-999.00", "0.595").replace("NaN", "0.61")
    assert len(read_series(written(tmp_path, near))) == 20  # four times the range of the others away


def test_columns_of_the_seas_benchmarks_are_known_by_name(tmp_path):
    text = "# problem=BP1\n# step 2\nt slip slip_rate shear_stress state\n0 0 -9 29.5 8.5\n60 1e-3 -2 28 8.25\n"
    found = read_series(written(tmp_path, text))
    expected = {"time": [0, 60], "slip": [0, 1e-3], "slip_rate": [1e-9, 1e-2], "shear_stress": [29.5e6, 28e6]}
    for name, values in (expected | {"state": [10**8.5, 10**8.25]}).items():
        np.testing.assert_allclose(found[name], values, rtol=1e-14)
    two = (
        text.replace("slip ", "slip_2 slip_3 ")
        .replace("slip_rate ", "slip_rate_2 ")
        .replace("0 0 ", "0 0 7 ")
        .replace("e-3", "e-3 7")
    )
    np.testing.assert_allclose(
        read_series(written(tmp_path, two.replace("shear_stress", "shear_stress_2")))["slip_rate"], [1e-9, 1e-2]
    )


def test_friction_is_shear_over_normal_stress():
    stresses = {"time": np.arange(2.0), "shear_stress": np.array([3e6, 6e6]), "normal_stress": np.array([6e6, 1e7])}
    np.testing.assert_allclose(Series("x", stresses).friction(), [0.5, 0.6])
    del stresses["normal_stress"]
    np.testing.assert_allclose(Series("x", stresses).friction(6e6), [0.5, 1.0])
    with pytest.raises(SceneError, match="'x': shear stress without normal stress gives no friction"):
        Series("x", stresses).friction()
    with pytest.raises(SceneError, match="'x': has no column friction; the columns read are time;"):
        Series("x", {"time": np.arange(2.0)}).friction()


def test_a_force_is_a_stress_on_the_area_given(tmp_path):
    file = written(tmp_path, "t [s],F_s [kN],F_n [kN]\n0,60,100\n1,30,100\n")
    named = {"columns": "time,shear_stress,normal_stress"}
    found = read_series(file, **named, area="25 cm2")
    np.testing.assert_allclose(found["shear_stress"], [24e6, 12e6])
    np.testing.assert_allclose(found.friction(), [0.6, 0.3])
    with pytest.raises(SceneError, match="column 2, shear_stress: unit 'kN' is a force: --area says on what"):
        read_series(file, **named)
    for area in ("25", "25 cm", "0 cm2"):
        with pytest.raises(SceneError, match=f"--area = '{area}': must"):
            read_series(file, **named, area=area)


def test_a_friction_that_no_interface_has_is_refused_with_the_columns(tmp_path):
    file = written(tmp_path, "Zeit [s],Spannung\n0,4.8\n1,4.7\n")
    with pytest.raises(SceneError, match=r"shear over normal stress is 5\.9e-07, which is no friction: .* Zeit \[s\], Spannung"):
        read_series(file, columns="time,stress").friction(8e6)
    np.testing.assert_allclose(read_series(file, columns="time,stress", units=",MPa").friction(8e6), [0.6, 0.5875])


def test_a_record_in_the_units_of_a_scene():
    scene = read_scene("paper-si")
    assert scene.units is not None
    second, metre = scene.units.size("transit", scene.transit), scene.units.memory_length
    record = Series("x", {"time": np.array([second]), "slip": np.array([2 * metre]), "slip_rate": np.array([3e-6])})
    own = record.of(scene)
    assert [own["time"][0], own["slip"][0], own["slip_rate"][0]] == pytest.approx([1.0, 2.0, 3.0], rel=1e-12)
    assert own.of(read_scene("paper"))["time"][0] == own["time"][0]
    with pytest.raises(SceneError, match="'x': is in SI; scene 'paper' is not: give interface"):
        record.of(read_scene("paper"))


@pytest.mark.parametrize(
    ("text", "options", "told"),
    [
        ("", {}, "is empty"),
        (body(), {}, "has no heading: name its 3 columns by --columns"),
        ("time,mu,friction\n" + body(), {}, "columns 2 and 3 are both friction"),
        ("time,disp,mu\n0,0,0.6\n1,x,0.6\n", {}, "line 3: column 2 is 'x': must be a finite number"),
        ("time,disp,mu\n0,0,0.6\n1,0\n", {}, "line 3: column 3 is missing"),
        ("time,disp,mu\n0,0,0.6\n2,0,0.6\n1,0,0.6\n", {}, "line 4: time falls from 2 to 1: must rise"),
        ("time,disp,mu\n0,0,0.6\n0,0,0.6\n", {}, "time is 0 in every line"),
        ("time [parsec],mu\n0,0.6\n1,0.6\n", {}, "unit 'parsec' is not known there: known are s, ms, us, min, h, d, transit"),
        ("time [s],slip [L]\n0,0.6\n1,0.6\n", {}, "slip in the units of a scene, the rest in SI"),
        ("time,mu\n0,0.6\n1,0.6\n", {"columns": "time,color"}, "--columns: 'color' is no quantity of a record"),
        ("time,mu\n0,0.6\n1,0.6\n", {"columns": "time,mu,slip"}, "names 3 columns; .* has 2; its columns: time, mu"),
        ("time,mu\n0,0.6\n1,0.6\n", {"scale": "slip=2"}, "has no column slip; its columns: time, mu"),
        ("time,mu\n0,0.6\n1,0.6\n", {"scale": "mu=0"}, "--scale = 'mu=0': must be COLUMN=FACTOR"),
        ("0,0.6\n1,0.6\n", {"columns": "mu,_"}, "has no column time; its 2 columns have no names"),
        (
            "t [s],Weg [Zoll]\n0,0.6\n1,0.6\n",
            {"columns": "t,disp"},
            "column 2, load_point_displacement: unit 'Zoll' is not known",
        ),
    ],
)
def test_what_cannot_be_read_says_so_in_one_line(text, options, told, tmp_path):
    with pytest.raises(SceneError, match=told) as error:
        read_series(written(tmp_path, text), **options)
    assert "\n" not in str(error.value)


def test_a_file_that_is_not_there_and_one_of_bytes(tmp_path):
    with pytest.raises(SceneError, match="cannot be read: no such file"):
        read_series(tmp_path / "absent.csv")
    (tmp_path / "x.nc").write_bytes(b"CDF\0\1")
    with pytest.raises(SceneError, match="is no file of text"):
        read_series(tmp_path / "x.nc")


@pytest.mark.parametrize("pause", [0.0, 60.0])
def test_a_slow_clock_is_made_even_and_lines_cut_off_or_written_twice_are_left_out(pause, tmp_path):
    """On either side of a pause for itself."""
    times = np.arange(0.0, 20.0, 0.1) + np.where(np.arange(200) < 80, 0.0, pause)
    lines = ["time_s,disp_um", *(f"{np.floor(4.0 * t) / 4.0:.2f},{10.0 * t:.4f}" for t in times)]
    lines.append(f"{19.75 + pause},19")
    path = tmp_path / "clock.txt"
    path.write_text("\n".join([*lines[:9], *lines[8:]]), encoding="utf-16")
    series = read_series(path)
    np.testing.assert_allclose(series["time"] - series["time"][0], times, atol=0.01)
    np.testing.assert_allclose(series["load_point_displacement"], 1e-5 * times, atol=1e-10)
    assert "1 lines that are written twice left out" in series.notes


@pytest.mark.parametrize("name", ["paper", "paper-si"])
def test_a_run_is_written_as_a_record_and_read_back_equal(name, tmp_path):
    """Slip, which is taken from the elastic stress, is the integral of the slip rate."""
    result = sw.run(name, "block8", until=80, interface=True, **{"drive.velocity": [[0, 100], [40, 100], [40, 300]]})
    result.write_series(tmp_path / "run.csv")
    scene, data, found = result.done.solver.scene, result.dataset, read_series(tmp_path / "run.csv")
    assert found.is_own is (scene.units is None)
    own, time = found.of(scene), data["time"].values
    same = {"time": time, "slip_rate": data["interface_slip_rate"], "friction": data["interface_stress"]}
    for key, values in (same | {"shear_stress": data["interface_stress"], "state": np.exp(data["interface_psi"])}).items():
        np.testing.assert_allclose(own[key], values, rtol=1e-14, err_msg=key)
    moved = scene.transit * (100 * (time - time[0]) + 200 * np.clip(time - 40, 0, None))
    np.testing.assert_allclose(own["load_point_displacement"], moved, rtol=1e-12, atol=1e-12)
    rate, steps = own["slip_rate"], np.diff(time)
    slip = scene.transit * np.cumsum(0.5 * steps * (rate[1:] + rate[:-1]))
    np.testing.assert_allclose(own["slip"][1:], slip, atol=3e-4 * slip[-1])  # the error of trapezia
    if scene.units:
        np.testing.assert_allclose(found["shear_stress"], 1e3 * found["friction"], rtol=1e-14)


@pytest.mark.parametrize(("rate", "step"), [("250 Hz", 0.004 / 0.00188037), (4, 0.25)])
def test_even_samples_are_those_of_the_solver(rate, step, tmp_path):
    """A transit of this scene is 1.88037 ms."""
    scene = sw.read("paper-si")
    result = sw.run(scene, "block8", until=60, rate=rate)
    result.write_series(tmp_path / "even.csv")
    solver = build("block8", scene)
    history = HistoryObserver(solver.scene.law, solver.nodes)
    follow(solver, 60.0, [history])
    time = result.dataset["time"].values
    np.testing.assert_allclose(time, step * np.arange(int(60.0 / step) + 1), rtol=1e-5)
    for name, values in named_columns(scene.law, history.at(np.minimum(time, 60.0))).items():
        np.testing.assert_allclose(result.dataset[stored_name(name)], values, rtol=1e-12, atol=1e-12)
    assert read_series(tmp_path / "even.csv")["time"].size == len(time)


def test_a_record_is_thinned_unless_its_samples_are_chosen(tmp_path, monkeypatch):
    monkeypatch.setattr("validation.commands.run.MOST_LINES", 100)
    result, whole = (sw.run("paper", "block8", until=80, interface=True, every=every) for every in (None, 1))
    for one in (result, whole):
        one.write_series(tmp_path / f"{one is whole}.csv")
    thin, every = (read_series(tmp_path / f"{name}.csv")["time"] for name in (False, True))
    assert every.size == len(whole.records.history)
    assert thin.size <= 100 < 2 * thin.size
    assert np.array_equal(thin, every[:: -(-every.size // 100)])


def test_a_run_without_a_history_gives_no_record(tmp_path):
    with pytest.raises(SceneError, match="a record needs the interface's history: run with interface=True"):
        sw.run("paper", "block8", until=1, interface=False).write_series(tmp_path / "run.csv")


pytestmark = pytest.mark.skipif(os.name != "posix", reason="pipes and devices")
READERS = (
    ["fit", "velocity-steps", "--free", "a,b", "--data"],
    ["sweep", "paper", "--out", "map", "--rows"],
    ["compare", "steel-on-pmma", "--models", "quasidynamic", "--until", "2s", "--with"],
)


@pytest.mark.parametrize("words", READERS)
@pytest.mark.parametrize(
    ("name", "told"), [("/dev/zero", "a device"), ("folder", "a folder"), ("pipe", "pipe"), ("no", "no such")]
)
def test_what_is_no_data_is_refused(words, name, told, tmp_path, monkeypatch, refused):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(files.time, "sleep", lambda seconds: None)  # for a writer of the pipe
    os.mkdir("folder")
    os.mkfifo("pipe")
    assert told in refused(*words, name)


@pytest.fixture
def pipe(tmp_path):
    os.mkfifo(tmp_path / "pipe")

    def writing(content):
        def write():
            with suppress(BrokenPipeError), open(tmp_path / "pipe", "wb", buffering=0) as file:
                file.write(content)

        threading.Thread(target=write, daemon=True).start()
        return tmp_path / "pipe"

    return writing


def test_a_pipe_is_read_to_its_end(pipe):
    content = bytes(range(256)) * 10_000
    assert content_of(pipe(content), "here") == content


def test_a_pipe_without_end_ends(pipe, monkeypatch):
    monkeypatch.setattr(files, "MOST_BYTES", 100_000)
    monkeypatch.setattr(files, "_PROBE", 10_000)
    with pytest.raises(SceneError, match="here: is longer than 1 GB"):
        content_of(pipe(bytes(1_000_000)), "here")
