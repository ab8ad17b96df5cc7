"""The studies that show the slow tests and the planted faults: no failure and no survivor gets through."""

import json
import subprocess
import sys

import pytest

from validation.report.sources import sources_of
from validation.studies import planted_faults, slow_verification, study_called
from validation.studies.slow_verification import read_record, summarised
from validation.study import Budget, Outcome
from validation.study.text import cell


@pytest.fixture
def record(tmp_path):
    """What pytest writes of a file with a test that passes, one that fails and one whose fixture breaks."""
    (tmp_path / "test_sample.py").write_text(
        "import pytest\n"
        "@pytest.fixture\ndef broken():\n    raise ValueError('no such grid')\n"
        "def test_good(): pass\ndef test_bad(): assert 1 == 2, 'one is not two'\ndef test_ugly(broken): pass\n"
        "def test_idle(): pytest.skip('no time')\n"
    )
    path = tmp_path / "record.xml"
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", f"--junitxml={path}", str(tmp_path)]
    subprocess.run(command, cwd=tmp_path, capture_output=True, check=False)
    return path


def test_failures_and_errors_turn_the_verdict_red(record):
    tests = list(read_record(record))
    assert [test.name for test in tests] == ["test_good", "test_bad", "test_ugly", "test_idle"]
    assert [bool(test.fault) for test in tests] == [False, True, True, True]
    assert "one is not two" in tests[1].fault
    result = summarised(tests)
    assert [verdict.outcome for verdict in result.verdicts] == [Outcome.FAIL]
    assert "test_bad, test_ugly, test_idle" in result.verdicts[0].remark
    assert summarised(tests[:1]).verdicts[0].outcome is Outcome.PASS
    table = result.tables[0]
    shown = [[cell(value, column.format) for value, column in zip(row, table.columns, strict=True)] for row in table.rows]
    assert [row[1:3] for row in shown] == [[test.name, "1"] for test in tests]
    cases = [test._replace(name=f"test_good[{case}]") for case, test in enumerate(tests[:1] * 3)]
    assert summarised(cases).tables[0].rows == ((tests[0].file, "test_good", 3, 3 * tests[0].seconds, "passed"),)


def test_a_changed_test_asks_for_a_new_run():
    names = {path.name for path in sources_of(study_called("slow-verification"))}
    assert {"test_interface_order.py", "test_convergence_studies.py", "grid_scenes.py", "system.py"} <= names


def test_a_run_without_tests_is_no_answer(monkeypatch, tmp_path):
    (tmp_path / "test_none.py").write_text("")
    monkeypatch.setattr(
        slow_verification,
        "_command",
        lambda record: [sys.executable, "-m", "pytest", "-q", f"--junitxml={record}", str(tmp_path)],
    )
    with pytest.raises(RuntimeError, match="did not run"):
        slow_verification.run(Budget(quick=False))


CAUGHT = {
    "name": "half-impedance",
    "where": "slipwave/scene/scene.py::Scene.impedance",
    "what": "half the impedance",
    "user": "periods 4 % long",
    "caught_by": "tests/slipwave/test_scene.py::test_impedance_of_two_slabs",
}
SURVIVES = CAUGHT | {"name": "late-nudge", "where": "reduced/delay/kernel.py::march_delay", "caught_by": ""}


@pytest.fixture
def fault_record(monkeypatch, tmp_path):
    path = tmp_path / "faults.json"
    monkeypatch.setattr(planted_faults, "RECORD", path)
    monkeypatch.setattr(planted_faults, "FILES", (path,))
    return path


def test_each_fault_has_its_row_and_each_room_its_verdict(fault_record):
    fault_record.write_text(json.dumps({"faults": [CAUGHT, SURVIVES, CAUGHT | {"name": "other"}]}))
    result = planted_faults.run(Budget())
    caught_by = "impedance of two slabs (test_scene.py)"
    assert result.tables[0].rows == (
        ("slipwave/scene/scene.py", "half the impedance", "periods 4 % long", caught_by),
        ("reduced/delay/kernel.py", "half the impedance", "periods 4 % long", "nothing"),
        ("slipwave/scene/scene.py", "half the impedance", "periods 4 % long", caught_by),
    )
    assert result.tables[0].emphasis == (1,)
    assert [(v.outcome, v.ours) for v in result.verdicts] == [(Outcome.PASS, "2 of 2"), (Outcome.FAIL, "0 of 1")]
    assert result.verdicts[1].remark == "in `reduced`; survives: late-nudge"
    assert result.answer == "2 of 3 planted faults are caught."
