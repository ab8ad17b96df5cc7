"""What other processes and threads do between two steps of a sweep: each is done here at that moment."""

import os
import sys
import threading
from concurrent.futures import Future, ThreadPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool

import numpy as np
import pytest
from test_sweep import Here, computed, plan

from slipwave.errors import NumericsError, SceneError
from validation.sweep.executors import _environment
from validation.sweep.store import Store


def test_a_sweep_begun_by_another_process_just_now_goes_on(tmp_path):
    class Late(Store):
        """Looks for a manifest at first, and another process writes it then."""

        looked = False

        @property
        def manifest(self):
            if not self.looked:
                self.looked = True
                Store(self.folder).begin({"axes": [1]})
                return None
            return super().manifest

    assert Late(tmp_path / "new").begin({"axes": [1]}) is None
    with pytest.raises(SceneError, match="holds another sweep"):
        Late(tmp_path / "other").begin({"axes": [2]})
    assert Store(tmp_path / "other").manifest == {"axes": [1]}


def begun(folder, number, **how):
    store = Store(folder)
    store.begin({"axes": [number]}, **how)
    store.write(np.array([number]), {"status": np.zeros(1, dtype=np.int8)})
    return store


def test_no_part_of_another_sweep_is_taken_for_one_of_a_sweep_begun_anew(tmp_path, monkeypatch):
    """Whether its process goes on, writes just then, or was killed as it removed the parts."""
    before = begun(tmp_path, 3)
    (tmp_path / "sweep.nc").write_text("gathered")
    now = begun(tmp_path, 1, anew=True)
    assert np.flatnonzero(now.done(plan())).tolist() == [1]
    with pytest.raises(SceneError, match="another process has begun another sweep there"):
        before.write(np.array([4]), {})
    monkeypatch.setattr(Store, "manifest", {"axes": [3]})  # it had looked before the new one began
    before.write(np.array([4]), {"status": np.zeros(1, dtype=np.int8)})
    monkeypatch.undo()
    assert np.flatnonzero(now.done(plan())).tolist() == [1]
    assert np.flatnonzero(Store(tmp_path).done(plan())).tolist() == [1]
    monkeypatch.setattr("validation.sweep.store.shutil.rmtree", lambda *_, **__: sys.exit("killed"))
    with pytest.raises(SystemExit):
        now.begin({"axes": [2]}, anew=True)
    monkeypatch.undo()
    (tmp_path / "sweep.nc").unlink()
    assert np.flatnonzero(begun(tmp_path, 2).done(plan())).tolist() == [2]


def test_two_that_begin_anew_at_once_are_one(tmp_path):
    begun(tmp_path, 3)

    class Late(Store):
        """Another process removes the manifest, and writes its own, just after this one has looked."""

        @property
        def manifest(self):
            found = super().manifest
            if found == {"axes": [3]}:
                begun(self.folder, 1, anew=True)
            return found

    Late(tmp_path).begin({"axes": [1]}, anew=True)
    (tmp_path / "manifest.json").unlink()
    assert Store(tmp_path).manifest is None


def test_a_worker_killed_as_it_starts_costs_nothing(tmp_path, monkeypatch):
    made = []

    class Pool(Here):
        """The first one is broken before it has taken anything."""

        _processes = None

        def __init__(self, *_):
            made.append(self)

        def submit(self, function, /, *given, **named):
            if made[0] is self:
                raise BrokenProcessPool
            return super().submit(function, *given, **named)

    monkeypatch.setattr("validation.sweep.executors.ProcessPoolExecutor", Pool)
    assert (computed(plan((3, 2)), tmp_path, executor=None, workers=1)["status"].values == 0).all()
    assert len(made) == 2


def test_parts_of_a_broken_pool_are_computed_one_by_one(tmp_path, monkeypatch):
    broken, flying = [], []

    class Breaking(Here):
        def submit(self, function, /, *given, **named):
            if len(broken) == 3:
                return super().submit(function, *given, **named)
            broken.append(Future())
            broken[-1].set_exception(BrokenProcessPool())
            return broken[-1]

    monkeypatch.setattr("validation.sweep.engine.wait", lambda futures, *how: flying.append(len(futures)) or wait(futures, *how))
    assert (computed(plan(), tmp_path, executor=Breaking())["status"].values == 0).all()
    assert flying[:4] == [6, 1, 1, 1]


def test_an_executor_that_takes_nothing_ends_the_sweep(tmp_path):
    closed = ThreadPoolExecutor(1)
    closed.shutdown()
    with pytest.raises(NumericsError, match=r"takes no parts: cannot schedule new futures .*; finished parts are kept"):
        computed(plan((3, 2)), tmp_path, executor=closed)


def test_threads_that_start_processes_leave_the_environment_as_it_was():
    entered, freed = threading.Event(), threading.Event()

    def other():
        with _environment({"SLIPWAVE_TEST_THREAD": "1"}):
            entered.set()
            freed.wait()

    with ThreadPoolExecutor(1) as thread:
        with _environment({"SLIPWAVE_TEST_THREAD": "1"}):
            thread.submit(other)
            entered.wait(0.2)  # in vain: the other waits for this block to end
        freed.set()
    assert os.environ.get("SLIPWAVE_TEST_THREAD") is None
