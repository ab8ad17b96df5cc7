"""The study that runs the slow tests: reads pytest's record, and lets no failure through."""

import subprocess
import sys

import pytest

from validation.report.sources import sources_of
from validation.studies import load
from validation.studies.slow_verification import read_record, run, summarised
from validation.study import Budget, Outcome


@pytest.fixture
def record(tmp_path):
    """What pytest writes of a file with a test that passes, one that fails and one whose fixture breaks."""
    (tmp_path / "test_sample.py").write_text(
        "import pytest\n"
        "@pytest.fixture\ndef broken():\n    raise ValueError('no such grid')\n"
        "def test_good(): pass\ndef test_bad(): assert 1 == 2, 'one is not two'\ndef test_ugly(broken): pass\n"
    )
    path = tmp_path / "record.xml"
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", f"--junitxml={path}", str(tmp_path)]
    subprocess.run(command, cwd=tmp_path, capture_output=True, check=False)
    return path


def test_failures_and_errors_turn_the_verdict_red(record):
    tests = list(read_record(record))
    assert [test.name for test in tests] == ["test_good", "test_bad", "test_ugly"]
    assert [bool(test.fault) for test in tests] == [False, True, True]
    assert "one is not two" in tests[1].fault
    result = summarised(tests)
    assert [verdict.outcome for verdict in result.verdicts] == [Outcome.FAIL]
    assert "test_bad, test_ugly" in result.verdicts[0].remark
    assert summarised(tests[:1]).verdicts[0].outcome is Outcome.PASS


def test_quick_report_says_what_it_leaves_out():
    result = run(Budget(quick=True))
    assert result.omissions
    assert not result.verdicts


def test_a_changed_test_asks_for_a_new_run():
    assert "test_exact_waves.py" in {path.name for path in sources_of(load("slow-verification"))}
