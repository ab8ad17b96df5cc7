"""The programme of planted faults: anchors hold, the original stays as it is, and a fault that no test notices survives."""

import ast
import json
from functools import cache

import pytest

from tests.faults.__main__ import put_on_record, try_fault
from tests.faults.planting import ROOMS, ROOT, AnchorError, Fault, read_faults
from tests.faults.trial import Copy

FAULTS = read_faults()


@cache
def functions_in(file):
    return {node.name for node in ast.walk(ast.parse((ROOT / file).read_bytes())) if isinstance(node, ast.FunctionDef)}


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name)
def test_every_fault_still_has_its_place_and_its_check(fault):
    text = (ROOT / fault.file).read_text(encoding="utf-8")
    assert fault.planted(text) != text
    assert fault.user
    assert fault.check
    for check in fault.check:
        file, _, name = check.partition("::")
        assert name.partition("[")[0] in functions_in(file) | {""}


def test_names_differ_and_every_room_has_faults():
    assert len({fault.name for fault in FAULTS}) == len(FAULTS) >= 80
    assert {fault.room for fault in FAULTS} == set(ROOMS)


SUM = "def total(values):\n    return sum(values)\n\n\ndef count(values):\n    return len(values)\n"
SETTINGS = "[tool.pytest.ini_options]\nmarkers = ['slow']\n"
TEST = "from slipwave.sums import total\n\ndef test_total():\n    assert total([1, 2]) == 3\n"


def fault(old, new, within="total"):
    return Fault("small", "slipwave/sums.py", within, old, new, "wrong sums", ("tests/test_sums.py",))


@pytest.fixture
def copy(tmp_path, monkeypatch):
    """A copy of a checkout of one module and one test."""
    root = tmp_path / "original"
    texts = {"slipwave/__init__.py": "", "slipwave/sums.py": SUM, "tests/test_sums.py": TEST, "pyproject.toml": SETTINGS}
    for name, text in texts.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text)
    monkeypatch.setattr("tests.faults.trial.tracked_files", lambda root: [p for p in root.rglob("*") if p.is_file()])
    return Copy(tmp_path / "work", root)


def test_a_fault_is_caught_by_what_it_breaks_and_the_copy_is_clean_again(copy, capsys):
    record = try_fault(fault("sum(values)", "max(values)"), copy)
    assert record["caught_by"] == "tests/test_sums.py::test_total"
    assert "caught   small  tests/test_sums.py::test_total\n         assert 2 == 3" in capsys.readouterr().out
    assert (copy.tree / "slipwave/sums.py").read_text() == SUM
    assert (copy.tree.parents[1] / "original/slipwave/sums.py").read_text() == SUM


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("sum(values)", "sum(list(values))", "its check stays green"),
        ("sum(values)", "sum(valves)", "by accident only: NameError in tests/test_sums.py::test_total"),
        ("return sum", "import nothing_of_that_name\n    return sum", "by accident only: ModuleNotFoundError"),
    ],
    ids=["equivalent", "crash", "import"],
)
def test_what_no_assertion_notices_survives(old, new, says, copy, capsys):
    record = try_fault(fault(old, new), copy)
    assert record["caught_by"] == ""
    printed = capsys.readouterr().out
    assert printed.startswith("SURVIVES small")
    assert says in printed


def test_a_check_that_fails_anyway_is_seen_and_one_without_an_end_is_no_assertion(copy):
    assert copy.run(["tests/test_sums.py"]).is_green
    with copy.with_text("tests/test_sums.py", TEST.replace("3", "4")):
        assert not copy.run(["tests/test_sums.py"]).is_green
    with copy.with_text("slipwave/sums.py", SUM.replace("return sum(values)", "while values:\n        pass")):
        found = copy.run(["tests/test_sums.py"], limit=3.0)
    assert (found.caught_by, found.trouble) == ("", "no end after 3 s")


def test_records_go_into_the_table_in_the_order_of_the_faults(tmp_path):
    """What is planted no more goes; what was not tried stays as it was."""
    table = tmp_path / "faults.json"
    first, second = FAULTS[0].name, FAULTS[1].name
    table.write_text(json.dumps({"faults": [{"name": second, "caught_by": "old"}, {"name": "gone", "caught_by": "old"}]}))
    put_on_record([{"name": first, "caught_by": "new"}], table)
    rows = json.loads(table.read_text())["faults"]
    assert rows == [{"name": first, "caught_by": "new"}, {"name": second, "caught_by": "old"}]


@pytest.mark.parametrize(
    ("old", "new", "within"),
    [
        ("absent", "0", "total"),
        ("values", "0", "total"),
        ("len(values)", "0", "total"),
        ("sum(values)", "0", "totals"),
        ("sum(values)", "0", "A.total"),
        ("return sum(values)", "return sum(values)  # all", "total"),
    ],
)
def test_a_place_that_is_not_there_once_or_a_change_of_nothing_is_refused(old, new, within):
    with pytest.raises(AnchorError):
        fault(old, new, within).planted(SUM)
