"""The command line as its users meet it: output, exit statuses, every option, the shell's conveniences, odd names."""

import importlib
import json
import os
import shlex
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path
from typing import get_args

import pytest

import slipwave
import slipwave as sw
from slipwave.errors import SceneError
from slipwave.input.source import load_tables
from validation import cli
from validation.cli import COMMANDS, INPUT_WRONG, command_called, main, spread
from validation.registry import build as models
from validation.results.options import options_of
from validation.run.progress import progress


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


def module(*words, **variables):
    """`python -m slipwave words`."""
    environment = os.environ | variables
    return subprocess.run(
        [sys.executable, "-m", "slipwave", *words], capture_output=True, text=True, env=environment, check=False
    )


def test_the_version_is_that_of_the_package():
    done = module("--version")
    assert (done.returncode, done.stdout, done.stderr) == (0, f"slipwave {version('slipwave')}\n", "")


@pytest.mark.parametrize(
    ("typed", "offered"),
    [("slipwave run paper-s", ["paper-si"]), ("slipwave run --model kel", ["kelvin-voigt"]), ("slipwave sta", ["stability"])],
)
def test_the_shell_completes_commands_scenes_and_models(typed, offered):
    count = str(len(typed.split()) - 1)
    done = module(_SLIPWAVE_COMPLETE="complete_bash", COMP_WORDS=typed, COMP_CWORD=count)
    assert (done.returncode, done.stdout.split()) == (0, offered)


def test_every_command_has_examples_that_it_accepts(printed):
    for name in cli.COMMANDS:
        command = cli.command_called(name)
        shown = printed(name, "--help").partition("Examples:\n")[2]
        lines = [line.strip() for line in shown.splitlines() if line.strip()]
        assert lines, name
        for line in lines:
            program, word, *rest = spread(shlex.split(line.partition(" > ")[0]))
            assert (program, word) == ("slipwave", name)
            command.make_context(name, rest)


def test_what_is_wrong_in_a_file_is_told_whole(tmp_path, refused):
    (tmp_path / "mine.toml").write_text("[slab]\nepsilon = 1e-5\ndensity 2700 kg/m3\n")
    told = "Expected '=' after a key in a key/value pair (at line 3, column 9)"
    assert refused("show", str(tmp_path / "mine.toml")).endswith(f"must be a TOML file; {told}")


@pytest.mark.parametrize("words", [["a=-1"], ["a", "-1"], ["a=", "-1"], ["b=2", "a=-1"], ["a", "-1", "b=-2.5e-3"]])
def test_values_after_set_may_be_negative(words):
    got = spread(["run", "paper", "--set", *words, "--json"])
    values = {got[k + 1] for k, word in enumerate(got) if word == "--set"}
    assert values - {"b=2", "b=-2.5e-3"} == {"a=-1"}
    assert got[-1] == "--json"


def test_a_figure_of_a_run_has_time_in_both_units(tmp_path):
    import slipwave as sw

    found = sw.run("paper-si", "block8", until=100, interface=True, **{"drive.velocity": 2000})
    above, below = found.plot().axes
    assert (above.get_ylabel(), below.get_ylabel()) == ("friction stress / normal stress", "slip rate / V*")
    assert below.get_xlabel() == "time / transits"
    time, stress = above.get_lines()[0].get_data()
    assert (time[-1], stress[-1]) == (100.0, found.summary["final"]["mu"])
    seconds, pascals = above.child_axes
    assert (seconds.get_xlabel(), pascals.get_ylabel()) == ("time / s", "friction stress / Pa")
    found.save_plot(tmp_path / "run.svg")
    transit = 9e-7 / 1e-6 * found.done.solver.scene.transit
    above.figure.savefig(tmp_path / "run.png")  # second axes take their limits when they are drawn
    assert seconds.get_xlim() == pytest.approx([limit * transit for limit in above.get_xlim()])
    assert pascals.get_ylim() == pytest.approx([limit * 1000.0 for limit in above.get_ylim()])


def test_matplotlib_is_silent_where_it_cannot_keep_its_fonts():
    """HOME cannot be written, and MPLCONFIGDIR is not set; it speaks where it is loaded first, as by --plot."""
    variables = {name: value for name, value in os.environ.items() if not name.startswith(("MPL", "XDG"))}
    variables |= {"HOME": "/dev/null/none"}
    code = "from validation.cli import main; main(['--version']); import matplotlib; print(matplotlib.get_cachedir())"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=variables, check=True)
    assert (done.stdout.split()[0], done.stderr) == ("slipwave", "")
    assert "none" not in done.stdout.splitlines()[-1]  # a temporary folder: it would have told


def test_a_run_that_is_compiled_loads_little(capsys):
    """Neither what draws and writes, nor scipy's functions, nor the half of numba that only compiles: 0.6 s of 1.5."""
    words = ["run", "paper"]
    assert main(words) == 0  # compiles what is not yet on the disk
    code = f"import sys; from validation.cli import main; main({words}); print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = done.stdout.splitlines()[-1].split()
    assert "numba" in loaded
    assert not set(loaded) & {"numba.np.linalg", "scipy.special", "scipy.linalg", "scipy.optimize"}
    assert not {name.partition(".")[0] for name in loaded} & {"matplotlib", "xarray", "netCDF4", "pandas", "tomli_w", "skfem"}


PAPER = (Path(slipwave.__file__).parent / "gallery" / "paper.toml").read_bytes()
SLIPWAVE = [sys.executable, "-m", "validation.cli"]


@pytest.mark.parametrize("name", ["\x1b[31mred", "a\nb", "bell\a", "\u202eleft", "\x7f"])
@pytest.mark.parametrize("key", ["name", "title"])
def test_a_name_that_is_not_printable_is_refused(key, name, tmp_path, refused):
    path = tmp_path / "x.toml"
    path.write_bytes(f"{key} = {json.dumps(name)}\n".encode() + PAPER.partition(b"\n")[2])
    err = refused("stability", str(path))
    assert err.startswith(f"slipwave: {key} = ")
    assert "must be a text of 1 to 200 printable characters" in err
    assert err.isprintable()


@pytest.mark.parametrize("name", [b"\xff\xfe \x1b[31mred", "grün".encode()])
def test_a_files_own_name_is_spelt_out(name, tmp_path):
    path = os.fsencode(tmp_path) + b"/" + name + b".toml"
    with open(path, "wb") as file:
        file.write(PAPER)
    read = slipwave.read(os.fsdecode(path)).name
    assert read.isprintable()
    read.encode("utf-8")
    environment = {**os.environ, "PYTHONIOENCODING": "ascii"}
    words = [*SLIPWAVE, "run", path, "--until", "20", "--out", "x.nc"]
    done = subprocess.run(words, env=environment, cwd=tmp_path, capture_output=True)
    assert done.returncode == 0, done.stderr
    assert b"\x1b" not in done.stdout + done.stderr
    assert done.stdout.splitlines()[0].startswith(b"scene ")
    assert (tmp_path / "x.nc").exists()


@pytest.mark.parametrize("name", [b"\xff.nc", b"\x1b[31m.nc"])
def test_a_file_to_write_must_have_a_printable_name(name, tmp_path):
    done = subprocess.run([*SLIPWAVE, "run", "paper", "--until", "20", "--out", name], cwd=tmp_path, capture_output=True)
    assert done.returncode == INPUT_WRONG
    assert b"cannot be printed" in done.stderr
    assert b"\x1b" not in done.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("option", ["--checkpoint", "--out", "--fields"])
def test_a_pipe_is_no_file_to_write(option, tmp_path, refused):
    """Opening one waits for ever for somebody at its other end."""
    path = tmp_path / ("x.npz" if option == "--checkpoint" else "x.nc")
    os.mkfifo(path)
    assert f"{option} = {str(path)!r}: is no regular file" in refused(
        "run", "paper", "--model", "fd", "--cells", "8", "--until", "20", option, str(path)
    )


@pytest.mark.parametrize(
    "text", ["a" + ".a" * 60_000 + " = 1", "[" + "a." * 60_000 + "a]", 'a = {"b"' + " . 'b'" * 10_000 + " = 1}"]
)
def test_a_key_without_end_is_refused_before_it_is_parsed(text, tmp_path, monkeypatch):
    """Its parser takes minutes, growing with the square of the parts."""
    path = tmp_path / "x.toml"
    path.write_bytes(PAPER + b"\n" + text.encode())
    monkeypatch.setattr("tomllib.loads", lambda text: pytest.fail("parsed"))
    with pytest.raises(SceneError, match="nested too deeply"):
        load_tables(path)
    with pytest.raises(SceneError, match="must be a TOML value"):
        slipwave.read({}, ["a={" + "b." * 60_000 + "b=1}"])


def test_a_name_is_no_markup(monkeypatch):
    monkeypatch.setattr("validation.run.progress.PATIENCE", -1.0)
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    with progress("[/red], [bold]delay", 2.0) as report:
        report(1.0)
        report(2.0)


SETTINGS = " --set slab.r=0.002 drive.velocity=50"


def test_every_argument_and_option_says_what_it_is_for():
    commands = {name: command_called(name) for name in COMMANDS}
    silent = [f"{name} {one.name}" for name, command in commands.items() for one in command.params if not one.help]
    assert not silent
    assert all(command.help and "slipwave " in command.epilog for command in commands.values())


SAMPLES = {int: ("5", 5), float: ("0.005", 0.005), str: ("1.5:2.5", "1.5:2.5"), Path: ("c.nc", Path("c.nc"))}


@pytest.fixture
def computed(monkeypatch, tmp_path):
    """The options with which a command computes."""
    monkeypatch.chdir(tmp_path)

    def of(words):
        seen = []

        def keep(source, options):
            seen.append((source, options))
            raise SceneError("called")

        function = getattr(sw, words.split()[0])
        keep.__annotations__ = function.__wrapped__.__annotations__
        with monkeypatch.context() as patch:
            patch.setattr(function, "__wrapped__", keep)
            assert main(words.split()) == INPUT_WRONG
        return seen[0]

    return of


@pytest.mark.parametrize("name", ["run", "stability", "compare", "bench", "orbit", "branch", "curve"])
def test_every_declared_option_arrives_under_its_own_name(name, computed):
    wanted = {"settings": ["slab.r=0.002", "drive.velocity=50"]}
    words = [name, "paper", *SETTINGS.split()]
    for one in options_of(getattr(sw, name).__wrapped__.__annotations__["options"]).values():
        kinds = {one.hint, *get_args(one.hint)}
        if one.name in wanted or one.name in ("law", "family") or not one.is_in("command line"):
            continue
        if bool in kinds or "stands_for" in one.more:
            words, wanted = [*words, one.flag], wanted | {one.name: one.more.get("stands_for", True)}
        else:
            text, value = next(SAMPLES[kind] for kind in (Path, str, float, int) if kind in kinds)
            words, wanted = [*words, one.flag, text], wanted | {one.name: value}
    source, options = computed(" ".join(words))
    assert source == "paper"
    assert {key: getattr(options, key) for key in wanted} == wanted


@pytest.mark.parametrize(
    ("words", "interface", "fields"),
    [
        ("--events a.csv", False, False),
        ("--out a.nc", None, None),
        ("--out a.nc --plot a.png --fields a.vtu", None, True),
        ("--series a.csv", True, False),
        ("--out a.nc --series a.csv", True, None),
    ],
)
def test_a_run_keeps_what_its_files_need(words, interface, fields, computed):
    """In a file of results, what the scene records."""
    given = computed(f"run paper {words}")[1]
    assert (given.interface, given.fields, given.samples is not None) == (interface, fields, "--out" in words)


@pytest.mark.parametrize(("command", "builder"), [("run", "prepare"), ("compare", "build_all")])
def test_numerical_options_reach_the_solver(command, builder, monkeypatch):
    called = {}

    def keep(*arguments, **options):
        called.update(options)
        raise SceneError("called")

    for place in (models, importlib.import_module(f"validation.results.{command}")):
        monkeypatch.setattr(place, builder, keep, raising=False)
    with pytest.raises(SceneError, match="called"):
        getattr(sw, command)("paper", "dg:3", cells=6, cfl=0.25, tol=1e-4, time="explicit")
    assert called == {"cells": 6, "cfl": 0.25, "tolerance": 1e-4, "time": "explicit"}
