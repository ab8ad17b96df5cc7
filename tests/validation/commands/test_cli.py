"""The command line as its users meet it: output, exit statuses, every option, the shell's conveniences, odd names."""

import json
import os
import shlex
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path
from typing import get_args

import pytest
import xarray
from typer.main import get_command

import slipwave
from slipwave.errors import SceneError
from slipwave.input.assemble import load_tables
from tests.copies import in_a_copy
from validation.commands.cli import COMMANDS, INPUT_WRONG, NUMERICS_FAILED, app, main
from validation.commands.options import options_of
from validation.models.build import build


def python(code, **environment):
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment or None)


def test_help_answers_at_once():
    """Nothing that takes long to import is imported for it (`make bench` times it)."""
    shown = python("import sys; from validation.commands.cli import main; main(['--help']); print(*sys.modules)").stdout
    loaded = shown.splitlines()[-1].split()
    assert not {name.partition(".")[0] for name in loaded} & {
        "numpy", "numba", "scipy", "matplotlib", "pydantic", "xarray", "netCDF4", "skfem", "jinja2"
    }  # fmt: skip
    solvers = {name for name in loaded if name.startswith(("reduced.", "fullwave."))}
    assert solvers <= {"reduced.families", "fullwave.families"}  # facts alone
    assert [name for name in ("run", "compare", "bench", "scenes", "report") if f"  {name} " not in shown] == []


def test_a_run_that_repeats_imports_no_stability_and_no_figures():
    code = "import sys; from validation.commands.cli import main; main(['run', 'reflection', '--json']); print(*sys.modules)"
    shown = python(code).stdout
    assert '"verdict": "periodic' in shown
    unneeded = ("reduced.stability", "reduced.orbit", "matplotlib", "xarray", "scipy.s")
    assert [name for name in shown.splitlines()[-1].split() if name.startswith(unneeded)] == []


@pytest.mark.parametrize(
    ("place", "told"),
    [
        ("missing/x.nc", "does not exist"),
        ("x.txt", ".nc"),
        ("a.nc", "is a folder"),
        ("\x1b[31m.nc", "cannot be printed"),
        ("pipe.nc", "--out = 'pipe.nc': is no regular file"),  # to open one waits for ever for somebody at its other end
    ],
)
def test_a_wrong_output_place_is_refused_before_anything_is_computed(refused, monkeypatch, tmp_path, place, told):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("validation.commands.run.simulate", lambda *_: pytest.fail("computed"))
    (tmp_path / "file").write_text("")
    (tmp_path / "a.nc").mkdir()
    for suffix in ("nc", "npz"):
        os.mkfifo(tmp_path / f"pipe.{suffix}")
    line = refused("run", "paper", "--checkpoint" if place.endswith("npz") else "--out", place)
    assert (told in line, "\x1b" in line) == (True, False)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.nc", "file", "pipe.nc", "pipe.npz"]


def test_ctrl_c_is_one_line_as_soon_as_python_has_started():
    """Before, it was a traceback until all modules of the start were imported."""
    hook = "type('Hook', (), {'find_spec': lambda self, name, *more: signal.raise_signal(2) if 'hidden' in name else None})()"
    heard = "import signal, sys; signal.signal(2, signal.default_int_handler)"  # it may be ignored where tests are run
    start = f"{heard}; sys.meta_path.insert(0, {hook}); from slipwave.__main__ import main; sys.exit(main())"
    done = subprocess.run([sys.executable, "-c", start], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (130, "slipwave: interrupted\n")


def test_a_bug_is_a_traceback_and_status_1():
    code = "import sys, slipwave.input.assemble as g\ng.gallery_titles = lambda: 1 / 0\n"
    done = python(code + "from validation.commands.cli import main; sys.exit(main(['scenes']))")
    assert (done.returncode, done.stderr.splitlines()[-1]) == (1, "ZeroDivisionError: division by zero")


@pytest.mark.parametrize("suffix", [".vtu", ".nc"])
def test_fields_of_the_last_transits_are_written_whole(tmp_path, answer, suffix):
    out, words = tmp_path / f"field{suffix}", ["run", "paper", "--model", "fd", "--cells", "8", "--until", "120"]
    assert answer(*words, "--fields", str(out))["final"] == pytest.approx(answer(*words)["final"], rel=1e-12)
    assert [path.name for path in tmp_path.iterdir()] == [out.name]
    if suffix == ".nc":
        with xarray.open_dataset(out) as data:
            assert data["time"].values[[0, -1]] == pytest.approx([20.0, 120.0], abs=0.5)


def test_fields_that_a_scene_records_go_into_the_run_file(tmp_path, printed, refused):
    out = tmp_path / "run.nc"
    asked = ["run", "unlike", "--until", "20", "--set", 'run.record=["events", "fields"]', "--out", str(out)]
    printed(*asked, "--model", "sbp:6", "--cells", "16")
    with xarray.open_dataset(out, group="fields") as data:
        assert {"upper_velocity", "lower_stress"} <= set(data)
        assert float(data["time"].diff("time").max()) < 0.2  # steps, not pieces of eight
    before = out.read_bytes()
    assert "run.record" in refused(*asked, "--model", "delay")
    assert out.read_bytes() == before


@pytest.mark.parametrize(
    ("given", "read"),
    [
        ("run --set a=1 p", "run --set a=1 p"),
        ("run --set", "run --set"),
        ("run p --set a= -1 --json", "run p --set a=-1 --json"),
        ("run p --set a -1 b=-2.5e-3 --json", "run p --set a=-1 --set b=-2.5e-3 --json"),
    ],
)
def test_options_take_several_values_which_may_be_negative(given, read):
    assert words_of(given.split()) == read.split()


def words_of(given):
    """The words of a command line as the command gets them."""
    context = get_command(app).make_context("slipwave", given)
    return [*context._protected_args, *context.args]


@pytest.mark.parametrize(
    ("words", "typed", "said"),
    [
        (["--version"], "", f"slipwave {version('slipwave')}\n"),
        ([], "slipwave run paper-s", "paper-si\n"),
        ([], "slipwave sta", "stability\n"),
    ],
)
def test_the_version_and_what_the_shell_completes(words, typed, said):
    asked = (
        {"_SLIPWAVE_COMPLETE": "complete_bash", "COMP_WORDS": typed, "COMP_CWORD": str(len(typed.split()) - 1)} if typed else {}
    )
    program = [sys.executable, "-m", "slipwave", *words]
    done = subprocess.run(program, capture_output=True, text=True, env=os.environ | asked, check=True)
    assert (done.stdout.strip(), done.stderr) == (said.strip(), "")


def test_the_schema_has_the_laws_of_a_file(printed):
    """Before, it had no `--law`, and editors called every key of one's own law wrong."""
    schema = json.loads(printed("schema", "--law", str(Path(slipwave.__file__).parents[1] / "examples" / "own_law.py")))
    assert schema["$defs"]["cutoff"]["properties"].keys() > {"a_star", "cutoff"}
    assert schema["properties"]["interface"]["discriminator"]["mapping"]["cutoff"] == "#/$defs/cutoff"


def test_every_function_is_a_command_but_one_and_every_command_a_function_but_two():
    """So that no file lacks the line of help at its head."""
    functions = {name for name, place in slipwave._PLACES.items() if place.startswith("validation.")}
    assert (functions - COMMANDS.keys(), COMMANDS.keys() - functions) == ({"models"}, {"report", "schema"})


@pytest.mark.parametrize("name", ["branch", "curve"])
def test_a_tolerance_that_leaves_out_the_grid_says_so(printed, name):
    assert "of a full wave without the error of its grid" in " ".join(printed(name, "--help").split())


def test_every_command_has_examples_that_it_accepts(printed):
    assert "Usage" in printed()
    for name in COMMANDS:
        shown = printed(name, "--help").partition("Examples:\n")[2].split("\n")
        lines = [shlex.split(line.partition(" > ")[0]) for line in shown if line.strip()]
        assert {tuple(line[:2]) for line in lines} == {("slipwave", name)}
        for line in lines:
            get_command(app).get_command(None, name).make_context(name, words_of(line[1:])[1:])


def test_what_is_wrong_in_a_file_is_told_whole(tmp_path, refused):
    (tmp_path / "mine.toml").write_text("[slab]\nepsilon = 1e-5\ndensity 2700 kg/m3\n")
    told = "Expected '=' after a key in a key/value pair (at line 3, column 9)"
    assert refused("show", str(tmp_path / "mine.toml")).endswith(f"must be a TOML file; {told}")


PAPER = (Path(slipwave.__file__).parent / "gallery" / "paper.toml").read_bytes()


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

    def run():
        sys.stdout.reconfigure(encoding="ascii")
        sys.stderr.reconfigure(encoding="ascii")
        return main(["run", os.fsdecode(path), "--until", "20", "--out", str(tmp_path / "x.nc")])

    done = in_a_copy(run)
    assert done.returncode == 0, done.stderr
    assert "\x1b" not in done.stdout + done.stderr
    assert done.stdout.splitlines()[0].startswith("scene ")
    assert (tmp_path / "x.nc").exists()


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


SAMPLES = {int: ("5", 5), float: ("0.005", 0.005), str: ("1.5:2.5", "1.5:2.5"), Path: ("c.nc", Path("c.nc"))}


@pytest.fixture
def computed(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)

    def of(words):
        seen = []

        def keep(source, options):
            seen.append((source, options))
            raise SceneError("called")

        function = getattr(slipwave, words.split()[0])
        keep.__annotations__ = function.__wrapped__.__annotations__
        with monkeypatch.context() as patch:
            patch.setattr(function, "__wrapped__", keep)
            assert main(words.split()) == INPUT_WRONG
        return seen[0]

    return of


@pytest.mark.parametrize("name", ["run", "stability", "compare", "bench", "orbit", "branch", "curve"])
def test_every_declared_option_arrives_under_its_own_name(name, computed):
    wanted = {"settings": ["slab.r=0.002", "drive.velocity=50"]}
    words = [name, "paper", "--set", "slab.r=0.002", "drive.velocity=50"]
    for one in options_of(getattr(slipwave, name).__wrapped__.__annotations__["options"]).values():
        kinds = {one.hint, *get_args(one.hint)}
        if one.name in wanted or one.name in ("law", "family") or one.python_only:
            continue
        if bool in kinds or one.stands_for is not None:
            words, wanted = [*words, one.flag], wanted | {one.name: True if one.stands_for is None else one.stands_for}
        else:
            text, value = next(SAMPLES[kind] for kind in (Path, str, float, int) if kind in kinds)
            words, wanted = [*words, one.flag, text], wanted | {one.name: value}
    source, options = computed(" ".join(words))
    assert source == "paper"
    assert {key: getattr(options, key) for key in wanted} == wanted


@pytest.mark.parametrize("options", [{"cells": 6, "cfl": 0.25, "time": "explicit"}, {"tol": 1e-4}])
def test_numerical_options_reach_the_solver(options):
    (compared,) = slipwave.compare("paper", "dg:3", until=1, **options).runs
    named = {"tolerance" if name == "tol" else name: value for name, value in options.items()}
    wanted = build("dg:3", slipwave.read("paper", {"run.until": 1.0}), **named).settings
    assert slipwave.run("paper", "dg:3", until=1, **options).done.solver.settings == compared.solver.settings == wanted


REFUSED = Path(__file__).with_name("refused.txt").read_text(encoding="utf-8")


@pytest.mark.parametrize("line", [line for line in REFUSED.splitlines() if line])
def test_wrong_input_is_one_line_and_nothing_is_written(refused, tmp_path, monkeypatch, line):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "x.csv").write_text("time [s],mu\n0,0.6\n1,0.6\n2,0.6\n")
    words, told = line.split(" | ")
    status = NUMERICS_FAILED if told.startswith("3: ") else INPUT_WRONG
    found = refused(*shlex.split(words), status=status)
    assert told.removeprefix("3: ").lower() in found.lower()
    assert [path.name for path in tmp_path.iterdir()] == ["x.csv"]


OWN_WORDS = {"fit": "auto: quasidynamic, or fitted:0", "verify": "auto: dg:7", "map": "SCENE <str> the folder of a sweep"}


@pytest.mark.parametrize("command", OWN_WORDS)
def test_help_says_what_words_mean_in_a_command(command, capsys):
    """Before, of `auto`, "the cheapest that is exact", which neither takes, and of a sweep's folder, a scene of the gallery."""
    main([command, "--help"])
    assert OWN_WORDS[command] in " ".join(capsys.readouterr().out.split())
