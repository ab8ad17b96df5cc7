"""The study that shows the planted faults: a survivor is red, and the record is part of its key."""

import json

import pytest

from validation.report import store
from validation.studies import planted_faults
from validation.study import Budget, Outcome

CAUGHT = {
    "name": "half-impedance",
    "room": "slipwave",
    "where": "slipwave/scene/scene.py::Scene.impedance",
    "what": "half the impedance",
    "user": "periods 4 % long",
    "caught": True,
    "caught_by": "tests/slipwave/test_scene.py::test_impedance_of_two_slabs",
    "by_its_check": True,
    "seconds": 1.25,
}
SURVIVES = {
    "name": "late-nudge",
    "room": "reduced",
    "where": "reduced/delay/kernel.py::march_delay",
    "what": "a late nudge",
    "user": "every run begins late",
    "caught": False,
    "says": "stays green",
    "seconds": 180.0,
}


@pytest.fixture
def record(monkeypatch, tmp_path):
    path = tmp_path / "faults.json"
    monkeypatch.setattr(planted_faults, "RECORD", path)
    monkeypatch.setattr(planted_faults, "FILES", (path,))
    return path


def test_each_fault_has_its_row_and_each_room_its_verdict(record):
    record.write_text(json.dumps({"faults": [CAUGHT, SURVIVES, CAUGHT | {"name": "other"}]}))
    result = planted_faults.run(Budget())
    caught_by = "impedance of two slabs (test_scene.py)"
    assert result.tables[0].rows == (
        ("slipwave/scene/scene.py", "half the impedance", "periods 4 % long", caught_by, 1.25),
        ("reduced/delay/kernel.py", "a late nudge", "every run begins late", "nothing", 180.0),
        ("slipwave/scene/scene.py", "half the impedance", "periods 4 % long", caught_by, 1.25),
    )
    assert result.tables[0].emphasis == (1,)
    assert [(v.outcome, v.ours) for v in result.verdicts] == [(Outcome.PASS, "2 of 2"), (Outcome.FAIL, "0 of 1")]
    assert result.verdicts[1].remark == "in `reduced`; survives: late-nudge"
    assert result.answer == "2 of 3 planted faults are caught."


def test_a_fault_that_only_another_test_catches_is_red(record):
    record.write_text(json.dumps({"faults": [CAUGHT, CAUGHT | {"name": "by-chance", "by_its_check": False}]}))
    result = planted_faults.run(Budget())
    assert [(v.outcome, v.ours, v.remark) for v in result.verdicts] == [
        (Outcome.FAIL, "1 of 2", "in `slipwave`; survives: by-chance")
    ]
    assert (result.tables[0].emphasis, result.answer) == ((1,), "1 of 2 planted faults are caught.")


def test_a_new_record_is_a_new_key(record):
    keys = [store.study_key(planted_faults, False)]
    for faults in ([CAUGHT], [SURVIVES]):
        record.write_text(json.dumps({"faults": faults}))
        keys.append(store.study_key(planted_faults, False))
    assert len(set(keys)) == 3
