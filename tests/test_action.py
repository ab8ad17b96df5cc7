"""action.yml and the workflow that uses it: they parse, name commands and options that exist, and hand a user's words over."""

import os
import re
import subprocess
import sys

import pytest
import yaml

from slipwave.sources import ROOT
from validation.commands.cli import COMMANDS, command_called

ACTION = yaml.safe_load((ROOT / "action.yml").read_text(encoding="utf-8"))
WORKFLOWS = {path.name: yaml.safe_load(path.read_text(encoding="utf-8")) for path in (ROOT / ".github/workflows").glob("*.yml")}
STEPS = ACTION["runs"]["steps"]
SCRIPTS = {step["name"]: step["run"] for step in STEPS if "run" in step}


def test_the_action_names_commands_and_options_that_exist():
    said = re.findall(r'bin/slipwave" (\w+)(.*)', "\n".join(SCRIPTS.values()))
    assert [name for name, _ in said] == ["verify", "report"]
    for name, words in said:
        assert name in COMMANDS
        known = {flag for one in command_called(name).params for flag in one.opts}
        assert set(re.findall(r"--[\w-]+", words)) <= known
    assert all(step["shell"] == "bash" for step in STEPS if "run" in step)
    flows = [step for flow in WORKFLOWS.values() for job in flow["jobs"].values() for step in job["steps"]]
    assert not [step for step in (*STEPS, *flows) if "${{" in step.get("run", "")], "an input must not become code"


def test_every_input_is_used_and_every_one_that_is_used_is_declared():
    used = set(re.findall(r"inputs\.([\w-]+)", (ROOT / "action.yml").read_text(encoding="utf-8")))
    assert used == set(ACTION["inputs"])
    assert all("default" in one and one["description"] for one in ACTION["inputs"].values())


def users():
    """Every step that uses the action: of our workflows, and of the page that shows one."""
    page = (ROOT / "docs" / "verify.md").read_text(encoding="utf-8")
    shown = yaml.safe_load(re.search(r"```yaml\n(.*?)```", page, re.S)[1])
    jobs = [job for flow in (*WORKFLOWS.values(), shown) for job in flow["jobs"].values()]
    return [step for job in jobs for step in job["steps"] if step.get("uses", "").startswith(("./", "OWNER/slipwave"))]


def test_workflows_give_inputs_that_the_action_has():
    assert len(users()) == 2
    for step in users():
        assert set(step["with"]) <= set(ACTION["inputs"])
        for file in re.findall(r"examples/\S+", step["with"]["verify"]):
            assert (ROOT / file).is_file()


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
