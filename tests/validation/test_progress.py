"""Progress by a clock of the test's own: lines for the logger, a bar on a terminal, nothing for short work."""

import logging
import sys

import pytest

from validation.run import progress as module
from validation.run.progress import progress


@pytest.fixture
def now(monkeypatch):
    """The time, which passes only where a test says so."""
    time = [100.0]
    monkeypatch.setattr(module, "PATIENCE", 2.0)
    monkeypatch.setattr(module.time, "monotonic", lambda: time[0])
    return time


def test_lines_come_every_ten_seconds_and_tell_share_and_time_left(now, caplog):
    """At 40 of 200 after 11 s, 10 of which brought 20: 160 are left, at 2 a second."""
    caplog.set_level(logging.INFO, "slipwave")
    told = []
    with progress("run", 200.0) as report:
        for seconds, done in ((1.0, 20.0), (3.0, 30.0), (9.9, 39.0), (11.0, 40.0), (20.9, 90.0), (21.0, 100.0), (30.9, 190.0)):
            now[0] = 100.0 + seconds
            report(done)
            told.append(" ".join(caplog.messages))
            caplog.clear()
    assert told == ["", "", "", "run: 20%, 80 s left", "", "run: 50%, 25 s left", ""]


def test_a_terminal_has_a_bar_once_patience_has_passed(now, monkeypatch):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    with progress("a [label]", 8.0) as report:
        now[0] = 101.9
        report(1.0)
        assert report._bar is None  # type: ignore[attr-defined]
        now[0] = 102.0
        report(2.0)
        report(6.0)
        bar = report._bar  # type: ignore[attr-defined]
        (task,) = bar.tasks
        assert ((task.total, task.completed, task.percentage), task.description) == ((8.0, 6.0, 75.0), r"a \[label]")
        assert bar.live.is_started
        assert bar.live.transient
    assert not bar.live.is_started
