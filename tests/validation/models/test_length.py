"""Where runs end that have no length of their own, and the file of their history: same numbers, bounded memory."""

import dataclasses
import itertools
import math
import re
import tracemalloc
from types import SimpleNamespace

import numpy as np
import pytest
import xarray

import slipwave
from slipwave.errors import SceneError
from slipwave.input.assemble import to_toml
from slipwave.observe import Events, HistoryObserver, Pieces, judge_motion
from slipwave.solve import follow
from slipwave.solve.checkpoint import Checkpoints
from tests.granite import GRANITE
from tests.slipwave.test_verdict import henon
from validation.commands.cli import main
from validation.data.variables import stored_name
from validation.models.build import build
from validation.models.history_file import HistoryFile, Thinning
from validation.models.outlook import JudgedHalf, UntilCycles, UntilSettled, growth_rate
from validation.models.run import simulate

PAPER = slipwave.read("paper")
FAST = slipwave.read("paper", ["drive.velocity=2000"])
OPEN = dataclasses.replace(PAPER, until=None)
UNSTABLE, STABLE = (UntilSettled(scene, "delay") for scene in (OPEN, slipwave.read("paper", ["slab.log10_r=-2.75"])))


def judged(sizes, rests=True, slides=False, until=4000.0):
    """Of cycles with these drops, in tenths of the normal stress, and periods that go with them."""
    drop = 0.1 * np.asarray(sizes, dtype=float)
    period = 50.0 + 300.0 * drop
    time = np.cumsum(period) - period[0] if drop.size else period
    cycles = Events(time, period, 1.1 * drop, drop, 1e4 * drop, 1e-3 / drop)
    return JudgedHalf(until, judge_motion(cycles, np.append(drop, drop[-1:]), rests, slides, until), cycles)


K = np.arange(24)
NONE = np.empty(0)


@pytest.mark.parametrize(
    ("sizes", "expected", "ended"),
    [
        (np.ones(8), UNSTABLE, "settled"),
        (np.ones(7), UNSTABLE, None),
        (1.0 + 0.02 * (-1.0) ** K[:9], UNSTABLE, "settled"),
        (henon(16, 1.4), UNSTABLE, "settled"),
        (henon(15, 1.4), UNSTABLE, None),
        (1.0 + 0.01 * np.cos(2 * np.pi * 0.263 * K), UNSTABLE, "settled"),
        (1.0 + 0.2 * 0.7**K, UNSTABLE, None),
        (1.1**K, UNSTABLE, None),
        (0.89**K, UNSTABLE, None),
        (0.89**K, STABLE, "settled"),
        (np.ones(2), STABLE, None),
    ],
)
def test_a_transient_goes_on_and_what_is_settled_ends(sizes, expected, ended):
    assert expected.ended(judged(sizes)) == ended


def test_a_drift_that_a_verdict_of_irregular_does_not_see_goes_on():
    drifts = judged(henon(32, 1.4) + 0.02 * np.arange(32.0))
    assert drifts.verdict is not None
    assert drifts.verdict.kind == "irregular"
    assert not drifts.halves_agree
    assert UNSTABLE.ended(drifts) is None


def test_steady_sliding_is_settled_where_it_is_stable_or_nothing_disturbs_it():
    slides = judged(NONE, slides=True)
    assert STABLE.ended(slides) == "settled"
    grown = 40.0 / growth_rate(OPEN, "delay")
    assert UNSTABLE.ended(slides._replace(until=0.999 * grown)) is None
    assert UNSTABLE.ended(slides._replace(until=1.001 * grown)) == "settled"
    assert UNSTABLE.ended(judged(np.ones(2), rests=False)) == "settled"
    assert UntilCycles(5, STABLE.scene, "delay").ended(slides) == "settled"
    assert UntilCycles(5, OPEN, "delay").ended(slides) is None


def test_a_run_to_a_number_of_cycles_has_them_in_its_second_half():
    for wanted in (5, 12):
        done = simulate(build("delay", FAST, tolerance=1e-6), UntilCycles(wanted, FAST, "delay"))
        assert done.ended == "cycles"
        assert done.verdict is not None
        assert wanted <= done.verdict.cycles <= wanted + 1
        assert done.events.time[-done.verdict.cycles] >= 0.5 * done.until


def test_a_run_that_does_not_settle_ends_at_the_limit_of_work():
    solver = build("delay", FAST, tolerance=1e-6)
    never = UntilSettled(FAST, "delay")
    ends = list(itertools.islice(never.ends(0.0), 4))

    class Unsettled(UntilSettled):
        def ended(self, now):
            return None

    per_transit = _pieces(ends[2]) / ends[2] * solver.seconds_per_piece
    done = simulate(solver, Unsettled(FAST, "delay", most_seconds=per_transit * 1.01 * ends[2]))
    assert (done.ended, done.until) == ("limit", ends[2])
    assert done.final == simulate(build("delay", FAST, tolerance=1e-6), ends[2]).final


def _pieces(until):
    solver, count = build("delay", FAST, tolerance=1e-6), 0
    while solver.time < until:
        count += solver.advance(until).time.size
    return count


def test_a_checkpoint_that_is_due_at_the_end_of_a_stretch_is_saved_when_the_run_goes_on(tmp_path):
    solver = build("delay", FAST, tolerance=1e-6)
    marks = Checkpoints(solver, {}, tmp_path / "run.npz", 50.0, 50.0)
    simulate(solver, 50.0, marks=[marks])
    assert not (tmp_path / "run.npz").exists()
    simulate(solver, 80.0, marks=[marks])
    assert (tmp_path / "run.npz").exists()


@pytest.fixture
def own(tmp_path):
    """A scene without `run.until`; one transit is 2 thickness/c."""
    tables = slipwave.read("paper-si", ["slab.thickness=0.033", "drive.velocity=2000"]).tables
    scene = slipwave.read({name: table for name, table in tables.items() if name != "run"})
    (tmp_path / "own.toml").write_text(to_toml(scene))
    return str(tmp_path / "own.toml")


@pytest.mark.parametrize(("text", "seconds"), [("2s", 2.0), ("1500 ms", 1.5), ("0.05 min", 3.0), ("0.001h", 3.6)])
def test_a_length_in_units_of_time_is_that_time(answer, own, text, seconds):
    found = answer("run", own, "--tol", "1e-5", "--until", text)
    assert (found["until"], found["ended"]) == (pytest.approx(seconds * math.sqrt(1e6 / 784.0) / 0.066, rel=1e-12), "until")


def test_without_a_length_the_motion_settles_in_the_shell_and_in_python(answer, printed, own):
    found = answer("run", own, "--tol", "1e-6")
    assert (found["ended"], found["verdict"]) == ("settled", "periodic")
    longer = answer("run", own, "--tol", "1e-6", "--until", f"{4.0 * found['until']}")
    assert found["period"]["mean"] == pytest.approx(longer["period"]["mean"], rel=1e-3)
    assert slipwave.run(own, tol=1e-6).summary["period"] == found["period"]
    assert "the run ended here because its motion is settled" in printed("run", own, "--tol", "1e-6")


@pytest.mark.parametrize("share", [0.3, 0.9, 0.999])
def test_a_run_continued_from_a_checkpoint_ends_where_it_would_have_ended(tmp_path, own, share):
    marked = {"tol": 1e-6, "checkpoint": tmp_path / "run.npz", "checkpoint_every": 10.0}
    whole = slipwave.run(own, tol=1e-6).summary
    slipwave.run(own, until=share * whole["until"], **marked)
    rest = slipwave.run(own, **marked).summary
    assert rest | {"wall_s": 0.0} == whole | {"wall_s": 0.0}


NODES = np.linspace(0.0, 1.0, 5)
INTERFACE = ["--set", 'run.record=["events","interface"]']


def pieces(first, count=400):
    rng = np.random.default_rng(first)
    columns = [rng.normal(size=(count, NODES.size)) for _ in range(4)]
    return Pieces(first + np.arange(count) / count, np.full(count, 1.0 / count), *columns)


def test_memory_does_not_grow_with_the_run(tmp_path):
    """A run of 1.2 million samples, 48 MB, read back as well."""
    history = HistoryFile(PAPER.law, NODES, tmp_path / "x.samples", 600.0)
    chunks = [pieces(first) for first in range(3)]
    tracemalloc.start()
    for _ in range(200):
        for chunk in chunks:
            history.scan(chunk)
    count = sum(part["time"].size for part in history.parts())
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    history.close()
    assert count == len(history) == 1_200_000
    assert (tmp_path / "x.samples").stat().st_size == 40 * count
    assert peak < 12e6


@pytest.mark.parametrize(("until", "seen"), [(1e5, 1001), (np.inf, 1251)])
def test_more_than_a_quarter_of_the_memory_is_refused_early(tmp_path, monkeypatch, until, seen):
    """Of 8 GB after 1 %, of a run without a known end when 0.1 GB are there; one sample in ten is not too much."""
    monkeypatch.setattr("validation.models.history_file._memory", lambda: 4 * (7.9e9 if np.isfinite(until) else 0.09e9))
    history, thin = (HistoryFile(PAPER.law, NODES, tmp_path / f"{every}", until, kept=Thinning(every)) for every in (1, 10))
    for first in range(seen - 1):
        history.scan(pieces(first))
        thin.scan(pieces(first))
    thin.scan(pieces(seen - 1))
    with pytest.raises(SceneError, match=r'"interface" would take .* GB, more than a quarter of the memory, .* --rate RATE or'):
        history.scan(pieces(seen - 1))
    with pytest.raises(SceneError, match="would take 8 GB, more than a quarter"):
        HistoryFile(PAPER.law, NODES, tmp_path / "z", until).expect(8e9 / 40.0)
    history.close(), thin.close()


@pytest.fixture
def boundless(monkeypatch):
    """A machine with a memory and a disk that nothing fills."""
    monkeypatch.setattr("validation.models.history_file._memory", lambda: 1e15)
    monkeypatch.setattr("validation.models.history_file.shutil.disk_usage", lambda _: SimpleNamespace(free=1e15))


@pytest.mark.usefixtures("boundless")
@pytest.mark.parametrize(
    ("words", "samples"),
    [
        ("--model fd --cells 16 --until 2.6e7 --every 1", "1e\\+09"),  # 8 steps of 5 nodes a transit
        ("--model dg:4 --cells 4 --time explicit --until 1e8 --every 1", "2.8e\\+09"),
        ("--model delay --until 1e6 --rate 1001", "1e\\+09"),
    ],
)
def test_a_billion_samples_are_refused_before_the_run_where_their_number_is_known(words, samples, monkeypatch, refused, tmp_path):
    monkeypatch.setattr("validation.models.run.follow", None)
    said = refused("run", "paper", "--yes", *words.split(), "--out", str(tmp_path / "x.nc"))
    why = "more than 1e\\+09; .* --every N, --rate RATE or --window A:B"
    assert re.search(f'"interface" would have {samples} samples, {why}', said)


@pytest.mark.usefixtures("boundless")
def test_too_many_samples_are_refused_after_a_hundredth_of_the_run_where_steps_adapt(tmp_path, monkeypatch):
    """2000 samples a transit, 1e6 are too many: 499 transits may be recorded, 501 not."""
    monkeypatch.setattr("validation.models.history_file._MOST", 1e6)
    kept, refused = (HistoryFile(PAPER.law, NODES, tmp_path / f"{until}", until) for until in (499.0, 501.0))
    for first in range(5):
        kept.scan(pieces(first))
        refused.scan(pieces(first))
    kept.scan(pieces(5))
    with pytest.raises(SceneError, match=r"would have 1e\+06 samples, more than 1e\+06; .* --every N"):
        refused.scan(pieces(5))
    kept.close(), refused.close()


@pytest.mark.parametrize("block", [997, 50_000])
def test_the_file_of_a_run_holds_the_solvers_own_samples(tmp_path, capsys, monkeypatch, block):
    monkeypatch.setattr("validation.models.history_file._BLOCK", block)
    out = tmp_path / "x.nc"
    assert main(["run", "paper", "--model", "delay", "--until", "150", "--out", str(out), *INTERFACE]) == 0
    solver = build("delay", slipwave.read("paper", {"run.until": 150.0}))
    history = HistoryObserver(solver.scene.law, solver.nodes)
    follow(solver, 150.0, [history])
    assert 2 * 997 < history.columns()["time"].size < 50_000
    with xarray.open_dataset(out) as data:
        for name, values in history.columns().items():
            assert np.array_equal(data[stored_name(name)].values, values)
        assert data["interface_stress"].attrs == {"long_name": "friction stress mu", "units": "1", "in_units_of": "normal stress"}
    assert [path.name for path in tmp_path.iterdir()] == ["x.nc"]


def test_full_detail_inside_a_window_and_leaps_outside():
    found = slipwave.run(GRANITE, until=30_000, window=(20_000.25, 20_060.5), tol=1e-6)
    plain = slipwave.run(GRANITE, until=30_000, tol=1e-6)
    time = found.dataset["time"].values
    assert (time[0], time[-1]) == (pytest.approx(20_000.25, abs=0.1), pytest.approx(20_060.5, abs=0.1))
    assert np.diff(time).max() < 0.1
    left_out, most = found.summary["left_out"], plain.summary["left_out"]
    assert most - 2000 < left_out < most - 60
    assert found.summary["final"]["psi"] == pytest.approx(plain.summary["final"]["psi"], abs=2e-6)
    found.close()
