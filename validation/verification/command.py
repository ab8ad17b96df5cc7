"""`slipwave verify`: Judge a scheme, a law or a scene by the report's rows: orders, step limit, energy, noise, agreement."""

import re
import xml.etree.ElementTree as xml
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar, Self

import slipwave
from slipwave.errors import SceneError
from slipwave.files import whole_or_absent
from slipwave.friction import LAWS
from slipwave.friction.check import LawError
from slipwave.friction.own import load_laws
from slipwave.input.assemble import SceneSource, tables_of
from slipwave.scene import Scene
from validation.chart import Chart
from validation.commands.options import ModelOptions, command, model_option
from validation.commands.result import Output, Result, aligned
from validation.data.datasets import Dataset
from validation.models.by_name import GRIDS, grid_of, parse, resolve
from validation.models.own import load_families
from validation.models.progress import log, progress
from validation.report import EXACT, Outcome, Verdict, bare, holding
from validation.report.names import with_names
from validation.verification.of_family import rows_of_family, rows_on_scene, starts_smoothly
from validation.verification.of_law import rows_of_law

_USUAL, _SCENE = "dg:7", "paper"
_ROWS = 16  # about so many, for the bar
_COUNTED = {"missed": Outcome.FAIL, "not_decided": Outcome.OPEN}


class VerifyOptions(ModelOptions):
    """Options of `slipwave.verify`."""

    EXAMPLES: ClassVar = (
        "slipwave verify paper",
        "slipwave verify --model sbp:6",
        "slipwave verify --family scheme.py --junit verify.xml",
        "slipwave verify --law law.py --json",
    )
    DETAILS: ClassVar = (
        "With SCENE: a full wave (--model, default dg:7) against the delay system on it. With --family: each member that the "
        "file declares, or --model. With --law: each law that the file registers, in SCENE (default paper). With --model alone: "
        "that member. Exit status 3 if a row is missed."
    )

    model: str = model_option(f"{_USUAL}, or each member that --family declares")

    def load_own(self) -> Self:
        """Does nothing: the user's files are loaded when they are judged."""
        return self


_UNCHANGED = VerifyOptions()


class VerifyResult(Result):
    """The `rows` on a `subject`."""

    OUTPUTS: ClassVar = (Output("--junit", (".xml",), "save_junit", "write the rows as JUnit XML, for a CI"),)

    subject: str
    rows: tuple[Verdict, ...]
    notes: tuple[str, ...] = ()

    @property
    def facts(self) -> dict[str, Any]:
        """As `Result`."""
        rows = [
            {"id": row.id, "claim": bare(row.claim), "evidence": row.evidence.value, "expected": bare(row.expected),
             "found": bare(row.ours), "size": row.found, "limit": row.limit, "outcome": row.outcome.value,
             "remark": bare(row.remark)}
            for row in self.rows
        ]  # fmt: skip
        counts = {name: sum(row.outcome is kind for row in self.rows) for name, kind in _COUNTED.items()}
        return {"subject": self.subject, "rows": rows, **counts, "notes": list(self.notes)}

    def lines(self, summary: Mapping[str, Any]) -> Iterator[str]:
        """A line for each row, then how many hold."""
        rows = [[f"{row['outcome']}  {row['claim']}", row["expected"], row["found"]] for row in summary["rows"]]
        for line, row in zip(aligned(["", "expected", "found"], rows), [None, *summary["rows"]], strict=True):
            yield line
            if row:
                yield f"      {row['remark']}"
        yield ""
        yield from (f"note: {note}" for note in self.notes)
        held, unknown = sum(row.outcome is Outcome.PASS for row in self.rows), summary["not_decided"]
        yield f"{self.subject}: {held} of {len(self.rows)} rows hold" + (f", {unknown} not decided" if unknown else "")

    def save_junit(self, path: str | Path) -> None:
        """Write a test case for each row. Raises SceneError if the file cannot be written."""
        failures = str(self.summary["missed"])
        suite = xml.Element("testsuite", name=f"slipwave verify {self.subject}", tests=str(len(self.rows)), failures=failures)
        for row in self.rows:
            case = xml.SubElement(suite, "testcase", classname="slipwave.verify", name=row.id)
            said = bare(row.line)
            if row.outcome is Outcome.FAIL:
                xml.SubElement(case, "failure", message=said)
            xml.SubElement(case, "system-out").text = said
        with whole_or_absent(Path(path)) as temporary:
            xml.ElementTree(suite).write(temporary, encoding="utf-8", xml_declaration=True)

    @property
    def dataset(self) -> Dataset:
        """There is none."""
        raise SceneError("verify: its rows are in .rows and .summary; there is no dataset")

    def chart(self) -> Chart:
        """There is none."""
        raise SceneError("verify: its rows are in .rows and .summary; there is no figure")


@command
def verify(source: "SceneSource | None" = None, options: VerifyOptions = _UNCHANGED) -> VerifyResult:
    """Judge a full wave, a friction law or a scene by the report's rows: orders with confidence intervals from a smooth start,
    step limit, energy balance, noise, agreement with the delay system; derivatives, steady state and evolution of a law.

    Raises SceneError for wrong input; NumericsError, with the rows as its `result`, if one is missed.
    """
    subject, rows, notes = _judged(source, options)
    judged = []
    with progress(f"verify {subject}", _ROWS) as report:
        for row in rows:
            judged.append(row)
            report(min(len(judged), _ROWS - 1))
        report(_ROWS)
    missed = [f"{bare(row.claim)} ({_where(row)})" for row in judged if row.outcome is Outcome.FAIL]
    failed = f"verify {subject}: {len(missed)} of {len(judged)} rows are missed: {'; '.join(missed)}"
    for row in judged:
        if row.outcome is Outcome.OPEN:
            log.info("not decided: %s (%s): %s", bare(row.claim), _where(row), bare(row.ours))
    return VerifyResult(subject, with_names("verify", judged), notes, failed=failed if missed else "")


def _where(row: Verdict) -> str:
    """The member and the scene of a row: the first clauses of its remark."""
    return ", ".join(re.split("[,;:] ", bare(row.remark))[:2])


def _judged(source: "SceneSource | None", options: VerifyOptions) -> tuple[str, Iterable[Verdict], tuple[str, ...]]:
    """Text of the subject; its rows, computed on iteration; notes on omissions."""
    families = [] if options.family is None else load_families(options.family)
    if options.law is not None:
        if options.model != "auto":
            raise SceneError("--model: leave it out; the rows of a law have their own")
        return _of_laws(source or _SCENE, options, options.law)
    if source is not None:
        if families and options.model == "auto":
            raise SceneError("--model: missing; must name the member of --family that computes the scene")
        scene = options.scene_of(source)
        model = _member(_USUAL if options.model == "auto" else options.model)
        refusal = grid_of(model)[0].refusal(scene)
        if refusal:
            raise SceneError(f"model = {model!r}: cannot do {refusal} (scene {scene.name!r})")
        left = (
            ()
            if starts_smoothly(scene)
            else ("psi is compared after a nudge at constant V only: here the ledger alone is judged",)
        )
        return f"scene {scene.name} with {model}", rows_on_scene(model, scene), left
    options.require_unset((), "without SCENE a scheme is judged on scenes of its rows")
    if options.model != "auto":
        models = [_member(options.model)]
    elif families:
        waves = [family for family in families if family in GRIDS]  # those of a ladder, else the usual member
        models = [family.called(number) for family in waves for number in family.ladder or [family.usual]]
        if not models:
            raise SceneError(f"--family = {str(options.family)!r}: declares no full wave; compare and bench judge a reduction")
    else:
        raise SceneError("verify: give a SCENE, --family FILE.py, --law FILE.py or --model NAME")
    return ", ".join(models), (row for model in models for row in rows_of_family(model)), ()


def _of_laws(source: SceneSource, options: VerifyOptions, path: Path) -> tuple[str, Iterable[Verdict], tuple[str, ...]]:
    """As `_judged` for the laws that a file registers; a refused law is a failed row."""
    try:
        names = load_laws(path)
    except LawError as error:
        return f"law {path}", [holding("Its functions pass the check of registration", EXACT, "no error", str(error), False)], ()
    settings = [options.settings] if isinstance(options.settings, str) else [*options.settings]
    laws = {name: replace(options, settings=[*settings, f"interface.law={name}"]) for name in names}
    scenes = {name: own.scene_of(_without_others(slipwave.read(source), name)) for name, own in laws.items()}
    rows = (row for name, scene in scenes.items() for row in rows_of_law(name, scene))
    return f"law {', '.join(names)}", rows, ()


def _without_others(scene: Scene, name: str) -> dict[str, Any]:
    """The tables of a scene without parameters that the law `name` lacks; those of that law that are not there keep their
    defaults."""
    tables, others = tables_of(scene)[1], {*scene.law._fields} - {*LAWS[name].parameters._fields}
    return tables | {"interface": {key: value for key, value in tables["interface"].items() if key not in others}}


def _member(model: str) -> str:
    """The full name of a member on a grid. Raises SceneError for another model."""
    family, number = parse(resolve(model, slipwave.read(_SCENE))[0])
    if family not in GRIDS:
        waves = ", ".join(grid.pattern for grid in GRIDS)
        raise SceneError(f"model = {model!r}: has no grid, so no order and no step limit to verify; models that do: {waves}")
    return family.called(family.default if number is None else number)
