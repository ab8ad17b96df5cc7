"""The command line as its users meet it: output, exit statuses."""

import subprocess
import sys

import pytest

from validation.cli import spread


def test_help_answers_at_once():
    """Nothing that takes long to import is imported for it (`make bench` times it)."""
    code = "import sys; from validation.cli import main; main(['--help']); print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    imported = {name.partition(".")[0] for name in done.stdout.splitlines()[-1].split()}
    assert not imported & {"numpy", "numba", "scipy", "matplotlib", "pydantic", "xarray", "netCDF4", "skfem", "jinja2"}
    solvers = {name for name in done.stdout.splitlines()[-1].split() if name.startswith(("reduced.", "fullwave."))}
    assert solvers <= {"reduced.families", "fullwave.families"}  # facts alone
    for name in ("run", "compare", "bench", "scenes", "report"):
        assert f"  {name} " in done.stdout


def test_no_words_at_all_is_a_call_for_help(printed):
    assert "Usage" in printed()


def test_a_grid_chosen_for_a_tolerance_is_told_with_its_error(answer, printed):
    words = ["run", "paper", "--model", "dg:5", "--tol", "1e-4", "--until", "150"]
    result = answer(*words)
    assert set(result["grid"]) == {"cells", "step", "quantity", "error_estimate"}
    assert result["grid"]["quantity"] == "cycles"
    assert 0.0 < result["grid"]["error_estimate"] <= 1e-4
    line = f"grid chosen for the tolerance: {result['grid']['cells']} cells, steps of at most {result['grid']['step']:.4g}"
    assert line in printed(*words)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["run"], "SCENE"),
        (["run", "papr"], '"paper"'),
        (["run", "no/such.toml"], "no such file"),
        (["run", "paper", "--modle", "delay"], "--modle"),
        (["run", "paper", "--model", "dely"], '"delay"'),
        (["run", "paper", "--model", "delay:3"], "takes no number"),
        (["run", "paper", "--until", "ten"], "run.until = 'ten'"),
        (["run", "paper", "--until", "60s"], 'run.until = "60s": must come with interface.normal_stress'),
        (["run", "paper", "--until", "60", "--cycles", "3"], "cycles = 3: must not be given together with until = 60"),
        (["run", "paper", "--cycles", "0"], "cycles = 0"),
        (["run", "paper", "--cycles", "3", "--set", "run.record=[]"], "run.record is empty"),
        (["run", "paper", "--until", "-5"], "run.until = -5"),
        (["run", "paper", "--until", "nan"], "run.until = nan"),
        (["run", "paper", "--set", "slab.epsilon=-1"], "slab.epsilon = -1"),
        (["run", "paper", "--set", "slab.r=1e-3", "slab.epsilom=1"], "slab.epsilom"),
        (["run", "paper", "--set", "slab"], "KEY=VALUE"),
        (["run", "paper", "--model", "delay", "--cells", "10"], "takes no cells"),
        (["run", "paper", "--model", "delay", "--tol", "0"], "tolerance = 0: must lie in [1e-14, 0.1] for model delay"),
        (["run", "paper", "--model", "dg", "--tol", "0"], "tolerance = 0: must lie in [1e-12, 0.1] for model dg"),
        (["run", "paper", "--model", "dg:7", "--tol", "1e-13"], "tolerance = 1e-13: must lie in [1e-12, 0.1] for model dg:7"),
        (["run", "paper", "--model", "fd", "--cells", "0"], "cells = 0"),
        (["run", "paper", "--model", "fd", "--cfl", "1.5"], "cfl = 1.5"),
        (["run", "paper", "--fields", "x.vtu", "--model", "delay"], "fields: model delay has no grid"),
        (["run", "viscous", "--model", "delay"], "Kelvin-Voigt viscosity"),
        (["run", "paper", "--model", "dg:5", "--time", "implicit"], "time = 'implicit': must be exact or explicit"),
        (["run", "paper", "--model", "fd", "--time", "exact"], "model fd takes no time; models that do: sbp:P, fem:P, dg:P"),
        (["run", "paper", "--model", "dg:5", "--time", "exact", "--cfl", "0.5"], "cfl = 0.5: the exact march has no step limit"),
        (["compare", "paper"], "--models"),
        (["compare", "paper", "--models", "delay,delay"], "more than once"),
        (["compare", "paper", "--models", "delay,"], "must be one of"),
        (["compare", "paper", "--models", "delay", "--out", "x.doc"], ".png"),
        (["compare", "paper", "--models", "delay", "--cells", "8"], "cells = 8"),
        (["report", "--only", "nonsense"], "nonsense"),
        (["orbits"], "orbits"),
        (["--bogus"], "--bogus"),
    ],
    ids=lambda value: "_".join(value) if isinstance(value, list) else "",
)
def test_wrong_input_is_one_line_and_status_2(refused, words, told):
    assert told in refused(*words)


def test_wrong_output_places_are_refused_before_anything_is_computed(refused, monkeypatch, tmp_path):
    monkeypatch.setattr("validation.results.run.simulate", lambda *_: pytest.fail("computed"))
    (tmp_path / "file").write_text("")
    for place, told in (
        ("missing/x.nc", "does not exist"),
        ("x.txt", ".nc"),
        ("file/x.nc", "does not exist"),
        ("x\0.nc", "--out"),
    ):
        assert told in refused("run", "paper", "--out", str(tmp_path / place))
    (tmp_path / "folder.nc").mkdir()
    assert "is a folder" in refused("run", "paper", "--out", str(tmp_path / "folder.nc"))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "folder.nc"]


def test_a_bug_is_a_traceback_and_status_1(tmp_path):
    code = "import sys, slipwave.input.source as g\ng.gallery_titles = lambda: 1 / 0\n"
    code += "from validation.cli import main; sys.exit(main(['scenes']))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 1
    assert "ZeroDivisionError" in done.stderr


@pytest.mark.parametrize("suffix", [".vtu", ".nc"])
def test_fields_of_the_last_transits_are_written_whole(tmp_path, answer, printed, suffix):
    out = tmp_path / f"field{suffix}"
    words = ["run", "paper", "--model", "fd", "--cells", "8", "--until", "120"]
    plain = answer(*words, "--fields", str(out))
    assert [path.name for path in tmp_path.iterdir()] == [out.name]
    if suffix == ".nc":
        import xarray

        with xarray.open_dataset(out) as data:
            assert float(data["time"][0]) == pytest.approx(20.0, abs=0.5)
            assert float(data["time"][-1]) == pytest.approx(120.0, abs=0.5)
    assert answer(*words)["final"] == pytest.approx(plain["final"], rel=1e-12)


def test_fields_that_a_scene_records_go_into_the_run_file(tmp_path, printed, refused):
    import xarray

    out = tmp_path / "run.nc"
    asked = ["run", "unlike", "--until", "20", "--set", 'run.record=["events", "fields"]', "--out", str(out)]
    printed(*asked, "--model", "sbp:6", "--cells", "16")
    with xarray.open_dataset(out, group="fields") as data:
        assert {"upper_velocity", "lower_stress"} <= set(data)
        assert float(data["time"].diff("time").max()) < 0.2  # steps, not pieces of eight
    before = out.read_bytes()
    assert "run.record" in refused(*asked, "--model", "delay")
    assert out.read_bytes() == before


def test_options_take_several_values():
    assert spread(["run", "p", "--set", "a=1", "b=2", "--json"]) == ["run", "p", "--set", "a=1", "--set", "b=2", "--json"]
    assert spread(["run", "--set", "a=1", "p"]) == ["run", "--set", "a=1", "p"]
    assert spread(["report", "--only", "x", "y", "--quick"]) == ["report", "--only", "x", "--only", "y", "--quick"]
    assert spread(["run", "p", "--set", "a=1", "--set", "b=-2"]) == ["run", "p", "--set", "a=1", "--set", "b=-2"]
    assert spread(["--set"]) == ["--set"]
