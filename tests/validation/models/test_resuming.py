"""Runs that are killed, interrupted or meet a full disk: what is kept, what is said, and how they go on."""

import errno
import itertools
import json
import os
import re
import signal
import subprocess
import sys
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

import pytest
import xarray

import slipwave
from fullwave.lines import explicit
from slipwave.errors import NumericsError
from slipwave.observe import HistoryObserver
from slipwave.solve import follow
from tests.copies import interrupted, interrupted_within_a_callback, killed, on_small_disk
from validation.commands.cli import INPUT_WRONG, INTERRUPTED, NUMERICS_FAILED, main
from validation.models.build import build
from validation.models.progress import progress

BASE = ["run", "paper", "--model", "dg:7", "--json"]


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


@pytest.mark.parametrize("place", [(explicit, "_march_lines", 9), (explicit, "_march_lines", 14), (os, "replace", 5)])
def test_killed_run_goes_on_to_the_same_bits(tmp_path, uninterrupted, place):
    """Killed on its way into compiled code, or as a checkpoint was to take the place of the one before."""
    file = tmp_path / "run.npz"
    saving = [*TO_KILL, "--checkpoint", str(file), "--checkpoint-every", "50"]
    killed(saving, *place)
    assert file.exists()
    assert outcome(saving) == uninterrupted


@pytest.mark.parametrize(
    ("words", "hint"),
    [
        (["--model", "delay"], "model is 'dg:7'; this run needs 'delay'"),
        (["--checkpoint-every", "0"], "'0': must be a positive number of transits, or in scenes with SI units a time as in 10s"),
        (["--checkpoint-every", "1 s"], '--checkpoint-every = "1 s": must come with interface.normal_stress'),
        (["--window", "5:9"], "the window is 0:inf; this run asks for 5:9"),
        (["--fields", "fields.nc"], "observers is ['envelope', 'events']; this run needs ['envelope', 'events', 'fields']"),
    ],
)
def test_what_does_not_belong_is_refused(tmp_path, printed, refused, monkeypatch, words, hint):
    monkeypatch.chdir(tmp_path)
    printed(*BASE, "--until", "200", "--checkpoint", "run.npz", "--checkpoint-every", "90")
    options = {"--model": "dg:7", "--until": "200", "--checkpoint": "run.npz"} | dict([words])
    assert hint in refused("run", "paper", "--json", *itertools.chain(*options.items()))


@pytest.mark.parametrize("model", ["fd", "delay", "block8"])
def test_a_start_on_the_orbit_goes_on_without_looking_for_it_again(tmp_path, answer, monkeypatch, model):
    words = ["run", "paper", "--model", model, "--set", "start.kind=orbit", "--until", "300"]
    words += ["--cells", "24"] if model == "fd" else []
    saving = [*words, "--checkpoint", str(tmp_path / "run.npz"), "--checkpoint-every", "70"]
    direct = answer(*words)
    answer(*saving)
    monkeypatch.setattr("validation.models.orbit_start.settle", None)
    assert answer(*saving) | {"wall_s": 0} == direct | {"wall_s": 0}


def stopped(words, at, folder, until, by=signal.SIGINT):
    """What an interrupted command prints, when it was interrupted, and how it can go on, from the last line of stderr."""
    done = interrupted(words, at, folder, by)
    found = re.fullmatch(rf"slipwave: interrupted at t = (\S+) of {until} transits; (.*)", done.stderr.splitlines()[-1])
    assert (done.returncode, bool(found)) == (INTERRUPTED, True), done.stderr
    return done.stdout, float(found[1]), found[2]


@pytest.mark.parametrize("by", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_run_without_checkpoints_keeps_what_it_has(tmp_path, by):
    words = ["run", "paper", "--model", "delay", "--until", "40000", "--json", "--out", "x.nc"]
    out, time, how_to_resume = stopped(words, 2000.0, tmp_path, "40000", by)
    assert 2000.0 <= time < 4000.0
    assert how_to_resume.startswith("no checkpoint was kept") and "--checkpoint FILE.npz" in how_to_resume  # noqa: PT018
    result = json.loads(out)
    assert result["failed"] == f"interrupted at t = {time:.6g} of 40000 transits"
    assert result["period"]["mean"] == pytest.approx(73.472, rel=2e-3)
    with xarray.open_dataset(tmp_path / "x.nc") as data:
        assert (data.attrs["complete"], data.attrs["events"]) == (0, result["events"])
    assert (result["events"] > 20, [path.name for path in tmp_path.iterdir()]) == (True, ["x.nc"])


def test_a_run_stopped_as_its_grid_is_judged_keeps_its_figures(tmp_path, monkeypatch, capsys):
    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("validation.commands.run.judged_grid", interrupt)
    status = main([*BASE, "--until", "400", "--out", str(tmp_path / "x.nc")])
    printed = capsys.readouterr()
    line = "interrupted at t = 400 transits, before the error of the grid was known"
    result = json.loads(printed.out)
    assert (status, result["failed"], result["events"]) == (INTERRUPTED, line, 7)
    assert f"slipwave: {line}" in printed.err
    with xarray.open_dataset(tmp_path / "x.nc") as data:
        assert (data.attrs["complete"], data.sizes["event"]) == (1, 6)  # the run is whole


def test_a_run_with_checkpoints_names_the_last_one(tmp_path):
    words = ["run", "paper", "--model", "fd", "--cells", "16", "--until", "4000", "--checkpoint", "run.npz"]
    _, time, how_to_resume = stopped([*words, "--checkpoint-every", "50"], 220.0, tmp_path, "4000")
    found = re.fullmatch(r"'run.npz' holds the run up to t = (\S+): the same command goes on from there", how_to_resume)
    assert 200.0 <= float(found[1]) < 201.0 < 220.0 <= time <= 251.0


def test_a_bench_whose_reference_was_stopped_is_interrupted(tmp_path):
    """Before, it took the others' times all the same, and its exit status was 3."""
    done = interrupted(["bench", "paper", "--until", "4000", "--json"], 2500.0, tmp_path, signal.SIGINT)
    assert (done.returncode, done.stdout, done.stderr.splitlines()[-1]) == (INTERRUPTED, "", "slipwave: interrupted")


def test_a_comparison_shows_the_models_it_has(tmp_path):
    words = ["compare", "paper", "--models", "delay,block8", "--until", "400", "--json", "--out", "x.png"]
    out, _, how_to_resume = stopped(words, 100.0, tmp_path, "400")
    assert (how_to_resume, [row["model"] for row in json.loads(out)["models"]]) == ("model delay", ["delay"])
    assert (tmp_path / "x.png").exists()


FULL = Path("/dev/full")


@pytest.mark.parametrize(
    ("words", "file"),
    [
        ("run paper --model delay --until 400 --out x.nc", "x.nc"),
        ('run paper --model delay --until 400 --out x.nc --set run.record=["events","interface"]', "samples"),
        ("run paper --model fd --cells 16 --until 110 --fields x.nc", "x.nc"),
        ("compare paper --models delay --until 400 --out x.pdf", "x.pdf"),
    ],
)
def test_what_was_computed_is_printed_and_nothing_half_written(tmp_path, words, file):
    done = on_small_disk([*words.split(), "--json"], 4000, tmp_path)
    assert (done.returncode, json.loads(done.stdout)["until"] in (110.0, 400.0)) == (INPUT_WRONG, True), done.stderr
    assert re.match(rf"slipwave: .*{file}.*cannot be written: file too large", done.stderr.splitlines()[-1])
    assert ("Traceback" in done.stderr, list(tmp_path.iterdir())) == (False, [])


def test_a_disk_without_any_space_is_named(tmp_path):
    """The library of netCDF, which cannot begin its file there, says that permission is denied."""
    done = on_small_disk(["run", "paper", "--model", "delay", "--until", "40", "--out", "x.nc"], 0, tmp_path)
    assert (done.returncode, list(tmp_path.iterdir())) == (INPUT_WRONG, [])
    assert done.stderr.splitlines()[-1] == "slipwave: 'x.nc' cannot be written: file too large"


def test_a_checkpoint_that_cannot_be_written_does_not_end_the_run(tmp_path):
    words = ["run", "paper", "--model", "delay", "--until", "400", "--checkpoint", "c.npz", "--checkpoint-every", "100", "--json"]
    done = on_small_disk(words, 4000, tmp_path)
    told = "'c.npz' cannot be written: file too large; the computation goes on"
    assert (done.returncode, json.loads(done.stdout)["until"]) == (0, 400.0), done.stderr
    assert (done.stderr.count(told), list(tmp_path.iterdir())) == (1, [])


def test_a_history_of_which_nothing_could_be_written_names_its_file(tmp_path, monkeypatch, capsys):
    """Its name is that of the checkpoint with an ending, which is too long."""
    monkeypatch.chdir(tmp_path)
    words = ["run", "paper", "--model", "block8", "--until", "20", "--checkpoint", f"{'e' * 250}.npz", "--series", "x.csv"]
    assert main(words) == INPUT_WRONG
    line = capsys.readouterr().err.splitlines()[-1]
    assert line == f"slipwave: the interface's history in '{'e' * 250}.npz.samples' cannot be written: file name too long"


@pytest.mark.skipif(not FULL.exists(), reason="this system has no /dev/full")
@pytest.mark.parametrize("words", ["scenes", "--help", "stability paper", "run paper --until 50 --out x.nc"])
def test_a_stdout_that_takes_nothing_is_one_line(tmp_path, words):
    program = [sys.executable, "-m", "validation.commands.cli", *words.split()]
    with FULL.open("w") as full:
        done = subprocess.run(program, cwd=tmp_path, stdout=full, stderr=subprocess.PIPE, text=True)
    told = "slipwave: the result cannot be written to stdout: no space left on device"
    assert (done.returncode, done.stderr.splitlines()[-1], "Traceback" in done.stderr) == (INPUT_WRONG, told, False)
    assert [path.name for path in tmp_path.iterdir()] == (["x.nc"] if "x.nc" in words else [])


class Terminal(StringIO):
    """A terminal that may be closed, after which nothing can be written to it."""

    gone = False

    def isatty(self):
        return True

    def write(self, text):
        if self.gone:
            raise OSError(errno.EIO, "Input/output error")
        return super().write(text)


@pytest.mark.parametrize(("words", "status"), [("run unlike --until 5 --out x.nc", 0), ("run no-such-scene", INPUT_WRONG)])
def test_a_stderr_that_takes_nothing_changes_nothing(tmp_path, monkeypatch, words, status):
    """Notes, the model that `auto` chose and the last line are written there."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "stderr", terminal := Terminal())
    terminal.gone = True
    assert main(words.split()) == status
    assert [path.name for path in tmp_path.iterdir()] == (["x.nc"] if "x.nc" in words else [])


def test_work_goes_on_when_the_terminal_of_its_bar_is_closed(monkeypatch):
    monkeypatch.setattr("validation.models.progress.PATIENCE", 0.0)
    monkeypatch.setattr(sys, "stderr", terminal := Terminal())
    with progress("work", 1.0) as report:
        report(0.5)
        terminal.gone = True
        report(0.7)
    assert "work" in terminal.getvalue()


COARSE = ["--set", "slab.r=1", "--until", "40"]
"""64 cells of a leapfrog cannot follow psi through the first event of a transit of a hundred state relaxations."""


def test_observers_see_what_came_before_the_first_failed_solve():
    solver = build("fd", slipwave.read("paper", ["slab.r=1"]), cells=64)
    history = HistoryObserver(solver.scene.law, solver.nodes)
    with pytest.raises(NumericsError, match=r"fd: \d+ solves .* transits, the first at t = .*digest"):
        follow(solver, 40.0, [history])
    seen = history.columns()["time"][-1]
    assert solver.failed_at - 1.0 / 16.0 < seen < solver.failed_at < solver.time


def test_a_run_whose_first_solve_fails_is_one_line(capsys):
    assert main(["run", "paper", "--set", "slab.r=1000", "--until", "4", "--model", "fd", "--cells", "16"]) == NUMERICS_FAILED
    assert "did not converge by t = 4 transits, the first at t = 0: what follows" in capsys.readouterr().err


def test_run_prints_what_it_has_and_ends_with_status_3(tmp_path, capsys):
    assert main(["run", "paper", *COARSE, "--model", "fd", "--cells", "64", "--json"]) == NUMERICS_FAILED
    text, err = capsys.readouterr()
    result = json.loads(text)
    assert result["failures"] > 0
    assert result["final"] is None
    assert "fd: " in err
    assert err.strip().endswith(result["failed"])
    first = float(result["failed"].split("the first at t = ")[1].split(":")[0])
    assert 0.5 < first < 2.0  # rounding grows by 35 nepers a transit: the first event comes at ln(10^16)/35


def test_compare_prints_every_row_and_ends_with_status_3(tmp_path, capsys):
    out = tmp_path / "both.png"
    words = ["compare", "paper", *COARSE, "--models", "sbp:2,fd", "--cells", "64", "--out", str(out), "--json"]
    assert main(words) == NUMERICS_FAILED
    text, err = capsys.readouterr()
    rows = {row["model"]: row for row in json.loads(text)["models"]}
    assert rows["fd"]["failures"] > 0
    assert rows["fd"]["error"] == {"period": None, "stress_drop": None}
    assert "the first at t = " in rows["fd"]["failed"]
    assert rows["fd"]["failed"] in err


def test_an_interruption_that_a_library_loses_is_heard_all_the_same(tmp_path):
    done = interrupted_within_a_callback(["run", "paper", "--until", "400000"], 100.0, tmp_path)
    assert done.returncode == INTERRUPTED
    assert re.search("^slipwave: interrupted at t = ", done.stderr, re.M)
    assert "Traceback" not in done.stderr
