"""The timer on works of known cost, and the rows of `make bench`."""

import subprocess
import sys
import time
from functools import partial

import pytest

from tests.bench.__main__ import full_waves, main, run_program
from validation.measure import stopwatch
from validation.timing import Setting, alternating, in_turn, quartiles

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
    now = [0.0]
    monkeypatch.setattr(stopwatch, "processor_seconds", lambda: now[0])

    def work(*seconds):
        left = iter(seconds)

        def prepare():
            now[0] += 100.0
            return spend

        def spend():
            spent = next(left)
            now[0] += spent
            return -spent

        return prepare

    return work


def test_processor_time_leaves_out_sleep_and_counts_the_processes_that_were_started():
    busy = [sys.executable, "-c", "import time\nwhile time.process_time() < 0.2: pass"]
    works = {"idle": lambda: partial(time.sleep, 0.2), "busy": lambda: partial(subprocess.run, busy, check=True)}
    (spent,) = in_turn(works, 1)
    assert spent["idle"] < 0.1
    assert spent["busy"] > 0.15


def test_works_take_turns(clock):
    found = list(alternating({"a": clock(1.0, 2.0), "b": clock(3.0, 4.0)}, 2))
    assert found == [("a", 1.0, -1.0), ("b", 3.0, -3.0), ("a", 2.0, -2.0), ("b", 4.0, -4.0)]
    assert in_turn({"a": clock(1.0, 2.0), "b": clock(3.0, 4.0)}, 2) == [{"a": 1.0, "b": 3.0}, {"a": 2.0, "b": 4.0}]
    ticks = iter([5.0, 8.0])
    assert list(alternating({"a": clock(1.0)}, 1, partial(next, ticks))) == [("a", 3.0, -1.0)]


def test_quartiles_by_hand():
    assert quartiles([2.0, 6.0, 4.0, 10.0, 8.0]) == (4.0, 6.0, 8.0)


def test_the_program_prints_the_error_and_the_time_of_every_march(tmp_path, capsys):
    """The other program finds a module beside it, and sleeps for 200 ms, which take no processor time."""
    (tmp_path / "beside.py").write_text("")
    (tmp_path / "plain.py").write_text(PLAIN)
    assert 0.0 <= run_program(tmp_path / "plain.py")[0].ms[0] < 100.0
    settings = (Setting("delay", tolerance=1e-9), Setting("dg:16", 1e-10, 2, time="exact"))
    found = full_waves(tmp_path / "plain.py", 2, settings)
    assert [len(one.ms) for one in found] == [2, 2, 2]
    main(found, {}, 1)
    _, other, delay, exact, *_ = (line.rsplit(maxsplit=5) for line in capsys.readouterr().out.splitlines())
    names = (
        "plain: degree 7, elements 8",
        "delay: delay, tolerance 1e-9",
        "exact: dg:16, 2 cells, exact in time, tolerance 1e-10",
    )
    assert (other[0], delay[0], exact[0]) == names
    assert float(delay[1]) < 3e-10  # 3e-11 measured
    assert float(exact[1]) < 1e-10  # 1e-11 measured
