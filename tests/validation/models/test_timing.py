"""The timer on works of known cost, and the rows of `make bench`."""

import itertools
import math
import subprocess
import sys
import time
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest

import slipwave as sw
from slipwave.compiled import njit
from slipwave.compiled.cache import COMPILING
from tests.bench.__main__ import Setting, Timed, full_waves, main, run_program, table_of_times
from tests.bench.peers import HELD, PEERS, Problem, around, at_error, table_of_peers
from validation.models import stopwatch
from validation.models.build import build
from validation.models.run import simulate
from validation.models.timing import alternating, in_turn, quartiles

PAPER = sw.read("paper", {"start.kind": "jump", "start.size": 3.0, "run.until": 80.0})
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
    assert quartiles([2.0, 6.0, 4.0, 10.0, 8.0]) == (4.0, 6.0, 8.0)
    assert table_of_times(3, {"a (ms)": Timed(clock(9.0, 1.0, 3.0, 2.0), 1e3)}) == [["a (ms)", "2e+03", "1.5e+03 to 2.5e+03"]]


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


@pytest.mark.parametrize(
    ("scene", "model"),
    [
        *((PAPER, model) for model in ("quasidynamic", "block8", "block12", "kelvin-voigt", "modal:2")),
        (sw.read("velocity-steps"), "quasistatic"),
        (sw.read(HELD, {"run.until": "21 s", "slab.thickness": "1 m"}), "quasidynamic"),
    ],
)
def test_peers_integrate_the_equations_that_the_reductions_march(scene, model):
    """After a large jump in the paper's scene, through steps of V, and into a hold; errors of 1e-6 are LSODA's."""
    problem = Problem(scene, model)
    ours, steps = problem.ours(1e-9)
    theirs = problem.solved(partial(PEERS["scipy LSODA"][0], 1e-9))
    assert ours.shape == theirs.shape == (20, 2)
    assert np.ptp(ours[:, 0]) > 0.2
    assert steps > 20
    assert np.abs(ours - theirs).max() < 2e-5


def test_times_are_compared_at_the_same_error():
    """Half-way between the errors of two tolerances in logarithms; a peer that stays above the error says at which it stands."""
    found = {1e-4: 1e-3, 1e-6: 1e-5, 1e-8: 1e-7}
    assert [around(found, error) for error in (1e-6, 1e-5, 1e-2, 1e-9)] == [[1e-8, 1e-6], [1e-6, 1e-4], [1e-4], [1e-8]]
    assert at_error(1e-6, [(1e-7, 8.0), (1e-5, 2.0)]) == pytest.approx((4.0, 1e-6))
    assert at_error(1e-9, [(1e-7, 8.0)]) == (8.0, 1e-7)
    assert at_error(1e-2, [(1e-3, 8.0)]) == (8.0, 1e-2)


def test_there_is_a_row_for_each_problem_and_tolerance(monkeypatch):
    monkeypatch.setattr(stopwatch, "processor_seconds", partial(next, itertools.count()))
    monkeypatch.delitem(PEERS, "scipy Radau")
    rows = table_of_peers(1, [Problem(PAPER, "block8")])
    assert [row[:3] for row in rows] == [["paper, 80", "block8", one] for one in ("1e-09", "1e-06")]
    assert all(len(row) == 6 + len(PEERS) and "(" in row[6] for row in rows)


def test_the_time_to_compile_is_no_part_of_a_runs(monkeypatch):
    """Before, a first comparison said that the model that ran second is 27 times cheaper."""
    taken = []
    monkeypatch.setattr("validation.models.run.COMPILING", taken)
    watch = SimpleNamespace(whole_from=math.inf, scan=lambda pieces: taken.append(1e6))
    assert simulate(build("block8", sw.read("paper")), 5.0, [watch]).wall_s < -0.9e6
    before = len(COMPILING)
    twice = njit(lambda x: 2.0 * x)
    assert twice(1.0) == twice(1.0) == 2.0
    assert len(COMPILING) == before + 1
