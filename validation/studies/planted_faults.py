"""The planted faults: changes that make the program wrong, one at a time, and the test that notices each."""

import json
from pathlib import Path
from typing import Any

from slipwave.sources import ROOT
from validation.study import EXACT, Budget, Omission, StudyResult, Table, Verdict, every, table

NAME = "planted-faults"
QUESTION = "Does the test suite notice when the program is wrong?"
SCENES: tuple[str, ...] = ()
SECONDS = (0.1, 0.1)

RECORD = ROOT / "reports" / "baseline" / "faults.json"
FILES = (RECORD,)


def run(budget: Budget) -> StudyResult:
    """Show the last record of `make faults`; planting the faults again takes an hour and is not part of a report."""
    if not RECORD.is_file():
        return StudyResult(
            "Not answered in this report.", omissions=(Omission("The planted faults.", "No record of them is here."),)
        )
    faults: list[dict[str, Any]] = json.loads(RECORD.read_text(encoding="utf-8"))["faults"]
    survivors = [fault["name"] for fault in faults if not _is_caught(fault)]
    packages = list(dict.fromkeys(fault["room"] for fault in faults))
    return StudyResult(
        answer=f"{len(faults) - len(survivors)} of {len(faults)} planted faults are caught.",
        tables=(_table(faults),),
        verdicts=tuple(_verdict(package, [fault for fault in faults if fault["room"] == package]) for package in packages),
        notes=("`make faults` plants them again, one at a time, in a copy of the checkout.",),
    )


def _is_caught(fault: dict[str, Any]) -> bool:
    """Whether the check named by a fault notices it; another test may do so by chance."""
    return bool(fault["caught"] and fault["by_its_check"])


def _table(faults: list[dict[str, Any]]) -> Table:
    facts = ((fault, fault["where"].partition("::")[0], _test_in_words(fault.get("caught_by"))) for fault in faults)
    rows = ((file, fault["what"], fault["user"], test, float(fault["seconds"])) for fault, file, test in facts)
    caption = (
        "Every planted fault, the test that noticed it, and the time that this took (test and compilation, on a busy machine)."
    )
    survivors = (number for number, fault in enumerate(faults) if not _is_caught(fault))
    heading = "file | what is changed | what it would do to a user | caught by | time [s] .0f"
    return table("faults", caption, heading, rows, survivors)


def _test_in_words(test: str | None) -> str:
    """A test's name as the sentence that it is, and its file."""
    if not test:
        return "nothing"
    file, _, name = test.partition("::")
    return f"{name.removeprefix('test_').replace('_', ' ')} ({Path(file).name})"


def _verdict(package: str, faults: list[dict[str, Any]]) -> Verdict:
    survivors, total = [fault["name"] for fault in faults if not _is_caught(fault)], len(faults)
    remark = f"in `{package}`" + (f"; survives: {', '.join(survivors)}" if survivors else "")
    return every("Planted faults are caught by the checks that they name", EXACT, total - len(survivors), total, remark)
