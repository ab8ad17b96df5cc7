"""A disk that is full costs the file, never the result: that is printed first, the rest is one line and exit status 2."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from hooked_process import on_small_disk

from validation.cli import INPUT_WRONG

FULL = Path("/dev/full")
INTERFACE = ["--set", 'run.record=["events","interface"]']


@pytest.mark.parametrize(
    ("words", "file"),
    [
        (["run", "paper", "--model", "delay", "--until", "400", "--out", "x.nc"], "x.nc"),
        (["run", "paper", "--model", "delay", "--until", "400", "--out", "x.nc", *INTERFACE], "samples"),
        (["run", "paper", "--model", "fd", "--cells", "16", "--until", "110", "--fields", "x.nc"], "x.nc"),
        (["run", "paper", "--model", "fd", "--cells", "16", "--until", "110", "--fields", "x.vtu"], "x.vtu"),
        (["compare", "paper", "--models", "delay", "--until", "400", "--out", "x.pdf"], "x.pdf"),
        (["compare", "paper", "--models", "delay", "--until", "400", "--out", "x.png"], "x.png"),
    ],
    ids=lambda value: value if isinstance(value, str) else value[0],
)
def test_what_was_computed_is_printed_and_nothing_half_written(tmp_path, words, file):
    done = on_small_disk([*words, "--json"], 4000, tmp_path)
    assert done.returncode == INPUT_WRONG, done.stderr
    assert json.loads(done.stdout)["until"] in (110.0, 400.0)
    line = done.stderr.splitlines()[-1]
    assert line.startswith("slipwave: ")
    assert file in line
    assert "cannot be written: file too large" in line
    assert "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(not FULL.exists(), reason="this system has no /dev/full")
@pytest.mark.parametrize(
    "words", [["scenes"], ["--help"], ["stability", "paper"], ["run", "paper", "--until", "50", "--out", "x.nc"]]
)
def test_a_stdout_that_takes_nothing_is_one_line(tmp_path, words):
    with FULL.open("w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "validation.cli", *words], cwd=tmp_path, stdout=full, stderr=subprocess.PIPE, text=True
        )
    assert done.returncode == INPUT_WRONG
    assert done.stderr.splitlines()[-1] == "slipwave: the result cannot be written to stdout: no space left on device"
    assert "Traceback" not in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == (["x.nc"] if "x.nc" in words else [])
