"""Every option of the command line reaches the function of the door under its own name, and from there the solver."""

import importlib
from pathlib import Path
from typing import get_args

import pytest

import slipwave as sw
from slipwave.errors import SceneError
from validation.cli import COMMANDS, INPUT_WRONG, command_called, main
from validation.registry import build as models
from validation.results.options import options_of

SETTINGS = " --set slab.r=0.002 drive.velocity=50"


def test_every_argument_and_option_says_what_it_is_for():
    commands = {name: command_called(name) for name in COMMANDS}
    silent = [f"{name} {one.name}" for name, command in commands.items() for one in command.params if not one.help]
    assert not silent
    assert all(command.help and "slipwave " in command.epilog for command in commands.values())


SAMPLES = {int: ("5", 5), float: ("0.005", 0.005), str: ("1.5:2.5", "1.5:2.5"), Path: ("c.nc", Path("c.nc"))}


@pytest.fixture
def computed(monkeypatch, tmp_path):
    """The options with which a command computes."""
    monkeypatch.chdir(tmp_path)

    def of(words):
        seen = []

        def keep(source, options):
            seen.append((source, options))
            raise SceneError("called")

        function = getattr(sw, words.split()[0])
        keep.__annotations__ = function.__wrapped__.__annotations__
        with monkeypatch.context() as patch:
            patch.setattr(function, "__wrapped__", keep)
            assert main(words.split()) == INPUT_WRONG
        return seen[0]

    return of


@pytest.mark.parametrize("name", ["run", "stability", "compare", "bench", "orbit", "branch", "curve"])
def test_every_declared_option_arrives_under_its_own_name(name, computed):
    wanted = {"settings": ["slab.r=0.002", "drive.velocity=50"]}
    words = [name, "paper", *SETTINGS.split()]
    for one in options_of(getattr(sw, name).__wrapped__.__annotations__["options"]).values():
        kinds = {one.hint, *get_args(one.hint)}
        if one.name in wanted or one.name in ("law", "family") or not one.is_in("command line"):
            continue
        if bool in kinds or "stands_for" in one.more:
            words, wanted = [*words, one.flag], wanted | {one.name: one.more.get("stands_for", True)}
        else:
            text, value = next(SAMPLES[kind] for kind in (Path, str, float, int) if kind in kinds)
            words, wanted = [*words, one.flag, text], wanted | {one.name: value}
    source, options = computed(" ".join(words))
    assert source == "paper"
    assert {key: getattr(options, key) for key in wanted} == wanted


@pytest.mark.parametrize(
    ("words", "interface", "fields"),
    [
        ("--events a.csv", False, False),
        ("--out a.nc", None, None),
        ("--out a.nc --plot a.png --fields a.vtu", None, True),
        ("--series a.csv", True, False),
        ("--out a.nc --series a.csv", True, None),
    ],
)
def test_a_run_keeps_what_its_files_need(words, interface, fields, computed):
    """In a file of results, what the scene records."""
    given = computed(f"run paper {words}")[1]
    assert (given.interface, given.fields, given.samples is not None) == (interface, fields, "--out" in words)


@pytest.mark.parametrize(("command", "builder"), [("run", "prepare"), ("compare", "build_all")])
def test_numerical_options_reach_the_solver(command, builder, monkeypatch):
    called = {}

    def keep(*arguments, **options):
        called.update(options)
        raise SceneError("called")

    for place in (models, importlib.import_module(f"validation.results.{command}")):
        monkeypatch.setattr(place, builder, keep, raising=False)
    with pytest.raises(SceneError, match="called"):
        getattr(sw, command)("paper", "dg:3", cells=6, cfl=0.25, tol=1e-4, time="explicit")
    assert called == {"cells": 6, "cfl": 0.25, "tolerance": 1e-4, "time": "explicit"}
