"""The timer on works of known cost, the ratios of `make bench`, and the race of full waves."""

import json
import subprocess
import sys
import time
from functools import partial

import pytest

from validation import benchmark, timing
from validation.benchmark import last, main, ratios
from validation.measure.stopwatch import timed
from validation.timing import March, Race, Setting, in_turn
from validation.wave_race import Entrant, fastest, race_ratios, raced, run_program
from validation.wave_race import main as print_race

PLAIN = """
import json, time
import beside
began = time.perf_counter()
time.sleep(0.2)
print(json.dumps({"degree": 7, "elements": 8.0, "error": 1e-9, "ms": 1e3 * (time.perf_counter() - began)}))
"""


@pytest.fixture
def clock(monkeypatch):
    """Processor time that passes only where a work says so; what is prepared does not count."""
    monkeypatch.setattr(timing, "timed", lambda work: (work(), None))

    def work(*seconds):
        left = iter(seconds)
        return lambda: partial(next, left)

    return work


def test_processor_time_leaves_out_sleep_and_counts_the_processes_that_were_started():
    assert timed(lambda: time.sleep(0.2))[0] < 0.1
    busy = "import time\nwhile time.process_time() < 0.2: pass"
    assert timed(lambda: subprocess.run([sys.executable, "-c", busy], check=True))[0] > 0.15


def test_works_take_turns(clock):
    assert in_turn({"a": clock(1.0, 2.0), "b": clock(3.0, 4.0)}, 2) == [{"a": 1.0, "b": 3.0}, {"a": 2.0, "b": 4.0}]


def test_a_ratio_is_the_median_over_the_rounds_but_the_first(clock):
    ratio = Race("a over b", clock(99.0, 2.0, 6.0, 4.0, 10.0, 8.0), clock(1.0, 1.0, 1.0, 1.0, 1.0, 1.0))
    assert ratio.measure(rounds=5) == {"median": 6.0, "low": 4.0, "high": 8.0}


def test_a_record_is_written_and_compared_with_the_last(clock, monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(benchmark, "ROUNDS", 1)
    for name, first, line in (("1", 2.0, "a 2.00 2.00 to 2.00 - -"), ("2", 3.0, "a 3.00 3.00 to 3.00 2.00 +50%")):
        monkeypatch.setattr(benchmark, "ratios", lambda first=first: [Race("a", clock(first, first), clock(1.0, 1.0))])
        main(tmp_path / "bench")
        assert " ".join(capsys.readouterr().out.splitlines()[1].split()) == line
        (written,) = (tmp_path / "bench").glob("2*.json")
        written.rename(tmp_path / "bench" / f"{name}.json")  # two in one second have one name
    record = json.loads((tmp_path / "bench" / "2.json").read_text())
    assert record["ratios"] == {"a": {"median": 3.0, "low": 3.0, "high": 3.0}}
    assert {"commit", "processor", "cores", "Python", "numba"} <= record["machine"].keys()
    (tmp_path / "bench" / "3.json").write_text('{"ratios": {"a": 1}}')
    assert last(tmp_path / "bench") == record
    assert last(tmp_path / "missing") == {}


def test_both_sides_of_a_ratio_differ_only_in_what_it_is_named_after():
    """Names are the keys under which ratios are compared from one day to the next."""
    named = {ratio.name: ratio for ratio in ratios()}
    assert len(named) == len([*ratios()])
    for name, ratio in named.items():
        if isinstance(ratio.first, March) and isinstance(ratio.second, March):
            one, other = vars(ratio.first), vars(ratio.second)
            assert sum(one[part] != other[part] for part in one) == 1, name
            assert one["begin"] == 1.0
    for name in ("fd: grip over rigid face", "slipwave --help over bare Python"):
        measured = named[name].measure(rounds=1)
        assert 0.0 < measured["low"] == measured["median"] == measured["high"]


FOUND = [
    Entrant(kind, "", error, ms)
    for kind, error, ms in (
        ("rival", 1e-7, 50.0),
        ("rival", 9e-10, 800.0),
        ("rival", 1e-10, 2000.0),
        ("delay", 5e-12, 10.0),
        ("exact", 1e-8, 10.0),
        ("exact", 1e-10, 20.0),
        ("exact", 8e-12, 25.0),
        ("explicit", 5e-10, 110.0),
        ("fd", 2e-6, 30.0),
    )
]


def test_times_are_compared_at_equal_errors():
    assert [ratio for _, ratio in race_ratios(FOUND)] == ["40.00", "5.50", "1.50", "1.25", "2.00", "2.50"]
    assert fastest(FOUND, "rival", 1e-11) is None
    assert next(race_ratios(FOUND[3:])) == ("rival to 1e-09 over exact to 1e-09", "-")


def test_the_race_is_run_and_printed(tmp_path, capsys):
    """The other program finds a module beside it, and sleeps for 200 ms, which take no processor time."""
    (tmp_path / "beside.py").write_text("")
    (tmp_path / "plain.py").write_text(PLAIN)
    assert 0.0 <= run_program(tmp_path / "plain.py")[0].ms < 100.0
    settings = (Setting("delay", tolerance=1e-9), Setting("dg:16", 1e-10, 2, time="exact"))
    print_race(raced(tmp_path / "plain.py", settings, repeats=1))
    _, other, delay, exact, *_ = (line.rsplit(maxsplit=2) for line in capsys.readouterr().out.splitlines())
    names = (
        "plain: degree 7, elements 8",
        "delay: delay, tolerance 1e-9",
        "exact: dg:16, 2 cells, exact in time, tolerance 1e-10",
    )
    assert (other[0], delay[0], exact[0]) == names
    assert float(delay[1]) < 3e-10  # 3e-11 measured
    assert float(exact[1]) < 1e-10  # 1e-11 measured
