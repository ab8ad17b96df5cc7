"""Studies that run side by side: they really overlap, those that measure time run alone and last, one Ctrl-C ends all."""

import fcntl
import json
import os
import signal
import subprocess
import sys
import time
from functools import partial

import pytest

from validation.report.baseline import RedReport
from validation.report.build import make_report

TOGETHER = """
    import time
    (HERE / f"{NAME}.begun").touch()
    budget.report(0.5)
    while len(list(HERE.glob("*.begun"))) < 2:
        time.sleep(0.01)
    (HERE / f"{NAME}.done").touch()
    return StudyResult(str(os.getpid()))
"""
ALONE = """
    done = sorted(path.stem for path in HERE.glob("*.done"))
    return StudyResult(f"{os.getpid()} after {', '.join(done)}")
"""
PATIENCE = 600.0
"""Seconds after which a test gives up; no outcome depends on it."""


def answers(page):
    studies = json.loads((page.parent / "report.json").read_text())["studies"]
    return [study["answer"] for study in studies if not study["error"]]


def test_studies_run_together_and_those_that_time_alone_at_the_end(fake, tmp_path, capfd):
    """The first two each wait for the other to begin: one after the other, they would never end."""
    fake.write("timing", ALONE, timed=True)
    fake.write("first", TOGETHER)
    fake.write("second", TOGETHER)
    timing, first, second = answers(make_report(tmp_path / "out", processes=2))
    assert timing == f"{os.getpid()} after first, second"
    assert len({first, second, str(os.getpid())}) == 3
    lines = capfd.readouterr().err.splitlines()
    assert sorted(line.split()[0] for line in lines[:2]) == ["first", "second"]
    assert lines[2].split()[0] == "timing"


def test_a_process_that_dies_is_a_study_that_failed(fake, tmp_path):
    fake.write("first", "os._exit(9)")
    fake.write("second", "os._exit(9)")
    fake.write("timing", ALONE, timed=True)
    with pytest.raises(RedReport) as red:
        make_report(tmp_path / "out", processes=2)
    died = "failed: a process of the report died, killed or short of memory, before this study was done"
    assert red.value.lines == [f"first: {died}", f"second: {died}"]
    assert answers(red.value.page) == [f"{os.getpid()} after "]


INTERRUPTED = """
    import signal, subprocess
    started = subprocess.Popen(["sleep", "100000"])
    started.send_signal(signal.SIGINT)
    return StudyResult(str(started.wait(600)))
"""


def test_what_a_study_starts_can_be_interrupted(fake, tmp_path):
    """As the slow tests do: processes side by side are deaf to the terminal, not to each other."""
    for name in ("first", "second"):
        fake.write(name, INTERRUPTED)
    assert answers(make_report(tmp_path / "out", processes=2)) == [str(-signal.SIGINT)] * 2


PROGRAM = """
import sys
from types import ModuleType
from validation import studies
from validation.report import build
from validation.cli import main

folder, *words = sys.argv[1:]
sys.path.insert(0, folder)
studies.STUDIES.clear()
for name in ("quick", "endless"):
    sys.modules[f"validation.studies.{name}"] = __import__(f"written_{name}")
    studies.STUDIES[name] = name
build.cores = lambda: 2
if __name__ == "__main__":
    sys.exit(main(words))
"""
ENDLESS = """
    import fcntl, subprocess, time
    if (HERE / "freed").exists():
        return StudyResult("at last")
    lock = open(HERE / "lock", "w")
    fcntl.flock(lock, fcntl.LOCK_EX)
    with subprocess.Popen(["sleep", "100000"], pass_fds=(lock.fileno(),)):
        (HERE / "begun").touch()
        time.sleep(100000)
"""


def wait_for(condition):
    began = time.monotonic()
    while not condition():
        assert time.monotonic() - began < PATIENCE
        time.sleep(0.05)


def is_free(path):
    """Whether nobody holds this file any more: neither the study's process nor the one that it started."""
    with path.open("w") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
    return True


@pytest.mark.parametrize("end", [signal.SIGINT, signal.SIGKILL])
def test_ctrl_c_ends_all_processes_and_the_report_resumes(fake, tmp_path, end):
    """With one line, and all that was done is kept. Nor does anything survive the report's own violent death."""
    fake.write("quick", 'return StudyResult("done")')
    fake.write("endless", ENDLESS)
    program = tmp_path / "program.py"
    program.write_text(PROGRAM)
    words = [sys.executable, str(program), str(fake.folder), "report", "--out", str(tmp_path / "out")]
    stored = tmp_path / "out" / "data" / "quick" / "result.json"
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    heard = partial(signal.signal, signal.SIGINT, signal.SIG_DFL)  # whoever runs the tests may have it ignored
    with subprocess.Popen(words, **pipes, start_new_session=True, preexec_fn=heard) as process:
        wait_for(lambda: (fake.folder / "begun").exists() and stored.exists())
        os.killpg(process.pid, end)
        said = process.communicate()
    wait_for(lambda: is_free(fake.folder / "lock"))
    if end is signal.SIGINT:
        assert process.returncode == 130
        assert said[0] == ""
        *told, last = said[1].splitlines()
        assert [line.split()[0] for line in told] in ([], ["quick"])  # stored, but perhaps not yet told
        kept = tmp_path / "out" / "data"
        assert last == f"slipwave: interrupted; finished studies are kept in {kept}, and the same command goes on from there"
    assert not (tmp_path / "out" / "index.html").exists()
    (fake.folder / "freed").touch()
    again = subprocess.run(words, capture_output=True, text=True, check=True)
    assert again.stderr.splitlines()[0].split() == ["quick", "stored"]
    assert answers(tmp_path / "out" / "index.html") == ["done", "at last"]
