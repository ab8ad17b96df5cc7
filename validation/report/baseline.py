"""The committed baseline, the numbers of an earlier full report: what has moved since, and what else makes a report red.

python -m validation.report.baseline reports        # take the numbers of reports/ as the new baseline
"""

import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from slipwave.errors import NumericsError
from slipwave.sources import ROOT
from validation.report.store import Stored, numbers_of
from validation.study import Number, Outcome
from validation.study.text import bare

FOLDER = ROOT / "reports" / "baseline"


class RedReport(NumericsError):
    """The report is whole, on `page`, but red: `lines` has one line for each reason."""

    def __init__(self, lines: list[str], page: Path) -> None:
        super().__init__(f"the report is red for {len(lines)} reason{'s' if len(lines) > 1 else ''}: see {page}")
        self.lines, self.page = lines, page


class Change(NamedTuple):
    """A number that moved by more than its tolerance; `before` or `now` is None where it is new or gone."""

    study: str
    name: str
    before: float | None
    now: float | None
    tolerance: float

    def __str__(self) -> str:
        now = "none" if self.now is None else f"{self.now:.9g}"
        return f"{self.study}: {bare(self.name)}: expected {self.before:.9g} within {self.tolerance:.0e}, found {now}"


def changes_since(stored: Stored, quick: bool, folder: Path = FOLDER) -> list[Change] | None:
    """What changed in a study since the baseline of a full report; None if it has none, or if the study failed. A number that a
    quick report leaves out is no change."""
    path = folder / f"{stored.name}.json"
    if stored.result is None or not path.exists():
        return None
    before, now = numbers_of(json.loads(path.read_text(encoding="utf-8"))), stored.result.numbers

    def change(name: str, number: Number) -> Change:
        """From the baseline to now."""
        old, new = (known[name].value if name in known else None for known in (before, now))
        return Change(stored.name, name, old, new, number.tolerance)

    changes = [change(name, number) for name, number in now.items() if name not in before]
    changes += [change(name, number) for name, number in before.items() if name not in now and not quick]
    both = {name: number for name, number in now.items() if name in before}
    return changes + [change(name, number) for name, number in both.items() if number.differs(before[name].value)]


def moved(stored: Stored, quick: bool) -> list[Change]:
    """Numbers that left their baseline; a new number has nothing to be compared with."""
    return [change for change in changes_since(stored, quick) or [] if change.before is not None]


def red_lines(studies: Sequence[Stored], quick: bool) -> list[str]:
    """One line for each study that failed, verdict that fails and number that left its baseline: which it is, what was expected
    and what was found."""
    lines = []
    for study in studies:
        lines += [f"{study.name}: failed: {study.error}"] if study.error else []
        for verdict in study.result.verdicts if study.result else ():
            if verdict.outcome is Outcome.FAIL:
                remark = f" ({verdict.remark})" if verdict.remark else ""
                lines.append(bare(f"{study.name}: {verdict.claim}: expected {verdict.expected}, found {verdict.ours}{remark}"))
        lines += map(str, moved(study, quick))
    return [" ".join(line.split()) for line in lines]


def take(out: Path, folder: Path = FOLDER) -> list[Path]:
    """Write the numbers stored under out/data as the baseline in `folder`; returns the files written."""
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for path in sorted(out.glob("data/*/result.json")):
        record = json.loads(path.read_text(encoding="utf-8"))
        if record["numbers"]:
            written.append(folder / f"{record['study']}.json")
            written[-1].write_text(json.dumps(record["numbers"], indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    return written


if __name__ == "__main__":
    print("\n".join(str(path) for path in take(Path(sys.argv[1]))))
