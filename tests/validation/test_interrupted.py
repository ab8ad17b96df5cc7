"""Ctrl-C: one line that says when and how to go on, exit status 130, and all that was computed is printed and kept."""

import json
import re

import pytest
import xarray
from hooked_process import interrupted

from validation.cli import INTERRUPTED


def told(err, until):
    """When the run was interrupted, and how it can go on, from the last line of stderr."""
    found = re.fullmatch(rf"slipwave: interrupted at t = (\S+) of {until} transits; (.*)", err.splitlines()[-1])
    assert found is not None, err
    return float(found[1]), found[2]


def test_a_run_without_checkpoints_keeps_what_it_has(tmp_path):
    words = ["run", "paper", "--model", "delay", "--until", "40000", "--json", "--out", "x.nc"]
    done = interrupted(words, 2000.0, tmp_path)
    assert done.returncode == INTERRUPTED
    time, way_on = told(done.stderr, "40000")
    assert 2000.0 <= time < 4000.0
    assert "no checkpoint was kept" in way_on
    assert "--checkpoint FILE.npz" in way_on
    result = json.loads(done.stdout)
    assert result["failed"] == f"interrupted at t = {time:.6g} of 40000 transits"
    assert result["period"]["mean"] == pytest.approx(73.472, rel=2e-3)
    with xarray.open_dataset(tmp_path / "x.nc") as data:
        assert data.attrs["complete"] == 0
        assert data.attrs["events"] == result["events"] > 20
    assert [path.name for path in tmp_path.iterdir()] == ["x.nc"]


def test_a_run_with_checkpoints_names_the_last_one(tmp_path):
    words = ["run", "paper", "--model", "fd", "--cells", "16", "--until", "4000", "--checkpoint", "run.npz"]
    done = interrupted([*words, "--checkpoint-every", "50"], 220.0, tmp_path)
    assert done.returncode == INTERRUPTED
    time, way_on = told(done.stderr, "4000")
    found = re.fullmatch(r"'run.npz' holds the run up to t = (\S+): the same command goes on from there", way_on)
    assert found is not None
    assert 200.0 <= float(found[1]) < 201.0
    assert 220.0 <= time <= 251.0


def test_a_comparison_shows_the_models_it_has(tmp_path):
    words = ["compare", "paper", "--models", "delay,block8", "--until", "400", "--json", "--out", "x.png"]
    done = interrupted(words, 100.0, tmp_path)
    assert done.returncode == INTERRUPTED
    assert told(done.stderr, "400")[1] == "model delay"
    assert [row["model"] for row in json.loads(done.stdout)["models"]] == ["delay"]
    assert (tmp_path / "x.png").exists()
