"""report.json: all that a report says, for programs. `slipwave schema --report` prints its JSON Schema, which is made from the
classes here.

Two reports of the same commit are the same but for run times. These are in `times`, in columns and figures whose `timed` is true,
and between ~{ and } in words; `tests.validation.without_times` takes them out.
"""

import math
from enum import StrEnum
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict
from pydantic.json_schema import GenerateJsonSchema

from validation.report import Number, Omission, Table, Verdict
from validation.report.model_table import ModelTable
from validation.report.verdict import RECORDED, Real

FORMAT: Literal[1] = 1


class Part(BaseModel):
    """A part of report.json. A later version may add keys."""

    model_config = RECORDED | ConfigDict(frozen=True)


class StudyRecord(Part):
    """One question of the report."""

    name: str
    """Words joined by hyphens; `slipwave report --only NAME` runs it."""
    question: str
    answer: str
    """One sentence; it names the claims that fail, if any do."""
    notes: tuple[str, ...]
    omissions: tuple[Omission, ...]
    """What a reader might expect and does not find, with the reason."""
    scenes: dict[str, str]
    """Names of the gallery's scenes that it runs, with their digests."""
    key: str
    """Digest of all that the result depends on: programs, scenes, settings and packages."""
    error: str
    """Why it did not finish; empty if it did."""


class AnswerRecord(Part):
    """An answer to one of the page's questions."""

    question: str
    """Its anchor on the page."""
    study: str
    """The study that gives it."""
    text: str
    """A sentence or two, or the claims that fail."""
    verdicts: tuple[str, ...]
    """Ids of the verdicts that it rests on."""


class ModelTableRecord(Part):
    """A table of all models at several values of the parameter; `costs` are run times."""

    id: str
    study: str
    table: ModelTable
    csv: str
    """Where it is as CSV, one line for each number, from the folder of this file; its column `cost` holds run times."""


class Picture(Part):
    """A figure of the page."""

    id: str
    study: str
    name: str = ""
    caption: str
    files: tuple[str, ...]
    """Its picture as SVG and PNG, and its data, from the folder of this file."""
    timed: bool
    """Whether it shows run times."""
    title: str = ""
    description: str = ""
    """What it shows, in words."""
    panels: tuple[dict[str, Any], ...] = ()
    """Names, labels, scales and limits of its panels."""
    lead: bool = False
    """Whether it stands at the top of the page."""
    paper: str = ""
    """The figure of the paper that it redraws."""
    carries: tuple[str, ...] = ()
    """Beginnings of the claims that it shows."""
    zoom: bool = False
    beside: str = ""


class Word(StrEnum):
    """What became of a number, or of what a verdict found, since an earlier report. `better` and `worse` are said only where the
    truth is known or an error is measured; `moved` says that it left its bar where no better is known; `not comparable` is
    neutral."""

    BETTER = "better"
    SAME = "same"
    MOVED = "moved"
    WORSE = "worse"
    NEW = "new"
    GONE = "gone"
    NOT_COMPARABLE = "not comparable"


class Change(Part):
    """A number or a verdict, in an earlier report and now."""

    id: str
    study: str
    name: str
    """Of the number, or the verdict's claim."""
    kind: Literal["number", "verdict"]
    before: Real | str | None
    """A value, or the outcome of a verdict that changed its outcome; null where it is new."""
    now: Real | str | None
    """The same now; null where it is gone."""
    bar: Real
    """The largest difference that is no change."""
    word: Word
    why: str
    """Why it cannot be compared."""

    @property
    def over(self) -> float:
        """By how many bars it moved; infinite where that is no number."""
        if isinstance(self.before, float) and isinstance(self.now, float) and self.bar > 0.0:
            distance = abs(self.now - self.before) / self.bar
            return distance if math.isfinite(distance) else math.inf
        return math.inf


class Changes(Part):
    """What became of every number and verdict since an earlier report."""

    since: str
    """Which report that is."""
    counts: dict[Word, int]
    """How many numbers and verdicts there are of each word."""
    listed: tuple[Change, ...]
    """All but those that are the same; those that moved by the most bars first."""

    def of(self, *words: Word) -> list[Change]:
        """Those that are listed under these words."""
        return [change for change in self.listed if change.word in words]


class Times(Part):
    """All that differs between two reports of the same commit."""

    written: str
    """When, UTC."""
    seconds: dict[str, float]
    """Wall time by study; that of an earlier report where its result was still valid."""
    before: dict[str, float]
    """The same in the report that `changes` compares with; empty if that tells none."""
    machine: dict[str, str]


class Record(Part):
    """A whole report: of every study, or of those that were asked for and stored."""

    format: Literal[1]
    quick: bool
    """Whether this is the cheap version of every study."""
    versions: dict[str, str]
    """Program, Python and packages."""
    digests: dict[str, str]
    """Commit, sources of the solvers, and the paper's scene."""
    outcomes: dict[str, int]
    """How many verdicts of each outcome, and how many studies did not finish (`broken`)."""
    studies: tuple[StudyRecord, ...]
    answers: tuple[AnswerRecord, ...] = ()
    verdicts: tuple[Verdict, ...]
    numbers: tuple[Number, ...]
    tables: tuple[Table, ...]
    model_tables: tuple[ModelTableRecord, ...]
    figures: tuple[Picture, ...]
    changes: Changes
    times: Times


def report_schema() -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of report.json."""
    return {"$schema": GenerateJsonSchema.schema_dialect} | Record.model_json_schema(mode="serialization")
