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
    """Show the last record of `make faults`; planting the faults again takes minutes and is not part of a report."""
    if not RECORD.is_file():
        return StudyResult(
            "Not answered in this report.", omissions=(Omission("The planted faults.", "No record of them is here."),)
        )
    faults: list[dict[str, Any]] = json.loads(RECORD.read_text(encoding="utf-8"))["faults"]
    survivors = [fault["name"] for fault in faults if not fault["caught_by"]]
    packages = list(dict.fromkeys(_package(fault) for fault in faults))
    return StudyResult(
        answer=f"{len(faults) - len(survivors)} of {len(faults)} planted faults are caught.",
        tables=(_table(faults),),
        verdicts=tuple(_verdict(package, [fault for fault in faults if _package(fault) == package]) for package in packages),
        notes=("`make faults` plants them again, one at a time, in a copy of the checkout.",),
    )


def _package(fault: dict[str, Any]) -> str:
    return str(fault["where"].partition("/")[0])


def _table(faults: list[dict[str, Any]]) -> Table:
    rows = (
        (fault["where"].partition("::")[0], fault["what"], fault["user"], _test_in_words(fault["caught_by"])) for fault in faults
    )
    caption = "Every planted fault and the test that noticed it."
    survivors = (number for number, fault in enumerate(faults) if not fault["caught_by"])
    heading = "file | what is changed | what it would do to a user | caught by"
    return table("faults", caption, heading, rows, survivors)


def _test_in_words(test: str) -> str:
    """A test's name as the sentence that it is, and its file."""
    if not test:
        return "nothing"
    file, _, name = test.partition("::")
    return f"{name.removeprefix('test_').replace('_', ' ')} ({Path(file).name})"


def _verdict(package: str, faults: list[dict[str, Any]]) -> Verdict:
    survivors, total = [fault["name"] for fault in faults if not fault["caught_by"]], len(faults)
    remark = f"in `{package}`" + (f"; survives: {', '.join(survivors)}" if survivors else "")
    return every("Planted faults are caught by the checks that they name", EXACT, total - len(survivors), total, remark)
