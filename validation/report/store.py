"""Results on disk: one folder per study, whole or absent, named by a key of everything that could change it."""

import hashlib
import json
import os
import shutil
from contextlib import suppress
from dataclasses import asdict, dataclass, field, fields, is_dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

from pydantic import TypeAdapter

from slipwave.files import is_running
from slipwave.sources import program
from validation.chart.render import SUFFIXES, render
from validation.report import RECORDED, Study, StudyResult
from validation.report.names import by_claim
from validation.report.sources import packages_of, sources_of

_FORMAT = 6
_PARTS: dict[str, Any] = {part.name: part.type for part in fields(StudyResult) if part.name != "figures"}
"""The stored parts of a result, with their types."""
_OF_FIGURE = ("name", "caption", "lead", "timed", "paper", "carries", "zoom", "beside")


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
class Stored:
    """A study for the page: its result read from disk, or the error that stopped it, without a result."""

    name: str
    question: str
    wall_seconds: float
    fresh: bool
    result: StudyResult = field(default_factory=lambda: StudyResult({}))
    pictures: tuple[Picture, ...] = ()
    error: str = ""
    key: str = ""


def study_key(study: Study, quick: bool) -> str:
    """Hash of all that the study's result depends on and of its settings; comments and docstrings of programs are left out."""
    files = sources_of(study)
    digest = hashlib.sha256(f"{_FORMAT} {quick} {' '.join(packages_of(files))}".encode())
    for path in files:
        digest.update(path.name.encode())
        digest.update(program(path).encode() if path.suffix == ".py" else path.read_bytes())
    return digest.hexdigest()[:16]


def stored_result(folder: Path, study: Study, key: str) -> Stored | None:
    """The study's stored result with its pictures, if it is complete and has the same key; else None."""
    own = folder / study.NAME
    try:
        record = json.loads((own / "result.json").read_bytes())
        if not isinstance(record, dict) or record.pop("digest", "") != _digest(record, own) or record["key"] != key:
            return None
    except (OSError, ValueError, LookupError, TypeError, RecursionError):
        return None
    return _stored(study, record)


def _digest(record: dict[str, Any], folder: Path) -> str:
    """Digest of a result without its own digest, and of its pictures in `folder`."""
    digest = hashlib.sha256(json.dumps(record, sort_keys=True).encode())
    for figure in record["figures"]:
        for suffix in SUFFIXES:
            digest.update((folder / (figure["name"] + suffix)).read_bytes())
    return digest.hexdigest()


def store_result(folder: Path, study: Study, key: str, result: StudyResult, wall_seconds: float) -> Stored:
    """Write the result with its figures under folder/NAME, whole or not at all."""
    target = folder / study.NAME
    part = folder / f".{study.NAME}.{os.getpid()}"
    for left in folder.glob(f".{study.NAME}.*"):
        other = left.suffix[1:]  # a process; parts of this one are overwritten
        if not (other.isdecimal() and is_running(int(other)) and int(other) != os.getpid()):
            _remove(left)
    part.mkdir(parents=True)
    try:
        figures = []
        for figure in result.figures:
            words = render(figure.draw(), part / figure.name, f"{study.NAME}-{figure.name}")
            figures.append({name: getattr(figure, name) for name in _OF_FIGURE} | words)
        record = _record(study, key, result, wall_seconds) | {"figures": figures}
        whole = {"digest": _digest(record, part)} | record
        (part / "result.json").write_text(json.dumps(whole, indent=1) + "\n", encoding="utf-8")
        _remove(target)
        part.rename(target)
    finally:
        _remove(part)
    return replace(_stored(study, record), fresh=True)


def _remove(folder: Path) -> None:
    with suppress(FileNotFoundError):  # it is not there, or another process removes it too
        shutil.rmtree(folder)


def _record(study: Study, key: str, result: StudyResult, wall_seconds: float) -> dict[str, Any]:
    record = {"study": study.NAME, "question": study.QUESTION, "key": key, "wall_seconds": wall_seconds}
    own: dict[str, Any] = {"study": study.NAME}
    whole = replace(
        result,
        verdicts=by_claim(study.NAME, result.verdicts),
        tables=tuple(
            replace(one, id=f"{study.NAME}.{one.name}", csv=f"data/{study.NAME}/table-{one.name}.csv", **own)
            for one in result.tables
        ),  # a figure of the same name has its data in the same folder
        numbers={name: replace(one, id=f"{study.NAME}.{name}", name=name, **own) for name, one in result.numbers.items()},
    )
    parts = {name: getattr(whole, name) for name in _PARTS}
    plain: dict[str, Any] = json.loads(json.dumps(record | parts, default=_plain))
    return plain


def _plain(value: Any) -> Any:
    """A record as a dict, a number of numpy as Python's."""
    return asdict(value) if is_dataclass(value) and not isinstance(value, type) else value.item()


def _stored(study: Study, record: dict[str, Any]) -> Stored:
    """Inverse of `_record`."""
    result = StudyResult(**{name: TypeAdapter(kind).validate_python(record[name]) for name, kind in _PARTS.items()})
    pictures = TypeAdapter(tuple[Picture, ...]).validate_python(
        [
            figure
            | {"id": f"{study.NAME}.{name}", "study": study.NAME}
            | {"files": [f"data/{study.NAME}/{name}{suffix}" for suffix in SUFFIXES]}
            for figure in record["figures"]
            for name in [figure["name"]]
        ]
    )
    return Stored(study.NAME, study.QUESTION, record["wall_seconds"], False, result, pictures, key=record["key"])
