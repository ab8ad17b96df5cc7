"""The report as a `Record`: made from stored results, written to a file, read back."""

from collections.abc import Sequence
from pathlib import Path

import slipwave
from slipwave.errors import SceneError
from slipwave.files import reason_of
from validation.report import StudyAnswer, StudyResult
from validation.report.model_table import ModelTable
from validation.report.questions import tally
from validation.report.record import (
    FORMAT,
    AnswerRecord,
    Changes,
    ModelTableRecord,
    Record,
    StudyRecord,
    Times,
)
from validation.report.registered import STUDIES, study_called
from validation.report.store import Stored

NAME = "report.json"
_DIGESTS = ("commit", "solver sources", "scene paper")
_MACHINE = ("platform", "processor", "cores")


def record_of(studies: Sequence[Stored], facts: dict[str, str], quick: bool, written: str) -> Record:
    """The report of the stored `studies`, in their order, without comparison; `facts` are those of
    `validation.report.provenance.machine_facts`."""
    done = [(study.name, study.result) for study in studies if study.result]
    machine = {key: facts[key] for key in _MACHINE}
    return Record(
        format=FORMAT,
        quick=quick,
        versions={key: value for key, value in facts.items() if key not in (*_DIGESTS, *_MACHINE)},
        digests={key: facts[key] for key in _DIGESTS},
        outcomes=tally(studies),
        studies=tuple(map(_study, studies)),
        answers=tuple(_answer(name, result, answer) for name, result in done for answer in result.answers),
        verdicts=tuple(verdict for _, result in done for verdict in result.verdicts),
        numbers=tuple(number for _, result in done for number in result.numbers.values()),
        tables=tuple(table for _, result in done for table in result.tables),
        model_tables=tuple(_models(name, table) for name, result in done for table in result.model_tables),
        figures=tuple(picture for study in studies for picture in study.pictures),
        changes=Changes(since="", counts={}, listed=()),
        times=Times(written=written, seconds={one.name: one.wall_seconds for one in studies}, before={}, machine=machine),
    )


def _study(stored: Stored) -> StudyRecord:
    result, scenes = stored.result, study_called(stored.name).SCENES
    return StudyRecord(
        name=stored.name,
        question=stored.question,
        answer=result.conclusion if result else "",
        notes=result.notes if result else (),
        omissions=result.omissions if result else (),
        scenes={scene: slipwave.read(scene).digest for scene in scenes},
        key=stored.key,
        error=stored.error,
    )


def _answer(study: str, result: StudyResult, answer: StudyAnswer) -> AnswerRecord:
    rests_on = tuple(verdict.id for verdict in result.proofs(answer))
    return AnswerRecord(question=STUDIES.get(study, "trust"), study=study, text=result.conclusion_of(answer), verdicts=rests_on)


def _models(study: str, table: ModelTable) -> ModelTableRecord:
    csv = f"data/{study}/models-{table.name}.csv"
    return ModelTableRecord(id=f"models.{table.name}", study=study, table=table, csv=csv)


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
