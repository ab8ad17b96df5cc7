"""`slipwave run --checkpoint`: a killed run goes on with bit-identical results; a wrong file is refused in one line."""

import itertools
import json
import signal
import subprocess
import sys
from contextlib import redirect_stdout
from io import StringIO

import pytest
import xarray

import slipwave
from slipwave.solve.checkpoint import saved_time
from validation.cli import main

BASE = ["run", "paper", "--model", "dg:7", "--json"]


KILLED = """
import os, signal, sys
import fullwave.lines.explicit
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


module, name = {"march": (fullwave.lines.explicit, "march_lines"), "replace": (os, "replace")}[sys.argv[1]]
setattr(module, name, mortal(getattr(module, name)))
sys.exit(main(sys.argv[3:]))
"""


def outcome(words):
    with redirect_stdout(StringIO()) as out:
        assert main(words) == 0
    result = json.loads(out.getvalue())
    del result["wall_s"]
    return result


TO_KILL = [*BASE, "--time", "explicit", "--cells", "8", "--until", "500"]


@pytest.fixture(scope="module")
def uninterrupted():
    return outcome(TO_KILL)


@pytest.mark.parametrize(("at", "count"), [("march", 9), ("march", 14), ("replace", 5)])
def test_killed_run_goes_on_to_the_same_bits(tmp_path, uninterrupted, at, count):
    """Killed on its way into compiled code, or as a checkpoint was to take the place of the one before."""
    file = tmp_path / "run.npz"
    saving = [*TO_KILL, "--checkpoint", str(file), "--checkpoint-every", "50"]
    done = subprocess.run([sys.executable, "-c", KILLED, at, str(count), *saving], capture_output=True, check=False)
    assert done.returncode == -signal.SIGKILL
    assert file.exists()
    assert outcome(saving) == uninterrupted


def test_prolonged_run_equals_one_that_never_stopped(tmp_path, answer):
    file = str(tmp_path / "run.npz")
    whole = ["run", "paper", "--model", "fd", "--until", "500"]
    answer(*whole[:-1], "300", "--checkpoint", file, "--checkpoint-every", "90")
    resumed, direct = answer(*whole, "--checkpoint", file), answer(*whole)
    assert {**resumed, "wall_s": 0} == {**direct, "wall_s": 0}


@pytest.mark.parametrize(
    ("words", "hint"),
    [
        (["--model", "delay"], "model is 'dg:7'; this run needs 'delay'"),
        (["--set", "start.kind=orbit"], "scene"),
        (["--model", "dg:5"], "this run needs 'dg:5'"),
        (["--cells", "8"], "settings"),
        (["--set", "slab.log10_r=-2.6"], "scene"),
        (["--until", "50"], "already at"),
        (["--checkpoint-every", "0"], "'0': must be a positive number of transits, or in scenes with SI units a time as in 10s"),
        (["--checkpoint-every", "often"], "positive"),
        (["--checkpoint-every", "1 s"], '--checkpoint-every = "1 s": must come with interface.normal_stress'),
        (["--fields", "fields.nc"], "observers is ['envelope', 'events']; this run needs ['envelope', 'events', 'fields']"),
    ],
)
def test_what_does_not_belong_is_refused(tmp_path, printed, refused, monkeypatch, words, hint):
    monkeypatch.chdir(tmp_path)
    printed(*BASE, "--until", "200", "--checkpoint", "run.npz", "--checkpoint-every", "90")
    options = {"--model": "dg:7", "--until": "200", "--checkpoint": "run.npz"} | dict([words])
    assert hint in refused("run", "paper", "--json", *itertools.chain(*options.items()))


def test_the_interval_may_have_a_unit(tmp_path):
    scene = slipwave.read("paper-si")
    five = 5.0 * scene.transit * scene.units.time
    for every in (f"{1e3 * five!r} ms", "5", 5):
        slipwave.run("paper-si", "block8", until=19, checkpoint=tmp_path / "run.npz", checkpoint_every=every)
        assert 15.0 <= saved_time(tmp_path / "run.npz") < 17.0
        (tmp_path / "run.npz").unlink()


def test_the_fields_of_a_resumed_run_are_those_of_one_that_never_stopped(tmp_path):
    """Killed within the window of the fields, as a checkpoint was to take the place of the one before."""
    words = ["run", "unlike", "--model", "dg:5", "--cells", "4", "--until", "150", "--json", "--set", 'run.record=["interface"]']
    whole = [*words, "--fields", str(tmp_path / "whole.nc"), "--out", str(tmp_path / "run.nc")]
    assert main(whole) == 0
    words = [*words, "--fields", str(tmp_path / "parts.nc"), "--out", str(tmp_path / "again.nc")]
    saving = [*words, "--checkpoint", str(tmp_path / "run.npz"), "--checkpoint-every", "21.3"]
    done = subprocess.run([sys.executable, "-c", KILLED, "replace", "5", *saving], capture_output=True, check=False)
    assert done.returncode == -signal.SIGKILL
    assert 80.0 < saved_time(tmp_path / "run.npz") < 90.0
    assert main(saving) == 0
    for whole_file, parts_file in (("whole.nc", "parts.nc"), ("run.nc", "again.nc")):
        with xarray.open_dataset(tmp_path / whole_file) as one, xarray.open_dataset(tmp_path / parts_file) as other:
            assert one.sizes == other.sizes
            assert one.equals(other)


@pytest.mark.parametrize("model", ["fd", "delay", "block8"])
def test_a_start_on_the_orbit_goes_on_without_looking_for_it_again(tmp_path, answer, monkeypatch, model):
    words = ["run", "paper", "--model", model, "--set", "start.kind=orbit", "--until", "300"]
    words += ["--cells", "24"] if model == "fd" else []
    saving = [*words, "--checkpoint", str(tmp_path / "run.npz"), "--checkpoint-every", "70"]
    direct = answer(*words)
    answer(*saving)
    monkeypatch.setattr("validation.registry.orbit_start.settle", None)
    assert answer(*saving) | {"wall_s": 0} == direct | {"wall_s": 0}
