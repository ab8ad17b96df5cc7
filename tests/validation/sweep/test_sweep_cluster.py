"""A sweep on a real dask cluster: a scheduler and two workers, each a process, started by dask's own commands."""

import socket
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import slipwave as sw

pytest.importorskip("distributed")
ROOT = Path(__file__).parents[3]
SLOWLY, UNTIL_FREED = (f"tests.validation.sweep_measures:{name}" for name in ("slowly", "until_freed"))
_LONGEST = 600  # seconds after which a test gives up; no outcome depends on it


@pytest.fixture
def cluster(tmp_path, monkeypatch):
    import distributed

    monkeypatch.setenv("SLIPWAVE_TEST_MARKS", str(tmp_path))
    where = ("--scheduler-file", str(tmp_path / "scheduler.json"))

    def start(*words):
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "cwd": ROOT}
        return subprocess.Popen([sys.executable, "-m", "dask", *words, *where, "--no-dashboard"], **quiet)

    scheduler = start("scheduler", "--host", "127.0.0.1", "--port", "0")
    workers = [start("worker", "--nthreads", "1", "--no-nanny") for _ in range(2)]
    try:
        with distributed.Client(scheduler_file=where[1], timeout=_LONGEST, set_as_default=False) as client:  # type: ignore[no-untyped-call]
            client.wait_for_workers(2, timeout=_LONGEST)
            address = client.scheduler.address
        yield address, scheduler
    finally:
        for process in (*workers, scheduler):
            process.kill()
            process.wait()


@pytest.mark.slow
def test_a_cluster_gives_equal_arrays(tmp_path, cluster):
    vary = {"log10_r": (-2.72, -2.6, 4)}
    here = sw.sweep("paper", vary=vary, models="block12", until=400, tol=1e-6, workers=1, out=tmp_path / "here").dataset
    there = sw.sweep(
        "paper", vary=vary, models="block12", until=400, tol=1e-6, scheduler=cluster[0], out=tmp_path / "there"
    ).dataset
    assert (here["status"].values == 0).all()
    for name in here.data_vars:
        assert np.array_equal(here[name].values, there[name].values, equal_nan=here[name].dtype.kind == "f")


@pytest.mark.slow
def test_a_scheduler_killed_half_way_costs_nothing(tmp_path, cluster):
    address, scheduler = cluster
    module = [sys.executable, "-m", "validation.commands.cli"]
    command = [*module, "sweep", "paper", "--measure", UNTIL_FREED, "--scheduler", address]
    command += ["--vary", "a=0.001:0.019:20", "b=0.011:0.029:10", "--out", str(tmp_path / "out")]
    running = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    while running.poll() is None and not list((tmp_path / "out" / "parts").glob("[0-9]*.npz")):
        time.sleep(0.01)
    scheduler.kill()
    told = running.communicate()[1]
    assert running.returncode == 3, told
    assert "went away" in told.splitlines()[-1]
    (tmp_path / "freed").touch()
    result = sw.sweep(tmp_path / "out", workers=1, measure="tests.validation.sweep_measures:until_freed")
    assert result.summary["done"] == 200
    assert result.summary["computed_now"] < 200


@pytest.mark.parametrize("address", ["nowhere", "tcp://127.0.0.1:{}"])
def test_no_scheduler_is_one_line(tmp_path, refused, address):
    import dask

    with socket.socket() as taken, dask.config.set({"distributed.comm.timeouts.connect": "1s"}):
        taken.bind(("127.0.0.1", 0))
        address = address.format(taken.getsockname()[1])
        words = ["sweep", "paper", "--vary", "a=0.01:0.02:3", "--measure", SLOWLY, "--out", str(tmp_path / "out")]
        assert f"--scheduler = {address!r}: no scheduler answers there: " in refused(*words, "--scheduler", address)
    assert not (tmp_path / "out").exists()
