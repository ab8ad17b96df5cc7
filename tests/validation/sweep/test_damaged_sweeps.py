"""Folders of sweeps that are damaged or made to do harm, and what other processes and threads do between two steps."""

import io
import json
import os
import shutil
import sys
import threading
import zipfile
from concurrent.futures import Future, ThreadPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool

import numpy as np
import pytest
from test_sweep import DISC, Here, computed, plan

import slipwave as sw
from slipwave.errors import NumericsError, SceneError
from validation.commands.cli import main
from validation.sweep import store as of_store
from validation.sweep.store import Store
from validation.sweep.workers import environment


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole") / "map"
    sw.sweep("paper", vary={"log10_r": (-2.75, -2.2, 3)}, models="block8", measure="stability", out=folder, executor=Here())
    assert len(list((folder / "parts").iterdir())) == 3
    return folder


@pytest.fixture
def folder(whole, tmp_path):
    shutil.copytree(whole, tmp_path / "map")
    return tmp_path / "map"


def packed(columns, kind=zipfile.ZIP_STORED):
    """The bytes of a part with these columns: arrays, or bytes of members."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", kind) as file:
        for name, values in columns.items():
            member = io.BytesIO()
            if isinstance(values, bytes):
                member.write(values)
            else:
                np.save(member, values)
            file.writestr(f"{name}.npy", member.getvalue())
    return out.getvalue()


def declared(kind, shape):
    """A member that declares more than it holds."""
    out = io.BytesIO()
    np.lib.format.write_array_header_1_0(out, {"descr": kind, "fortran_order": False, "shape": shape})
    return out.getvalue() + bytes(80)


def without(columns, name):
    return {key: values for key, values in columns.items() if key != name}


PARTS = {
    "nothing": lambda columns: b"",
    "no zip": lambda columns: b"no zip" * 99,
    "cut off": lambda columns: packed(columns)[:-7],
    "a byte changed": lambda columns: packed(columns).replace(columns["growth_rate"].tobytes(), b"12345678", 1),
    "no points": lambda columns: packed(without(columns, "point")),
    "no status": lambda columns: packed(without(columns, "status")),
    "a point too far": lambda columns: packed(columns | {"point": np.array([3])}),
    "a point below": lambda columns: packed(columns | {"point": np.array([-1])}),
    "points in words": lambda columns: packed(columns | {"point": np.array(["../../../x"])}),
    "points in halves": lambda columns: packed(columns | {"point": np.array([0.5])}),
    "another length": lambda columns: packed(columns | {"epsilon_c": np.zeros(2)}),
    "a table": lambda columns: packed(columns | {"epsilon_c": np.zeros((1, 4))}),
    "text": lambda columns: packed(columns | {"epsilon_c": np.array(["x"])}),
    "bytes": lambda columns: packed(columns | {"epsilon_c": b"\x84\x81\xb9"}),
    "objects": lambda columns: packed(columns | {"epsilon_c": np.array([{}], dtype=object)}),
    "an unknown status": lambda columns: packed(columns | {"status": np.array([4], dtype=np.int8)}),
    "an unknown word": lambda columns: packed(columns | {"stable": np.array([7], dtype=np.int8)}),
    "a large header": lambda columns: packed(columns | {"epsilon_c": declared("<f8", (99_999_999_999,))}),
    "a large word": lambda columns: packed(columns | {"reason": declared("<U400000000", (1,))}),
    "a bomb": lambda columns: packed(columns | {"growth": np.zeros(200_000)}, zipfile.ZIP_DEFLATED),
}


@pytest.mark.parametrize("damage", PARTS)
def test_a_damaged_part_counts_as_absent(damage, folder, answer, monkeypatch):
    path = sorted((folder / "parts").iterdir())[1]
    with np.load(path) as data:
        columns = dict(data)
    path.write_bytes(PARTS[damage](columns))
    if damage == "a bomb":
        monkeypatch.setattr(of_store, "_LARGEST", 100_000)
        assert path.stat().st_size < 5000
    loaded, load = [], np.load
    monkeypatch.setattr(np, "load", lambda file, **how: loaded.append(file) or load(file, **how))
    told = answer("sweep", str(folder), "--gather")
    assert (told["points"], told["done"]) == (3, 2)
    if damage in ("a large header", "a large word", "a bomb", "a table"):
        assert len(loaded) == 2, "unpacked before its size was checked"
    drawn = ["--plot", str(folder / "map.png"), "--show", "growth_rate"] if damage == "no status" else ["--plain", "--json"]
    assert main(["map", str(folder), *drawn]) == 0
    assert sw.sweep(folder, executor=Here()).summary["computed_now"] == 1


def test_a_folder_all_of_whose_parts_are_damaged_is_a_folder_without_points(folder, answer):
    for path in (folder / "parts").iterdir():
        path.write_bytes(b"")
    assert answer("sweep", str(folder), "--gather")["done"] == 0
    assert main(["map", str(folder), "--plot", str(folder / "map.png")]) == 0


KEYS = ("scene_toml", "axes", "models", "measure", "options", "rows", "program", "files", "scene", "scene_digest")
ODD = (None, 5, -1e400, "x", "\ud800", ":", [], [[1, 2], 3], {"a": [1]}, [{"key": "V", "unit": "", "values": []}], ["", ""])
ODDER = {
    "axes": (
        [{"key": "V", "unit": "", "values": [1.0, float("nan")]}],
        [{"key": "V", "unit": "um", "values": [1.0, 2.0]}],
        [{"key": "x.y", "unit": "", "values": [1.0, 2.0]}],
        [{"key": "V", "unit": "", "values": [[1.0], 2.0]}],
        [{"key": "V", "unit": "", "values": "1:2:3"}],
        [{"key": name, "unit": "", "values": [*range(1, 50_001)]} for name in ("V", "a")],
    ),
    "options": ({"refine": 25}, {"refine": "A"}, {"tol": "x"}, {"tol": []}),
    "rows": ([{"V": [1]}], [{"V": {}}], [{"a.b": 1.0}]),
    "scene_toml": ("[" * 5000, "x = 1", "[interface]\nlaw = 'of nobody'"),
}
DRAWN = {"scene_toml", "axes", "models", "measure", "rows"}
"""What a map shows something of."""
CHANGES = [(key, value) for key in KEYS for value in (*ODD, *ODDER.get(key, ()))]


@pytest.mark.parametrize("key", KEYS)
def test_a_manifest_of_any_content_gives_a_result_or_one_line(key, folder, capsys):
    path = folder / "manifest.json"
    found, drawn = json.loads(path.read_text()), ["--plot", str(folder / "o.png")] if key in DRAWN else ["--plain", "--json"]
    for value in (value for name, value in CHANGES if name == key and value != found[key]):
        path.write_text(json.dumps(found | {key: value}))
        for words in (["map", str(folder), *drawn], ["sweep", str(folder), "--gather"]):
            capsys.readouterr()
            status = main(words)
            assert status in (0, 2), (words, value)
            assert status == 0 or len(capsys.readouterr().err.splitlines()) == 1, (words, value)
        with pytest.raises(SceneError):
            sw.sweep(folder, executor=Here())


@pytest.mark.parametrize("text", ["", "[" * 100_000, "[]", "null", "9" * 5000])
def test_a_text_that_is_no_manifest_is_damaged(text, folder, refused):
    (folder / "manifest.json").write_text(text)
    for words in (["map", str(folder)], ["sweep", str(folder)], ["sweep", str(folder), "--gather"]):
        assert "damaged" in refused(*words)


def test_a_plan_of_too_many_points_is_refused_before_anything_is_made(folder, refused):
    path = folder / "manifest.json"
    many = [{"key": name, "unit": "", "values": [*range(1, 50_001)]} for name in ("drive.velocity", "interface.a")]
    path.write_text(json.dumps(json.loads(path.read_text()) | {"axes": many}))
    for words in (["map", str(folder)], ["sweep", str(folder)], ["sweep", str(folder), "--gather"]):
        assert "2500000000 points; must be at most 1e8" in refused(*words)


@pytest.fixture
def imported(monkeypatch):
    found = []

    class Watch:
        def find_spec(self, name, path=None, target=None):
            found.append(name)

    monkeypatch.setattr(sys, "meta_path", [Watch(), *sys.meta_path])
    return found


def test_no_folder_says_what_is_imported(tmp_path, imported, monkeypatch, refused):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "evil.py").write_text("open('seen', 'w').close()\ndef boom(scene): return {'x': 1.0}")
    computed(plan((3, 2)), tmp_path / "map")
    path = tmp_path / "map" / "manifest.json"
    path.write_text(path.read_text().replace(DISC, "evil:boom"))
    assert main(["map", "map", "--plot", "o.png"]) == 0
    assert main(["sweep", "map", "--gather"]) == 0
    assert main(["map", "map/sweep.nc", "--plot", "o.png"]) == 0
    for more in ([], ["--dry"], ["--anew"], ["--measure", "run"]):
        assert "going on needs --measure evil:boom" in refused("sweep", "map", *more)
    assert "evil" not in imported
    assert not (tmp_path / "seen").exists()
    assert main(["sweep", "map", "--measure", "evil:boom", "--dry"]) == 0
    assert (tmp_path / "seen").exists()


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
        with environment({"SLIPWAVE_TEST_THREAD": "1"}):
            entered.set()
            freed.wait()

    with ThreadPoolExecutor(1) as thread:
        with environment({"SLIPWAVE_TEST_THREAD": "1"}):
            thread.submit(other)
            entered.wait(0.2)  # in vain: the other waits for this block to end
        freed.set()
    assert os.environ.get("SLIPWAVE_TEST_THREAD") is None
