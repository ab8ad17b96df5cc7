"""The compile cache is a convenience: whatever is wrong with its folder or files, the answer is the same and the run goes on."""

import os
import resource
import subprocess
import sys

import numpy as np
import pytest

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


def test_a_file_edited_since_the_process_began_keeps_its_functions_off_the_disk(folder, monkeypatch):
    monkeypatch.setattr(compile_cache, "STARTED", 0.0)
    assert [ask(), ask()] == [(ANSWER, 0)] * 2
    assert list(folder.iterdir()) == []
