"""The tests that are too slow for every commit, run from the checkout."""

import subprocess
import sys
import tempfile
from collections.abc import Iterator
from itertools import groupby
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

from slipwave.sources import ROOT
from validation.measure.stopwatch import cores
from validation.study import EXACT, SELF, Budget, Cell, Omission, StudyResult, Verdict, every, table

NAME = "slow-verification"
QUESTION = "Do the verification tests pass that are too slow for every commit?"
SCENES: tuple[str, ...] = ()
SECONDS = (0.1, 250.0)

_IS_CHECKOUT = (ROOT / "pyproject.toml").is_file() and (ROOT / "tests").is_dir()
FILES = (ROOT / "tests", ROOT / "slipwave" / "gallery") if _IS_CHECKOUT else ()

_TESTED = (0, 1)  # exit statuses of pytest after running tests: all passed, some failed


class Tested(NamedTuple):
    """One test: the file it is in, its name, its seconds, and the first line of its failure (empty if it passed)."""

    file: str
    name: str
    seconds: float
    fault: str

    @property
    def function(self) -> str:
        """The test's name without its case."""
        return self.name.partition("[")[0]


def run(budget: Budget) -> StudyResult:
    """Run the tests in a separate process (full report only)."""
    if budget.quick or not _IS_CHECKOUT:
        why = "In the full report only." if _IS_CHECKOUT else "The tests are not installed with the package; a checkout has them."
        return StudyResult("Not answered in this report.", omissions=(Omission("The verification tests marked as slow.", why),))
    with tempfile.TemporaryDirectory() as folder:
        record = Path(folder) / "tests.xml"
        ended = subprocess.run(_command(record), cwd=ROOT, capture_output=True, text=True, check=False)
        if ended.returncode not in _TESTED or not record.exists():
            raise RuntimeError(f"the tests did not run: {(ended.stdout + ended.stderr).strip()[-300:]}")
        tests = sorted(read_record(record))  # side by side they end in any order
    return summarised(tests)


def summarised(tests: list[Tested]) -> StudyResult:
    """Table of the tests and one verdict per file."""
    faults = sum(bool(test.fault) for test in tests)
    caption = "Every test that is marked as slow, with all its cases; its docstring says what it requires of the models."
    rows = (_row(file, name, list(cases)) for (file, name), cases in groupby(tests, lambda test: (test.file, test.function)))
    return StudyResult(
        answer=f"{len(tests) - faults} of {len(tests)} pass.",
        tables=(table("tests", caption, "file | test | cases .0f | time [s] .1f | outcome", rows),),
        verdicts=tuple(_verdict(file, [t for t in tests if t.file == file]) for file in dict.fromkeys(t.file for t in tests)),
    )


def _row(file: str, function: str, cases: list[Tested]) -> tuple[Cell, ...]:
    faulty = [f"{test.name}: {test.fault}" for test in cases if test.fault]
    return file, function, len(cases), sum(test.seconds for test in cases), "; ".join(faulty) or "passed"


def _verdict(file: str, tests: list[Tested]) -> Verdict:
    faulty, total = [test.name for test in tests if test.fault], len(tests)
    evidence, remark = SELF if "order" in file else EXACT, f"`{file}`" + (f": {', '.join(faulty)}" if faulty else "")
    return every("Slow verification tests pass", evidence, total - len(faulty), total, remark)


def _command(record: Path) -> list[str]:
    shared = ["-n", str(cores()), "--dist", "worksteal"]  # the other studies end long before these tests
    chosen = ["-q", "-m", "slow", "-p", "no:cacheprovider"]
    return [sys.executable, "-m", "pytest", *chosen, *shared, f"--junitxml={record}", "tests"]


def read_record(path: Path) -> Iterator[Tested]:
    """The tests of a JUnit file as pytest writes it."""
    for case in ElementTree.parse(path).getroot().iter("testcase"):
        file = case.get("classname", "").replace(".", "/") + ".py"
        bad = next((found for kind in ("failure", "error", "skipped") if (found := case.find(kind)) is not None), None)
        fault = "" if bad is None else (bad.get("message") or "failed").splitlines()[0]
        yield Tested(file, case.get("name", ""), float(case.get("time", "0")), fault)
