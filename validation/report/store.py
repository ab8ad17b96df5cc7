"""Results on disk: one folder per study, whole or absent, named by a key of everything that could change it."""

import hashlib
import json
import os
import shutil
from contextlib import suppress
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any, ClassVar

from pydantic import TypeAdapter

from slipwave.files import is_running
from slipwave.sources import program
from validation.chart.render import SUFFIXES, render
from validation.models.own import digests
from validation.report import RECORDED, Study, StudyResult
from validation.report.names import by_claim
from validation.report.sources import laws_of, packages_of, sources_of

_FORMAT = 7


@dataclass(frozen=True, kw_only=True)
class Picture:
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

    __pydantic_config__: ClassVar = RECORDED


@dataclass(frozen=True)
class StoredStudy:
    """A study for the page: its result read from disk, or the error that stopped it, without a result."""

    name: str
    question: str
    wall_seconds: float
    fresh: bool
    result: StudyResult = field(default_factory=lambda: StudyResult({}))
    figures: tuple[Picture, ...] = ()
    error: str = ""
    key: str = ""


_STORED = TypeAdapter(StoredStudy)


def study_key(study: Study, quick: bool) -> str:
    """Hash of all that the study's result depends on, with the user's own laws, and of its settings; comments and docstrings of
    programs are left out."""
    files = sources_of(study)
    settings = [f"{_FORMAT} {quick}", *packages_of(files), *digests(laws_of(files), []).values()]
    digest = hashlib.sha256(" ".join(settings).encode())
    for path in files:
        digest.update(path.name.encode())
        digest.update(program(path).encode() if path.suffix == ".py" else path.read_bytes())
    return digest.hexdigest()[:16]


def stored_result(folder: Path, study: Study, key: str) -> StoredStudy | None:
    """The study's stored result with its pictures, if it is complete and has the same key; else None."""
    own = folder / study.NAME
    try:
        record = json.loads((own / "result.json").read_bytes())
        whole = record.pop("digest") == _digest(record, own) and record["key"] == key
        return _STORED.validate_python(record) if whole else None
    except (OSError, ValueError, LookupError, TypeError, AttributeError, RecursionError):
        return None


def _digest(record: dict[str, Any], folder: Path) -> str:
    """Digest of a result without its own digest, and of its pictures in `folder`."""
    digest = hashlib.sha256(json.dumps(record, sort_keys=True).encode())
    for figure in record["figures"]:
        for suffix in SUFFIXES:
            digest.update((folder / (figure["name"] + suffix)).read_bytes())
    return digest.hexdigest()


def store_result(folder: Path, study: Study, key: str, result: StudyResult, wall_seconds: float) -> StoredStudy:
    """Write the result with its figures under folder/NAME, whole or not at all."""
    target = folder / study.NAME
    part = folder / f".{study.NAME}.{os.getpid()}"
    for left in folder.glob(f".{study.NAME}.*"):
        other = left.suffix[1:]  # a process; parts of this one are overwritten
        if not (other.isdecimal() and is_running(int(other)) and int(other) != os.getpid()):
            _remove(left)
    part.mkdir(parents=True)
    own: dict[str, Any] = {"study": study.NAME}
    whole = replace(
        result,
        figures=(),
        verdicts=by_claim(study.NAME, result.verdicts),
        tables=tuple(
            replace(table, id=f"{study.NAME}.{table.name}", csv=f"data/{study.NAME}/table-{table.name}.csv", **own)
            for table in result.tables
        ),  # a figure of the same name has its data in the same folder
        numbers={name: replace(number, id=f"{study.NAME}.{name}", name=name, **own) for name, number in result.numbers.items()},
    )
    try:
        pictures = []
        for figure in result.figures:
            told = vars(figure) | own | render(figure.draw(), part / figure.name, f"{study.NAME}-{figure.name}")
            told |= {"id": f"{study.NAME}.{figure.name}"}
            files = tuple(f"data/{study.NAME}/{figure.name}{suffix}" for suffix in SUFFIXES)
            pictures.append(Picture(files=files, **{name: fact for name, fact in told.items() if name != "draw"}))
        stored = StoredStudy(study.NAME, study.QUESTION, wall_seconds, False, whole, tuple(pictures), key=key)
        record = json.loads(json.dumps(asdict(stored), default=lambda value: value.item()))  # numbers of numpy as Python's
        digested = {"digest": _digest(record, part)} | record
        (part / "result.json").write_text(json.dumps(digested, indent=1) + "\n", encoding="utf-8")
        _remove(target)
        part.rename(target)
    finally:
        _remove(part)
    return replace(_STORED.validate_python(record), fresh=True)


def _remove(folder: Path) -> None:
    with suppress(FileNotFoundError):  # it is not there, or another process removes it too
        shutil.rmtree(folder)
