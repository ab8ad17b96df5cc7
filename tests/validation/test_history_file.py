"""The interface's history is written as the run goes on: the same numbers, in bounded memory, across checkpoints."""

import tracemalloc

import numpy as np
import pytest
import xarray

import slipwave
from slipwave.errors import SceneError
from slipwave.observe import HistoryObserver, Pieces
from slipwave.solve import follow
from tests.granite import GRANITE
from validation.cli import main
from validation.registry.build import build
from validation.results.quantities import stored_name
from validation.run.history_file import HistoryFile, Kept

PAPER = slipwave.read("paper")
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


def test_what_comes_back_is_what_went_in(tmp_path):
    history, kept = HistoryFile(PAPER.law, NODES, tmp_path / "x", 9.0), HistoryObserver(PAPER.law, NODES)
    for first in range(30):
        history.scan(pieces(first))
        kept.scan(pieces(first))
    parts = list(history.parts())
    assert len(parts) > 1
    for name, values in kept.columns().items():
        assert np.array_equal(np.concatenate([part[name] for part in parts]), values)
    history.close()


@pytest.mark.parametrize(("until", "seen"), [(1e5, 1001), (np.inf, 1251)])
def test_more_than_a_quarter_of_the_memory_is_refused_early(tmp_path, monkeypatch, until, seen):
    """Of 8 GB after 1 %, of a run without a known end when 0.1 GB are there; one sample in ten is not too much."""
    monkeypatch.setattr("validation.run.history_file._memory", lambda: 4 * (7.9e9 if np.isfinite(until) else 0.09e9))
    history, thin = (HistoryFile(PAPER.law, NODES, tmp_path / f"{every}", until, kept=Kept(every)) for every in (1, 10))
    for first in range(seen - 1):
        history.scan(pieces(first))
        thin.scan(pieces(first))
    thin.scan(pieces(seen - 1))
    with pytest.raises(SceneError, match=r'"interface" would take .* GB, more than a quarter of the memory, .* --every N or'):
        history.scan(pieces(seen - 1))
    with pytest.raises(SceneError, match="would take 8 GB, more than a quarter"):
        HistoryFile(PAPER.law, NODES, tmp_path / "z", until).expect(8e9 / 40.0)
    history.close(), thin.close()


@pytest.mark.parametrize("block", [997, 50_000])
def test_the_file_of_a_run_holds_the_solvers_own_samples(tmp_path, capsys, monkeypatch, block):
    """Written in several blocks and in one."""
    monkeypatch.setattr("validation.run.history_file._BLOCK", block)
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


@pytest.mark.parametrize("every", [1, 2, 3, 7])
@pytest.mark.parametrize("window", [(0.0, np.inf), (1.3, 3.6)])
def test_thinned_samples_go_on_where_they_stopped(tmp_path, every, window):
    """The checkpoint lies after any part of a run: before, within or after the window."""
    parts = [pieces(first, 100 + first) for first in range(5)]
    kept = Kept(every, *window)
    whole = HistoryFile(PAPER.law, NODES, tmp_path / "whole", 9.0, kept=kept)
    for part in parts:
        whole.scan(part)
    wanted = [part["time"] for part in whole.parts()]
    for stop in range(1, 5):
        first, second = (HistoryFile(PAPER.law, NODES, tmp_path / f"{stop}", 9.0, kept=kept) for _ in range(2))
        for part in parts[:stop]:
            first.scan(part)
        saved = first.state()
        first.close()
        second.restore(saved)
        for part in parts[stop:]:
            second.scan(part)
        assert np.array_equal(np.concatenate([part["time"] for part in second.parts()]), np.concatenate(wanted))
        second.close()
    whole.close()


def test_full_detail_inside_a_window_and_leaps_outside():
    """Of granite: no leap begins, ends or lies in the window."""
    found = slipwave.run(GRANITE, until=30_000, window=(20_000.25, 20_060.5), tol=1e-6)
    plain = slipwave.run(GRANITE, until=30_000, tol=1e-6)
    time = found.dataset["time"].values
    assert (time[0], time[-1]) == (pytest.approx(20_000.25, abs=0.1), pytest.approx(20_060.5, abs=0.1))
    assert np.diff(time).max() < 0.1
    left_out, most = found.summary["left_out"], plain.summary["left_out"]
    assert most - 2000 < left_out < most - 60
    assert found.summary["final"]["psi"] == pytest.approx(plain.summary["final"]["psi"], abs=2e-6)
    found.close()
