"""What is no file of data is refused in one line; a pipe is read to its end, and no further than to 1 GB."""

import os
import threading
from contextlib import suppress

import pytest

from slipwave import files
from slipwave.errors import SceneError
from slipwave.files import content_of

pytestmark = pytest.mark.skipif(os.name != "posix", reason="pipes and devices")
READERS = (
    ["fit", "velocity-steps", "--free", "a,b", "--data"],
    ["sweep", "paper", "--out", "map", "--rows"],
    ["compare", "steel-on-pmma", "--models", "quasidynamic", "--until", "2s", "--with"],
)


@pytest.mark.parametrize("words", READERS)
@pytest.mark.parametrize(
    ("name", "told"), [("/dev/zero", "a device"), ("folder", "a folder"), ("pipe", "pipe"), ("no", "no such")]
)
def test_what_is_no_data_is_refused(words, name, told, tmp_path, monkeypatch, refused):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(files.time, "sleep", lambda seconds: None)  # for a writer of the pipe
    os.mkdir("folder")
    os.mkfifo("pipe")
    assert told in refused(*words, name)


@pytest.fixture
def pipe(tmp_path):
    """A pipe, and what writes to it."""
    os.mkfifo(tmp_path / "pipe")

    def writing(content):
        def write():
            with suppress(BrokenPipeError), open(tmp_path / "pipe", "wb", buffering=0) as file:
                file.write(content)

        threading.Thread(target=write, daemon=True).start()
        return tmp_path / "pipe"

    return writing


def test_a_pipe_is_read_to_its_end(pipe):
    content = bytes(range(256)) * 10_000
    assert content_of(pipe(content), "here") == content


def test_a_pipe_without_end_ends(pipe, monkeypatch):
    monkeypatch.setattr(files, "MOST_BYTES", 100_000)
    monkeypatch.setattr(files, "_PROBE", 10_000)
    with pytest.raises(SceneError, match="here: is longer than 1 GB"):
        content_of(pipe(bytes(1_000_000)), "here")
