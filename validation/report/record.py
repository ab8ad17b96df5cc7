"""report.json: all that a report says, for programs. `slipwave schema --report` prints its JSON Schema, which is made from the
classes here.

Two reports of the same commit are the same but for run times. These are in `times`, in columns and figures whose `timed` is true,
and between ~{ and } in words; `tests.validation.without_times` takes them out.
"""

import math
import platform
from collections.abc import Sequence
from contextlib import suppress
from enum import StrEnum
from importlib import metadata
from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict
from pydantic.json_schema import GenerateJsonSchema

import slipwave
from slipwave.errors import SceneError
from slipwave.files import reason_of
from slipwave.sources import commit, source_digest
from validation.models.stopwatch import cores
from validation.report import Number, Omission, Table, Verdict
from validation.report.model_table import ModelTable
from validation.report.questions import question_of, tally
from validation.report.registered import study_called
from validation.report.store import Picture, StoredStudy
from validation.report.verdict import RECORDED, Real

NAME = "report.json"
FORMAT: Literal[1] = 1


class ReportPart(BaseModel):
    """A part of report.json. A later version may add keys."""

    model_config = RECORDED | ConfigDict(frozen=True)


class StudyRecord(ReportPart):
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


class AnswerRecord(ReportPart):
    """An answer to one of the page's questions."""

    question: str
    """Its anchor on the page."""
    study: str
    """The study that gives it."""
    text: str
    """A sentence or two, or the claims that fail."""
    verdicts: tuple[str, ...]
    """Ids of the verdicts that it rests on."""


class ModelTableRecord(ReportPart):
    """A table of all models at several values of the parameter; `costs` are run times."""

    id: str
    study: str
    table: ModelTable
    csv: str
    """Where it is as CSV, one line for each number, from the folder of this file; its column `cost` holds run times."""


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


class Change(ReportPart):
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


class Changes(ReportPart):
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


class Times(ReportPart):
    """All that differs between two reports of the same commit."""

    written: str
    """When, UTC."""
    seconds: dict[str, float]
    """Wall time by study; that of an earlier report where its result was still valid."""
    before: dict[str, float]
    """The same in the report that `changes` compares with; empty if that tells none."""
    machine: dict[str, str]


class Record(ReportPart):
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


def _processor() -> str:
    with suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or "unknown"


def record_of(studies: Sequence[StoredStudy], quick: bool, written: str) -> Record:
    """The report of the stored `studies`, in their order, on this machine, without comparison."""
    done = [(study.name, study.result) for study in studies if not study.error]
    packages = {name: metadata.version(name) for name in ("numpy", "scipy", "numba")}
    machine = {"platform": f"{platform.system()} {platform.machine()}", "processor": _processor(), "cores": str(cores())}
    return Record(
        format=FORMAT,
        quick=quick,
        versions={"slipwave": metadata.version("slipwave"), "Python": platform.python_version(), **packages},
        digests={"commit": commit(), "solver sources": source_digest(), "scene paper": slipwave.read("paper").digest},
        outcomes=tally(studies),
        studies=tuple(map(_study, studies)),
        answers=tuple(
            AnswerRecord(
                question=question_of(name),
                study=name,
                text=result.conclusion_of(answer),
                verdicts=tuple(verdict.id for verdict in result.proofs(answer)),
            )
            for name, result in done
            for answer in result.answers
        ),
        verdicts=tuple(verdict for _, result in done for verdict in result.verdicts),
        numbers=tuple(number for _, result in done for number in result.numbers.values()),
        tables=tuple(table for _, result in done for table in result.tables),
        model_tables=tuple(
            ModelTableRecord(
                id=f"models.{model_table.name}", study=name, table=model_table, csv=f"data/{name}/models-{model_table.name}.csv"
            )
            for name, result in done
            for model_table in result.model_tables
        ),
        figures=tuple(picture for study in studies for picture in study.figures),
        changes=Changes(since="", counts={}, listed=()),
        times=Times(written=written, seconds={study.name: study.wall_seconds for study in studies}, before={}, machine=machine),
    )


def _study(stored: StoredStudy) -> StudyRecord:
    result, scenes = stored.result, study_called(stored.name).SCENES
    return StudyRecord(
        name=stored.name,
        question=stored.question,
        answer=result.conclusion,
        notes=result.notes,
        omissions=result.omissions,
        scenes={scene: slipwave.read(scene).digest for scene in scenes},
        key=stored.key,
        error=stored.error,
    )


def text_of(report: Record) -> str:
    """The text of report.json."""
    return report.model_dump_json(indent=1) + "\n"


def read_report(where: Path, option: str = "--against") -> Record:
    """Read the report in the file `where`, or in report.json in the folder `where`. Raises SceneError, naming the option, if
    there is none."""
    path = where / NAME if where.is_dir() else where
    try:
        return Record.model_validate_json(path.read_bytes())
    except OSError as error:
        why = f"{reason_of(error)}; must be a {NAME}, or the folder of one, which `slipwave report` writes"
    except ValueError:
        why = f"is no {NAME} of format {FORMAT}, as `slipwave report` writes it and `slipwave schema --report` describes it"
    raise SceneError(f"{option} = {str(path)!r}: {why}")
