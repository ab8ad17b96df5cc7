"""Files are whole or absent, whatever stops their writing."""

import os
import re
import subprocess
from threading import Event, Thread

import pytest

from slipwave import sources
from slipwave.errors import SceneError
from slipwave.files import part_of, whole_or_absent


def write_half(target, stop):
    with whole_or_absent(target) as temporary:
        temporary.write_text("half")
        raise stop


@pytest.mark.parametrize("stop", [KeyboardInterrupt, ZeroDivisionError, OSError])
@pytest.mark.parametrize("old", [None, "old"])
def test_a_file_stopped_half_way_is_as_it_was(tmp_path, stop, old):
    target = tmp_path / "x.nc"
    if old is not None:
        target.write_text(old)
    with pytest.raises(SceneError if stop is OSError else stop):
        write_half(target, stop)
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == ({} if old is None else {"x.nc": old})


def test_a_whole_file_takes_the_place_of_the_old_one(tmp_path):
    target, neighbour = tmp_path / ("x" * 240 + ".nc"), tmp_path / "plain"
    target.write_text("old")
    neighbour.write_text("")
    with whole_or_absent(target) as temporary:
        assert (temporary.parent, temporary.suffix) == (tmp_path, ".nc")
        temporary.write_text("new")
        assert target.read_text() == "old"
    assert (target.read_text(), target.stat().st_mode) == ("new", neighbour.stat().st_mode)
    assert sorted(tmp_path.iterdir()) == sorted([target, neighbour])


def test_two_processes_write_to_parts_of_their_own(tmp_path, monkeypatch):
    target = tmp_path / "x.nc"
    with whole_or_absent(target) as first:
        first.write_text("first")
        monkeypatch.setattr(os, "getpid", lambda: -1)
        with whole_or_absent(target) as second:
            second.write_text("second")
        assert target.read_text() == "second"
    assert target.read_text() == "first"


def test_threads_write_files_whose_names_begin_alike_one_after_the_other(tmp_path):
    """netCDF's library ends a process in which two threads use it, and their parts would have one name."""
    targets, inside = [tmp_path / f"{'granite ' * 8}{number}.nc" for number in (1, 2)], Event()

    def write_second():
        with whole_or_absent(targets[1]) as temporary:
            inside.set()
            temporary.write_text("second")

    thread = Thread(target=write_second)
    with whole_or_absent(targets[0]) as temporary:
        temporary.write_text("first")
        thread.start()
        assert not inside.wait(0.3)
    thread.join()
    assert [target.read_text() for target in targets] == ["first", "second"]


@pytest.mark.parametrize("folder", ["nowhere", "n" * 300])
def test_a_folder_that_is_not_there_is_named(folder, tmp_path):
    target = tmp_path / folder / "x.nc"
    with pytest.raises(SceneError) as found:
        write_half(target, OSError)
    assert str(found.value) == f"{str(target)!r} cannot be written: the folder {str(target.parent)!r} does not exist"


def test_what_killed_processes_left_goes_when_the_next_file_is_written(tmp_path, monkeypatch):
    """But not what another process is writing, nor what is no part, nor what another machine may be writing."""
    parts = {}
    with subprocess.Popen(["sleep", "100000"]) as other:
        with subprocess.Popen(["true"]) as gone:
            pass
        for name, process in (("running", other.pid), ("killed", gone.pid)):
            monkeypatch.setattr(os, "getpid", lambda process=process: process)
            parts[name] = [part_of(tmp_path / stem, suffix) for stem, suffix in (("x.nc", ".nc"), ("run.nc", ".samples"))]
        others = (f".notes-{gone.pid}.txt", f".x-elsewhere-{gone.pid}.nc", "x-1.nc")
        stay = [*parts["running"], *(tmp_path / name for name in others)]
        for path in (*stay, *parts["killed"]):
            path.write_text("half")
        with whole_or_absent(tmp_path / "y.png") as temporary:
            temporary.write_text("whole")
        other.kill()
    assert sorted(tmp_path.iterdir()) == sorted([*stay, tmp_path / "y.png"])


def test_the_commit_is_asked_for_without_a_lock_on_the_checkout(tmp_path, monkeypatch):
    """Git writes its index anew under a lock where times of files have changed; a killed process left that lock."""
    monkeypatch.setattr(sources, "ROOT", tmp_path)
    file, index = tmp_path / "file", tmp_path / ".git" / "index"
    file.write_text("text")
    for words in (["init", "-q"], ["add", "file"], ["-c", "user.name=x", "-c", "user.email=x", "commit", "-qm", "x"]):
        subprocess.run(["git", "-C", str(tmp_path), *words], check=True)
    os.utime(file, (1e9, 1e9))
    before = index.read_bytes()
    assert re.fullmatch("[0-9a-f]{10}", sources.commit.__wrapped__())  # of now, not the one that is kept
    assert index.read_bytes() == before
