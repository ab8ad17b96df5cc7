"""Every option of the command line reaches the function of the door under its own name, and from there the solver."""

import importlib
import inspect
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import typer

import slipwave as sw
from slipwave.errors import SceneError
from validation.cli import INPUT_WRONG, app, main
from validation.registry import build as models

SETTINGS = " --set slab.r=0.002 drive.velocity=50"
PASSED = {"source": "paper", "settings": ["slab.r=0.002", "drive.velocity=50"]}
GRID = {"model": "dg:3", "cells": 6, "tol": 1e-4}
STEPS = {"until": "7", "cells": 6, "cfl": 0.25, "tol": 1e-4, "most_seconds": math.inf}

CALLS: dict[str, tuple[str, dict[str, Any]]] = {
    "run --model dg:3 --until 7 --cycles 5 --cells 6 --cfl 0.25 --time explicit --tol 1e-4 --checkpoint c.npz "
    "--checkpoint-every 30 --every 3 --window 1.5:2.5 --lyapunov --yes": STEPS
    | {"model": "dg:3", "cycles": 5, "time": "explicit", "interface": False, "every": 3, "window": "1.5:2.5", "fields": False}
    | {"samples": None, "checkpoint": Path("c.npz"), "checkpoint_every": "30", "lyapunov": True},
    "compare --models fd,delay --until 7 --cells 6 --cfl 0.25 --time exact --tol 1e-4 --yes": STEPS
    | {"models": "fd,delay", "time": "exact"},
    "bench --until 7 --yes": {"until": "7", "most_seconds": math.inf},
    "stability --model block8": {"model": "block8"},
    "orbit --model dg:3 --tol 1e-4 --cells 6 --near-period 80 --others": GRID | {"near_period": "80", "others": True},
    "branch --over V=1:2 --model dg:3 --tol 1e-4 --cells 6 --out o.nc --resume r.nc --stop-at LP --switch PD "
    "--longest-period 90 --most-points 8": GRID
    | {"over": "V=1:2", "out": Path("o.nc"), "resume": Path("r.nc"), "stop_at": "LP", "switch": "PD"}
    | {"longest_period": 90.0, "most_points": 8},
    "curve --of LP --over V=1:2 --and r=3:4 --model block8 --tol 1e-4 --most-points 8 --out o.nc --resume r.nc": {"of": "LP"}
    | {"over": "V=1:2", "along": "r=3:4", "model": "block8", "tol": 1e-4, "most_points": 8}
    | {"out": Path("o.nc"), "resume": Path("r.nc")},
}
"""A command with all of its options, and all that the function of its name is called with."""


@pytest.fixture
def calls(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Callable[[str], dict[str, Any]]:
    """What the function of a command is called with, by name."""
    monkeypatch.chdir(tmp_path)

    def of(words: str) -> dict[str, Any]:
        command, *options = (words + SETTINGS).split()
        signature, called = inspect.signature(getattr(sw, command)), dict[str, Any]()

        def keep(*arguments: Any, **options: Any) -> None:
            called.update(signature.bind(*arguments, **options).arguments)
            raise SceneError("called")

        monkeypatch.setattr(sw, command, keep, raising=False)
        assert main([command, "paper", *options]) == INPUT_WRONG
        return called | {"settings": list(called["settings"])}

    return of


@pytest.mark.parametrize("words", CALLS, ids=lambda words: words.split()[0])
def test_the_command_line_passes_every_option_on(words: str, calls: Callable[[str], dict[str, Any]]) -> None:
    known = inspect.signature(getattr(sw, words.split()[0])).parameters.keys()
    given = calls(words)
    assert given == PASSED | CALLS[words]
    assert given.keys() == known - {"changes"}


def test_every_argument_and_option_says_what_it_is_for() -> None:
    commands: dict[str, Any] = typer.main.get_command(app).commands  # type: ignore[attr-defined]
    silent = [f"{name} {one.name}" for name, command in commands.items() for one in command.params if not one.help]
    assert not silent
    assert all(command.help and "slipwave " in command.epilog for command in commands.values())


@pytest.mark.parametrize(
    ("words", "interface", "fields"),
    [
        ("", False, False),
        ("--events a.csv", False, False),
        ("--out a.nc", None, None),
        ("--plot a.png", False, False),
        ("--fields a.vtu", False, True),
        ("--out a.nc --plot a.png --fields a.vtu", None, True),
    ],
)
def test_a_run_keeps_what_its_files_need(
    words: str, interface: bool | None, fields: bool | None, calls: Callable[[str], dict[str, Any]]
) -> None:
    """In a file of results, what the scene records."""
    given = calls(f"run {words}")
    assert (given["interface"], given["fields"], given["samples"] is not None) == (interface, fields, "--out" in words)


@pytest.mark.parametrize(("command", "builder"), [("run", "prepare"), ("compare", "build_all")])
def test_numerical_options_reach_the_solver(command: str, builder: str, monkeypatch: pytest.MonkeyPatch) -> None:
    called: dict[str, Any] = {}

    def keep(*arguments: Any, **options: Any) -> None:
        called.update(options)
        raise SceneError("called")

    for place in (models, importlib.import_module(f"validation.door.{command}")):
        monkeypatch.setattr(place, builder, keep, raising=False)
    with pytest.raises(SceneError, match="called"):
        getattr(sw, command)("paper", "dg:3", cells=6, cfl=0.25, tol=1e-4, time="explicit")
    assert called == {"cells": 6, "cfl": 0.25, "tolerance": 1e-4, "time": "explicit"}
