"""Names and paths with control characters, without a text form, or outside the encoding of stdout; paths to no plain file."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import slipwave
from slipwave.errors import SceneError
from slipwave.input.source import load_tables
from validation.cli import INPUT_WRONG
from validation.run.progress import progress

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
