"""What makes a report red: a study that failed, a verdict that fails, a number that left its baseline."""

from collections.abc import Sequence
from pathlib import Path

from slipwave.errors import NumericsError
from validation.report import baseline
from validation.report.store import Stored
from validation.study import Outcome
from validation.study.text import bare


class RedReport(NumericsError):
    """The report is whole, on `page`, but red: `lines` has one line for each reason."""

    def __init__(self, lines: list[str], page: Path) -> None:
        super().__init__(f"the report is red for {len(lines)} reason{'s' if len(lines) > 1 else ''}: see {page}")
        self.lines, self.page = lines, page


def red_lines(studies: Sequence[Stored], quick: bool) -> list[str]:
    """One line for each reason, naming the study, the claim or number, what was expected and what was found."""
    lines = []
    for study in studies:
        if study.error:
            lines.append(f"{study.name}: failed: {study.error}")
        for verdict in study.result.verdicts if study.result else ():
            if verdict.outcome is Outcome.FAIL:
                found = f"expected {bare(verdict.expected)}, found {bare(verdict.ours)}"
                remark = f" ({bare(verdict.remark)})" if verdict.remark else ""
                lines.append(f"{study.name}: {bare(verdict.claim)}: {found}{remark}")
        lines += [_moved(change) for change in baseline.moved(study, quick)]
    return [" ".join(line.split()) for line in lines]


def _moved(change: baseline.Change) -> str:
    now = "none" if change.now is None else f"{change.now:.9g}"
    return f"{change.study}: {bare(change.name)}: expected {change.before:.9g} within {change.tolerance:.0e}, found {now}"
