"""The short examples of docs/extending.md do what the page says."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import slipwave
from reduced.delay.alike import Delay
from reduced.impedance import reduce_scene
from reduced.ode.reduction import REDUCTIONS, Reduction
from slipwave.errors import SceneError
from slipwave.observe import follow

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "extending.md").read_text(encoding="utf-8")


def example(first_words):
    return next(block for block in re.findall(r"```(?:python)?\n(.*?)```", PAGE, re.S) if block.startswith(first_words))


def add_to(file, table, line):
    """Put `line` first into the table `table` of a source file, as a reader of the page would."""
    text, count = re.subn(rf"^({table}\b.*[{{(]\n)", rf"\g<1>    {line.strip()}\n", file.read_text(), flags=re.M)
    assert count == 1
    file.write_text(text)


def command(folder, *words):
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(folder / "cache"), "PYTHONPATH": str(folder)}
    return subprocess.run(
        [sys.executable, "-m", "validation.cli", *words], cwd=folder, env=environment, capture_output=True, text=True, timeout=600
    )


def test_a_reduction_is_added_as_the_page_says(tmp_path):
    for room in ("slipwave", "reduced", "fullwave", "validation"):
        shutil.copytree(ROOT / room, tmp_path / room, ignore=shutil.ignore_patterns("__pycache__"))
    add_to(tmp_path / "reduced" / "ode" / "reduction.py", "REDUCTIONS", example('"block10"'))
    add_to(tmp_path / "validation" / "registry" / "families.py", "FAMILIES", example('Family("block10"'))

    compared = command(tmp_path, "compare", "paper", "--models", "block8,block10,block12", "--until", "4000", "--json")
    assert compared.returncode == 0, compared.stderr
    light, middle, heavy = (row["period"]["mean"] for row in json.loads(compared.stdout)["models"])
    assert light < middle < heavy
    analysed = command(tmp_path, "stability", "paper", "--model", "block10", "--json")
    assert json.loads(analysed.stdout)["model"] == "block10"
    refused = command(tmp_path, "run", "grip", "--model", "block10")
    assert refused.returncode == 2
    assert "a grip at the outer face" in refused.stderr


def test_tabulated_data_are_not_taken_for_scenes_they_were_not_made_for(monkeypatch):
    monkeypatch.setitem(REDUCTIONS, "block10", lambda: Reduction("block10", mass=0.1))
    assert reduce_scene(slipwave.read("paper"), "block10").mass == 0.1
    with pytest.raises(SceneError, match="alike homogeneous elastic slabs"):
        reduce_scene(slipwave.read("unlike"), "block10")


def test_an_observer_is_anything_that_scans():
    scope = {"np": np}
    exec(example("class SlipObserver"), scope)
    observer = scope["SlipObserver"]()
    solver = Delay(slipwave.read("paper"))
    follow(solver, 2000, [observer])
    assert observer.slip == pytest.approx(2000 * 100 * 0.8, rel=0.25)


def test_a_law_whose_rate_is_no_exponential_is_refused():
    from slipwave.friction import LAWS
    from slipwave.friction.check import check_law

    square = LAWS["ageing"]._replace(rate_of=lambda law, z: z * z, unknown_of=lambda law, v: v**0.5)
    with pytest.raises(SceneError, match="v''"):
        check_law("square", square)
