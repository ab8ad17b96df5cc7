"""What is imported is declared and locked, and a wheel would hold every program and every data file."""

import ast
import os
import re
import subprocess
import sys
import tomllib
from importlib.metadata import distribution, packages_distributions

import pytest
import yaml
from packaging.requirements import Requirement
from typer.main import get_command

from slipwave.extras import EXTRAS, OF_THE_REPORT
from slipwave.sources import ROOT
from tests.test_shape import FILES, ROOMS, TREES
from validation.commands.cli import COMMANDS, app

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
EXTRA = PROJECT["project"]["optional-dependencies"]
LOCKED_FOR = {"python_version": "3.11", "python_full_version": "3.11.0"}
"""The oldest Python: later ones need no more packages."""
ENGINES = {"netcdf4"}
"""Loaded by name by a package that is imported (xarray's engine)."""


def plain(name):
    return re.sub(r"[-_.]+", "-", name).lower()


def imported():
    """Distributions of all modules that the packages import, ours and Python's own left out."""
    found = set()
    for node in (node for tree in TREES.values() for node in ast.walk(tree)):
        if isinstance(node, ast.Import):
            found |= {alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            found.add(str(node.module).partition(".")[0])
    providers = packages_distributions()
    others = found - set(sys.stdlib_module_names) - {*ROOMS, "tests"}
    return {plain(providers[module][0]) for module in others}


def needed(names):
    waiting, found = [Requirement(name) for name in names], set()
    while waiting:
        asked = waiting.pop()
        if plain(asked.name) in found:
            continue
        found.add(plain(asked.name))
        for line in distribution(asked.name).requires or ():
            further = Requirement(line)
            if further.marker is None or any(
                further.marker.evaluate(LOCKED_FOR | {"extra": extra}) for extra in ("", *asked.extras)
            ):
                waiting.append(further)
    return found


def lines_of(extra):
    """Requirements of an extra; those of other extras of slipwave, which it includes, in their place."""
    lines = []
    for line in EXTRA[extra]:
        included = Requirement(line).extras if plain(Requirement(line).name) == "slipwave" else None
        lines += [line] if included is None else [one for name in sorted(included) for one in lines_of(name)]
    return lines


def names(lines):
    return {plain(Requirement(line).name) for line in lines}


def test_what_is_imported_is_declared_and_what_is_declared_is_imported():
    assert names([*PROJECT["project"]["dependencies"], *lines_of("report"), *lines_of("cluster")]) == imported() | ENGINES


def test_extras_install_the_modules_that_are_said_to_need_them():
    providers = packages_distributions()
    for extra, modules in EXTRAS.items():
        own = [line for line in EXTRA[extra] if not line.startswith("slipwave[")]
        assert names(own) == {plain(providers[module][0]) for module in modules}
    page = (ROOT / "docs" / "install.md").read_text(encoding="utf-8")
    for extra, modules in EXTRAS.items():
        assert f"| `{extra}` | {', '.join(f'`{name}`' for name in modules)} |" in page
    assert set(names(lines_of("report"))) == {plain(providers[name][0]) for extra in OF_THE_REPORT for name in EXTRAS[extra]}


def test_the_lock_file_holds_all_that_is_needed_and_nothing_else():
    lines = [line for line in (ROOT / "requirements.lock").read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    assert all(re.fullmatch(r"[\w.-]+==[\w.]+", line) for line in lines)
    project = PROJECT["project"]
    asked = project["dependencies"] + lines_of("test") + PROJECT["build-system"]["requires"]
    assert sorted(plain(line.partition("==")[0]) for line in lines) == sorted(needed(asked))


def test_every_program_and_every_data_file_is_declared():
    tools = PROJECT["tool"]["setuptools"]
    assert tools["packages"]["find"]["include"] == [f"{room}*" for room in ROOMS]
    assert [path.parent for path in FILES.values() if not (path.parent / "__init__.py").exists()] == []
    for room in ROOMS:
        declared = {path for pattern in tools["package-data"].get(room, ()) for path in (ROOT / room).glob(pattern)}
        files = {path for path in (ROOT / room).rglob("*") if path.is_file() and "__pycache__" not in path.parts}
        assert {path for path in files if path.suffix != ".py"} == declared


def test_a_clone_is_not_imported_as_an_empty_package(tmp_path):
    """The clone's folder may have the package's name. An editable install that puts the clone on the path is found before it."""
    assert PROJECT["tool"]["distutils"]["editable_wheel"]["mode"] == "compat"
    (tmp_path / "slipwave").symlink_to(ROOT)
    command = [sys.executable, "-c", "import slipwave; print(slipwave.__version__ and slipwave.read.__name__)"]
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert (done.stdout, done.stderr) == ("read\n", "")


ACTION = yaml.safe_load((ROOT / "action.yml").read_text(encoding="utf-8"))
STEPS = ACTION["runs"]["steps"]
SCRIPTS = {step["name"]: step["run"] for step in STEPS if "run" in step}


def test_the_action_names_commands_and_options_that_exist():
    said = re.findall(r'bin/slipwave" (\w+)(.*)', "\n".join(SCRIPTS.values()))
    assert [name for name, _ in said] == ["verify", "report"]
    for name, words in said:
        assert name in COMMANDS
        known = {flag for one in get_command(app).get_command(None, name).params for flag in one.opts}
        assert set(re.findall(r"--[\w-]+", words)) <= known
    assert all(step["shell"] == "bash" for step in STEPS if "run" in step)
    flows = [yaml.safe_load(path.read_text(encoding="utf-8")) for path in (ROOT / ".github/workflows").glob("*.yml")]
    steps = [*STEPS, *(step for flow in flows for job in flow["jobs"].values() for step in job["steps"])]
    assert not [step for step in steps if "${{" in step.get("run", "")], "an input must not become code"
    used = set(re.findall(r"inputs\.([\w-]+)", (ROOT / "action.yml").read_text(encoding="utf-8")))
    assert used == set(ACTION["inputs"]) >= {name for step in steps if step.get("uses") == "./" for name in step["with"]}


@pytest.fixture
def step(tmp_path):
    """Runs the step `verify` with the words of a user, and a script in place of slipwave."""
    if os.name != "posix":
        pytest.skip("the action's shell is bash")
    program = tmp_path / "slipwave" / "bin" / "slipwave"
    program.parent.mkdir(parents=True)
    program.with_name("python").symlink_to(sys.executable)

    def run(script, words):
        program.write_text(f"#!/bin/sh\n{script}\n")
        program.chmod(0o755)
        given = {"RUNNER_TEMP": str(tmp_path), "GITHUB_STEP_SUMMARY": str(tmp_path / "summary.md"), "WORDS": words}
        shell = ["bash", "-e", "-o", "pipefail", "-c", SCRIPTS["verify"]]
        return subprocess.run(shell, cwd=tmp_path, env=os.environ | given, capture_output=True, text=True)

    return run


def test_the_step_hands_the_words_over_and_ends_with_the_commands_status(step, tmp_path):
    program = f'exec {sys.executable} -m slipwave "$@"'
    done = step(program, "jump --model dg:3  # a comment\n  --set 'start.size = 0.01'\n")
    assert (done.returncode, (tmp_path / "verify.xml").is_file()) == (0, True), done.stderr
    assert done.stdout in (tmp_path / "summary.md").read_text()
    assert step(program, "nowhere.toml").returncode == 2


@pytest.mark.parametrize(
    ("words", "wanted"),
    [
        ("a 'b c'\n\n--set \"x = 1\"", ["verify", "a", "b c", "--set", "x = 1", "--junit", "verify.xml"]),
        ("* $HOME `id` a\\ b", ["verify", "*", "$HOME", "`id`", "a b", "--junit", "verify.xml"]),
    ],
)
def test_lines_and_quotes_of_the_words_are_those_of_a_shell_and_nothing_in_them_is_run(step, words, wanted):
    done = step('printf "%s\\n" "$@"', words)
    assert (done.returncode, done.stdout.splitlines()) == (0, wanted), done.stderr


def test_what_is_installed_is_locked_and_two_jobs_have_two_artifacts():
    assert '--requirement "$GITHUB_ACTION_PATH/requirements.lock"' in SCRIPTS["install"]
    upload = next(step for step in STEPS if step.get("uses", "").startswith("actions/upload-artifact"))
    assert "github.job" in upload["with"]["name"]
    assert "strategy.job-index" in upload["with"]["name"]
    assert all(line.startswith("${{ inputs.working-directory }}/") for line in upload["with"]["path"].splitlines())
    assert {step["name"] for step in STEPS if "working-directory" in step} == {"verify", "report"}
