"""What a study is, and what it shows itself with: bounded verdicts, marked-up text, drawings."""

from validation.study.result import (
    Budget,
    Cell,
    Column,
    Evidence,
    Figure,
    Number,
    Omission,
    Outcome,
    Study,
    StudyResult,
    Table,
    Verdict,
    judge,
    table,
)

__all__ = [
    "Budget",
    "Cell",
    "Column",
    "Evidence",
    "Figure",
    "Number",
    "Omission",
    "Outcome",
    "Study",
    "StudyResult",
    "Table",
    "Verdict",
    "judge",
    "table",
]
