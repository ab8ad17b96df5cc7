"""`slipwave run --checkpoint`: a killed run goes on to the same bits; what does not belong is refused in one line."""

import json
import signal
import subprocess
import sys

import pytest

from validation.cli import main

BASE = ["run", "paper", "--model", "dg:7", "--json"]
SLIPWAVE = [sys.executable, "-m", "validation.cli"]


KILLED = """
import os, signal, sys
import fullwave.lines.march
from validation.cli import main

left = int(sys.argv[2])


def mortal(function):
    def call(*arguments):
        global left
        left -= 1
        if left == 0:
            os.kill(os.getpid(), signal.SIGKILL)
        return function(*arguments)

    return call


room = {"march": fullwave.lines.march, "replace": os}[sys.argv[1]]
setattr(room, sys.argv[1], mortal(getattr(room, sys.argv[1])))
sys.exit(main(sys.argv[3:]))
"""


def outcome(words):
    done = subprocess.run([*SLIPWAVE, *words], capture_output=True, text=True, check=True)
    result = json.loads(done.stdout)
    del result["wall_s"]
    return result


@pytest.mark.parametrize(("at", "count"), [("march", 9), ("march", 40), ("replace", 5)])
def test_killed_run_goes_on_to_the_same_bits(tmp_path, at, count):
    """Killed on its way into compiled code, or as a checkpoint was to take the place of the one before."""
    file = tmp_path / "run.npz"
    words = [*BASE, "--cells", "8", "--until", "1500"]
    saving = [*words, "--checkpoint", str(file), "--checkpoint-every", "50"]
    done = subprocess.run([sys.executable, "-c", KILLED, at, str(count), *saving], capture_output=True, check=False)
    assert done.returncode == -signal.SIGKILL
    assert file.exists()
    assert outcome(saving) == outcome(words)


def test_prolonged_run_equals_one_that_never_stopped(tmp_path, capsys):
    file = str(tmp_path / "run.npz")
    whole = [*BASE, "--model", "fd", "--until", "500"]
    assert main([*whole[:-1], "300", "--checkpoint", file, "--checkpoint-every", "90"]) == 0
    capsys.readouterr()
    assert main([*whole, "--checkpoint", file]) == 0
    resumed = json.loads(capsys.readouterr().out)
    assert main(whole) == 0
    direct = json.loads(capsys.readouterr().out)
    assert {**resumed, "wall_s": 0} == {**direct, "wall_s": 0}


@pytest.mark.parametrize(
    ("words", "hint"),
    [
        (["--model", "delay"], "cheap to run again"),
        (["--set", "start.kind=orbit"], "start on the orbit"),
        (["--model", "dg:5"], "this run needs 'dg:5'"),
        (["--cells", "8"], "settings"),
        (["--set", "slab.log10_r=-2.6"], "scene"),
        (["--until", "50"], "already at"),
        (["--checkpoint-every", "0"], "positive"),
        (["--fields", "fields.nc"], "--fields"),
    ],
)
def test_what_does_not_belong_is_refused(tmp_path, capsys, monkeypatch, words, hint):
    monkeypatch.chdir(tmp_path)
    assert main([*BASE, "--until", "200", "--checkpoint", "run.npz", "--checkpoint-every", "90"]) == 0
    capsys.readouterr()
    assert main([*BASE, "--until", "200", "--checkpoint", "run.npz", *words]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.count("\n") == 1
    assert hint in said.err


def test_interval_needs_a_file(capsys):
    assert main([*BASE, "--checkpoint-every", "90"]) == 2
    assert "--checkpoint FILE" in capsys.readouterr().err


def test_a_grid_alike_in_size_and_step_is_refused(tmp_path, capsys):
    words = ["run", "paper", "--model", "dg:7", "--set", "drive.velocity=1e6", "--checkpoint", str(tmp_path / "run.npz")]
    assert main([*words, "--cells", "9", "--until", "60", "--checkpoint-every", "20"]) == 0
    capsys.readouterr()
    assert main([*words, "--cells", "12", "--until", "90", "--json"]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.count("\n") == 1
    assert "cells is [9], not [12]" in said.err


def test_a_text_file_is_no_checkpoint(tmp_path, capsys):
    (tmp_path / "run.npz").write_text("a diary\n")
    assert main([*BASE, "--until", "50", "--checkpoint", str(tmp_path / "run.npz")]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "run.npz' cannot be read: it is not a checkpoint, or damaged" in said
