"""The compile cache is a convenience: whatever is wrong with its folder or files, the answer is the same and the run goes on."""

import gc
import os
import resource
import subprocess
import sys
import time

import numpy as np
import pytest
from numba.core import event

from slipwave.compiled import cache as compile_cache
from slipwave.compiled import njit
from slipwave.observe.detector import size_of

SWING = np.array([1.0, 2.0, 3.5])
ANSWER = 1.5
PROGRAM = """
import numpy as np
from slipwave.observe.detector import size_of
swing = np.array([1.0, 2.0, 3.5])
for _ in range(2):
    print(size_of(swing), size_of(swing.astype(np.float32)))
"""


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """An empty cache in a process that has not complained yet."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(compile_cache.TROUBLE, "has_warned", False)
    monkeypatch.setattr(compile_cache.TROUBLE, "is_writing", True)
    return tmp_path


def ask():
    """Answer of a fresh compiled function, and whether it came from the disk."""
    fresh = njit(size_of.py_func)
    return fresh(SWING), sum(fresh.stats.cache_hits.values())


def kept(folder):
    """The one file in the cache."""
    (path,) = folder.iterdir()
    return path


def test_a_constant_argument_is_compiled_like_any_other():
    part = njit(_scaled)

    @njit
    def whole(number):
        return int(part(number, 2) + part(number, number))

    with event.install_recorder("numba:compile") as compiled:
        assert whole(3) == 15
    functions = [one.data["dispatcher"].py_func for _, one in compiled.buffer if one.is_start]
    assert functions.count(_scaled) == 1


def _scaled(number, factor):
    return number * factor


def test_compiling_leaves_the_garbage_collector_of_a_user_alone():
    part = njit(_scaled)
    collecting = []

    class Watch(event.Listener):
        def on_start(self, event):
            collecting.append((gc.isenabled(), gc.get_threshold()))

        on_end = on_start

    expected = (True, gc.get_threshold())
    with event.install_listener("numba:compile", Watch()):
        assert part(3, 2) == 6
    assert set(collecting) == {expected}


@pytest.mark.parametrize("share", [0.0, 0.001, 0.3, 0.999])
def test_a_truncated_file_is_told_and_replaced(share, folder, capsys):
    ask()
    whole = kept(folder).read_bytes()
    kept(folder).write_bytes(whole[: int(share * len(whole))])
    assert ask() == (ANSWER, 0)
    assert capsys.readouterr().err.count("damaged file") == 1
    assert ask() == (ANSWER, 1)


def test_a_change_of_any_byte_or_of_the_name_is_noticed(folder):
    ask()
    path = kept(folder)
    whole = path.read_bytes()
    for place in range(0, len(whole), 211):
        damaged = bytearray(whole)
        damaged[place] ^= 1 << place % 8
        with pytest.raises(ValueError, match="digest"):
            compile_cache.checked(bytes(damaged), path.name)
    with pytest.raises(ValueError, match="digest"):
        compile_cache.checked(whole, "x" + path.name)
    path.write_bytes(bytes(damaged))
    assert ask() == (ANSWER, 0)


def run(environment, limit=None):
    """A process of its own that compiles a function for two types."""
    return subprocess.run(
        [sys.executable, "-c", PROGRAM], env=os.environ | environment, capture_output=True, text=True, preexec_fn=limit
    )


def _full_disk():
    resource.setrlimit(resource.RLIMIT_FSIZE, (500, 500))


@pytest.mark.parametrize("trouble", ["a file in its place", "a full disk", "nowhere"])
def test_a_run_without_a_usable_folder_ends_well(trouble, folder):
    place = folder / "cache"
    if trouble == "a file in its place":
        place.write_text("not a folder")
    where = {"NUMBA_CACHE_DIR": "/dev/null/cache" if trouble == "nowhere" else str(place), "PYTHONDONTWRITEBYTECODE": "1"}
    done = run(where, _full_disk if trouble == "a full disk" else None)
    assert (done.returncode, done.stdout) == (0, "1.5 1.5\n" * 2), done.stderr
    assert done.stderr.startswith("slipwave: the cache of compiled code in ")
    assert done.stderr.count("\n") == 1


def test_what_nobody_used_for_a_month_is_removed(folder):
    """Days since it was last used."""
    for name, days in {"old.compiled": 31, "left.part": 31, "own.nbi": 31, "recent.compiled": 7}.items():
        (folder / name).write_bytes(b"")
        os.utime(folder / name, (time.time() - days * 86400,) * 2)
    compile_cache._prune_once.cache_clear()
    ask()
    assert {path.name for path in folder.iterdir() if "size_of" not in path.name} == {"own.nbi", "recent.compiled"}


def test_a_function_in_use_counts_as_new(folder):
    ask()
    os.utime(kept(folder), (0, 0))
    assert ask() == (ANSWER, 1)
    assert kept(folder).stat().st_mtime > 0


def test_a_file_edited_since_the_process_began_keeps_its_functions_off_the_disk(folder, monkeypatch):
    monkeypatch.setattr(compile_cache, "STARTED", 0.0)
    assert [ask(), ask()] == [(ANSWER, 0)] * 2
    assert list(folder.iterdir()) == []
