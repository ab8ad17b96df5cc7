"""The shell's conveniences: version, module, completion, examples, suggestions, negative values."""

import os
import shlex
import subprocess
import sys
from importlib.metadata import version

import pytest

from validation import cli
from validation.cli import main, spread


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


@pytest.mark.parametrize(
    ("words", "meant"),
    [
        (["run", "paper", "--set", "interface.law=aging"], "ageing"),
        (["run", "paper", "--model", "kelvinvoigt"], "kelvin-voigt"),
        (["run", "paper", "--set", "start.kind=jumb"], "jump"),
        (["run", "grip", "--set", "slab.face.kind=gripp"], "grip"),
        (["run", "papper"], "paper"),
        (["stabilty", "paper"], "stability"),
    ],
)
def test_a_mistyped_word_is_answered_by_the_one_that_is_meant(words, meant, refused):
    assert refused(*words).lower().endswith((f'did you mean "{meant}"?', f"did you mean '{meant}'?"))


@pytest.mark.parametrize("words", ["--model delay --model block8", "--until 5 --json --until=6"])
def test_an_option_is_given_once(words, refused):
    told = refused("run", "paper", "--set", "V=3", "--set", "size=0.1", *words.split())
    assert told == f"slipwave: {words.split()[0]}: is given more than once"


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
