"""`make bench` on works of known cost: medians of ratios, a record that the next one is compared with."""

import json
from dataclasses import replace
from functools import partial

import pytest

import slipwave
from slipwave.scene.slab import GripFace, ReflectingFace
from slipwave.solve import follow
from validation import benchmark
from validation.benchmark import Race, last, main, measure, races
from validation.registry.families import explicit_time
from validation.run import timing
from validation.run.timing import in_turn, timed
from validation.studies.unlike_slabs.cost import pairs
from validation.work_precision import Setting, march_of


@pytest.fixture
def clock(monkeypatch):
    """Processor time that passes only where a work says so."""
    spent = [0.0]
    monkeypatch.setattr(timing, "_spent", lambda: spent[0])

    def work(*seconds):
        left = iter(seconds)

        def pass_time(length):
            spent[0] += length

        def prepare():
            spent[0] += 1000.0  # what is prepared does not count
            return partial(pass_time, next(left))

        return prepare

    return work


def test_time_is_that_of_the_process_and_of_its_children(monkeypatch):
    class Usage:
        ru_utime, ru_stime = 2.0, 0.5

    monkeypatch.setattr(timing.time, "process_time", lambda: 1.25)
    monkeypatch.setattr(timing.resource, "getrusage", lambda who: Usage)
    assert timing._spent() == 3.75


def test_works_take_turns_and_their_preparation_is_not_timed(clock):
    assert in_turn({"a": clock(1.0, 2.0), "b": clock(3.0, 4.0)}, 2) == [{"a": 1.0, "b": 3.0}, {"a": 2.0, "b": 4.0}]
    assert timed(lambda: 7) == (0.0, 7)


def test_a_ratio_is_the_median_over_the_rounds_but_the_first(clock):
    race = Race("a over b", clock(99.0, 2.0, 6.0, 4.0, 10.0, 8.0), clock(1.0, 1.0, 1.0, 1.0, 1.0, 1.0))
    assert measure(race, rounds=5) == {"median": 6.0, "low": 4.0, "high": 8.0}


def test_a_record_is_written_and_compared_with_the_last(clock, monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(benchmark, "ROUNDS", 1)
    for name, first, line in (
        ("1", 2.0, "a  2.00  2.00 to 2.00     -       -"),
        ("2", 3.0, "a  3.00  3.00 to 3.00  2.00    +50%"),
    ):
        monkeypatch.setattr(benchmark, "races", lambda first=first: [Race("a", clock(*[first] * 99), clock(*[1.0] * 99))])
        main(tmp_path / "bench")
        lines = capsys.readouterr().out.splitlines()
        assert " ".join(lines[1].split()) == " ".join(line.split())
        (written,) = (tmp_path / "bench").glob("2*.json")
        written.rename(tmp_path / "bench" / f"{name}.json")  # two in one second have one name
    record = json.loads((tmp_path / "bench" / "2.json").read_text())
    assert record["ratios"] == {"a": {"median": 3.0, "low": 3.0, "high": 3.0}}
    assert {"commit", "processor", "cores", "Python", "numba"} <= record["machine"].keys()
    assert last(tmp_path / "bench") == record


def test_a_damaged_record_is_passed_over(tmp_path):
    good = {"date": "then", "ratios": {"a": {"median": 2.0}}}
    (tmp_path / "1.json").write_text(json.dumps(good))
    for name, text in (("2", "{"), ("3", "[]"), ("4", '{"ratios": {"a": 1}}'), ("5", "")):
        (tmp_path / f"{name}.json").write_text(text)
    assert last(tmp_path) == good
    assert last(tmp_path / "missing") == {}


def test_the_races_are_told_apart_and_run():
    """Names are the keys under which ratios are compared from one day to the next."""
    named = {race.name: race for race in races()}
    assert len(named) == len([*races()]) == 46
    for name in ("fd: grip over rigid face", "slipwave --help over bare Python"):
        ratio = measure(named[name], rounds=1)
        assert 0.0 < ratio["low"] == ratio["median"] == ratio["high"]


def march(work):
    """Setting, scene, transits and where timing begins."""
    assert work.func is march_of
    return work.args


def test_both_sides_of_a_ratio_differ_only_in_what_it_is_named_after():
    """Grid, scene and length of every march, and that timing begins after one transit on both sides."""
    named = {race.name: race for race in races()}
    paper = slipwave.read("paper")
    for model, cells in {"fd": 128, "sbp:4": 64, "fem:4": 16, "dg:7": 8}.items():
        one = Setting(model, cells=cells, time=explicit_time(model))
        once = (one, paper, 20.0, 1.0)
        unlike = replace(paper, lower=replace(paper.lower, epsilon=1.001 * paper.lower.epsilon))
        faced = [replace(paper.upper, face=face) for face in (GripFace(100.0, 10.0), ReflectingFace(0.999))]
        wanted = {
            "twice the transits": (once[0], paper, 40.0, 1.0),
            "four times the cells": (replace(one, cells=4 * cells), paper, 20.0, 1.0),
            "unlike slabs over alike": (once[0], unlike, 20.0, 1.0),
            "grip over rigid face": (once[0], replace(paper, upper=faced[0], lower=faced[0]), 20.0, 1.0),
            "reflection over rigid face": (once[0], replace(paper, upper=faced[1], lower=faced[1]), 20.0, 1.0),
        }
        for name, first in wanted.items():
            race = named[f"{model}: {name}"]
            assert (march(race.first), march(race.second)) == (first, once)
        race = named[f"{model}: time of the delay system"]
        assert (march(race.first), march(race.second)) == (once, (Setting("delay", tolerance=1e-9), paper, 20.0, 1.0))
    for name, scene in pairs().items():
        if name != "alike":
            race = named[f"delay: {name} round trips over alike"]
            exact = Setting("delay", tolerance=1e-9)
            assert (march(race.first), march(race.second)) == ((exact, scene, 200.0, 1.0), (exact, pairs()["alike"], 200.0, 1.0))


def test_the_costs_of_the_readme_are_of_one_run_at_one_tolerance():
    named, paper = {race.name: race for race in races()}, slipwave.read("paper")
    for model in ("block12", "block8", "kelvin-voigt", "modal:1", "modal:2", "modal:4", "modal:8"):
        race = named[f"{model}: time of the delay system"]
        settings = [Setting(one, tolerance=1e-9) for one in (model, "delay")]
        assert [march(race.first), march(race.second)] == [(setting, paper, 1000.0, 1.0) for setting in settings]


def test_granite_is_marched_with_and_without_leaps():
    race = {race.name: race for race in races()}["delay: every transit of two cycles of granite over leaps"]
    (every, end, seen), (leaping, same, events) = race.first().args, race.second().args
    assert end == same == 1.6e5
    assert every.scene == leaping.scene
    assert (every.time, every.settings) == (leaping.time, leaping.settings)
    for solver, observers in ((every, seen), (leaping, events)):
        follow(solver, 6e3, observers)
    assert every.skipped == 0 < leaping.skipped


def test_the_plain_program_runs_as_long_and_as_exactly_as_the_model_it_races():
    race = {race.name: race for race in races()}["scipy's LSODA over kelvin-voigt"]
    assert race.first().args == (slipwave.read("paper"), 300.0, 1e-8)
    assert march(race.second) == (Setting("kelvin-voigt", tolerance=1e-8), slipwave.read("paper"), 300.0, 1.0)


def test_the_table_tells_median_quartiles_and_change():
    now = {"a": {"median": 1.5, "low": 1.25, "high": 1.75}, "b": {"median": 3.0, "low": 2.0, "high": 4.0}}
    rows = [*benchmark._rows(now, {"a": {"median": 2.0}})]
    assert rows == [["a", "1.50", "1.25 to 1.75", "2.00", "-25%"], ["b", "3.00", "2.00 to 4.00", "-", "-"]]
