"""The study that shows the planted faults and the coverage of stated errors: no survivor and no small error gets by."""

import json

import pytest

from validation.report import Budget, Outcome
from validation.studies import checks

CAUGHT = {
    "name": "half-impedance",
    "where": "slipwave/scene/scene.py::Scene.impedance",
    "user": "periods 4 % long",
    "caught_by": "tests/slipwave/test_scene.py::test_impedance_of_two_slabs",
}
SURVIVES = CAUGHT | {"name": "late-nudge", "where": "reduced/delay/kernel.py::march_delay", "caught_by": ""}


@pytest.fixture
def shown(monkeypatch, tmp_path):
    """The study on these records."""

    def run(faults, **held):
        figures = {figure: {"number": 100, "held": count, "width": 3.0} for figure, count in held.items()}
        kinds = {"means": {"bar": "margin", "truth": "more cycles", "evidence": "self-convergence", "figures": figures}}
        for name, record in (("FAULTS", {"faults": faults}), ("COVERAGE", kinds)):
            monkeypatch.setattr(checks, name, tmp_path / name)
            (tmp_path / name).write_text(json.dumps(record))
        return checks.run(Budget())

    return run


def test_a_fault_that_survives_is_red(shown):
    found = shown([CAUGHT, SURVIVES, CAUGHT | {"name": "other"}], period=99)
    assert [(one.outcome, one.ours, one.remark) for one in found.verdicts[:2]] == [
        (Outcome.PASS, "2 of 2", "in `slipwave`"),
        (Outcome.FAIL, "0 of 1", "in `reduced`; survives: late-nudge"),
    ]
    assert found.tables[0].rows[1] == ("reduced/delay/kernel.py", "periods 4 % long", "nothing")
    assert found.tables[0].emphasis == (1,)
    assert shown([CAUGHT], period=99).conclusion.startswith("1 of 1 planted faults are noticed")


@pytest.mark.parametrize(("held", "outcome"), [(94, Outcome.FAIL), (95, Outcome.PASS)])
def test_94_of_100_are_too_few_though_chance_may_have_made_them_so(shown, held, outcome):
    found = shown([CAUGHT], period=99, drop=held)
    assert found.verdicts[-1].outcome is outcome
    assert found.numbers["held, means"].value == held / 100
    assert found.tables[1].rows[0][3:5] == ("drop", 100)
    assert found.tables[1].rows[0][6:8] == pytest.approx({94: (87.5, 97.2), 95: (88.8, 97.8)}[held], abs=0.1)


def test_without_its_records_it_says_why(monkeypatch, tmp_path):
    monkeypatch.setattr(checks, "FAULTS", tmp_path / "none.json")
    found = checks.run(Budget())
    assert (found.verdicts, len(found.omissions), found.conclusion) == ((), 1, "Not answered in this report.")
