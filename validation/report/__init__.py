"""What a study is: one question, answered with tables, figures, verdicts and numbers. A study's file offers

    NAME      words joined by hyphens, as in `slipwave report --only NAME`
    QUESTION  one sentence
    SCENES    gallery names of the scenes it runs; their contents are part of the key under which its result is stored
    FILES     optional: files and folders of the checkout that it reads; part of that key too
    SECONDS   (quick, full) rough wall time, for the order (the longest begin first) and the time left
    TIMED     optional: True if it measures run times; such studies run alone, after all others
    run(budget) -> StudyResult

Texts may hold the small markup of `validation.report.text`: x_{sub}, 10^{-9}, *emphasis*, `code`.
"""

import math
import re
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import dataclass, field
from typing import ClassVar, Protocol, TypeAlias, TypeVar

from validation.chart import Chart
from validation.report.model_table import ModelTable
from validation.report.text import *  # noqa: F403
from validation.report.text import Cell, bare
from validation.report.verdict import *  # noqa: F403
from validation.report.verdict import RECORDED, ROUNDING, RUN_TIMES, Outcome, Real, Verdict

Item = TypeVar("Item")


@dataclass(frozen=True)
class Budget:
    """Budget of a study: whether a `quick` report is asked for; `report(share)` is called with the share done, 0 to 1."""

    quick: bool = False
    report: Callable[[float], None] = field(default=lambda share: None, compare=False)

    def plan(self, quick: Item, full: Item) -> Item:
        """The one of two values that is asked for; all numbers in which a quick and a full report differ are asked here."""
        return quick if self.quick else full

    def each(self, items: Collection[Item], end: float = 1.0, begin: float = 0.0) -> Iterator[Item]:
        """Yield the items of the part of the study from the share `begin` to `end`, reporting after each."""
        for count, item in enumerate(items, 1):
            yield item
            self.report(begin + (end - begin) * count / len(items))


@dataclass(frozen=True)
class Column:
    """Heading, unit and number format (a format spec such as ".7g"; empty for text) of a column."""

    title: str
    unit: str = ""
    format: str = ""
    timed: bool = False
    """Whether it holds run times or their ratios, which differ between reports."""

    __pydantic_config__: ClassVar = RECORDED


@dataclass(frozen=True)
class Table:
    """A table of the page, row by row; the caption explains every symbol and the clock. `emphasis` lists rows printed bold."""

    caption: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[Real | int | str | None, ...], ...]
    name: str = ""
    emphasis: tuple[int, ...] = ()
    id: str = ""
    study: str = ""
    csv: str = ""
    """Where the table is as CSV, from the folder of this file."""

    __pydantic_config__: ClassVar = RECORDED

    def __post_init__(self) -> None:
        """Raises ValueError for a row of more or fewer cells than there are columns."""
        if wrong := [row for row in self.rows if len(row) != len(self.columns)]:
            raise ValueError(f"the table {self.name!r} of {len(self.columns)} columns has the row {wrong[0]}")

    @property
    def sheet(self) -> Iterator[Iterable[Cell]]:
        """Its rows as in the file, the headings first: numbers with all their digits, words without markup. No two columns have
        the same heading: a repeated one is prefixed by the last unique one."""
        named = [bare(f"{column.title} [{column.unit}]" if column.unit else column.title) for column in self.columns]
        often, seen, owner, headings = Counter(named), Counter[str](), "", list[str]()
        for name in named:
            owner = name if often[name] == 1 else owner
            unique = name if often[name] == 1 or not owner else f"{owner}: {name}"
            seen[unique] += 1
            headings.append(unique if seen[unique] == 1 else f"{unique} {seen[unique]}")
        yield headings
        yield from ([bare(cell) if isinstance(cell, str) else cell for cell in row] for row in self.rows)


_COLUMN = re.compile(r"(?P<title>.*?)(?: \[(?P<unit>[^]]*)\])?(?: (?P<format>\.\d+[efg%]))?")


def table(name: str, caption: str, heading: str, rows: Iterable[Iterable[Cell]], emphasis: Iterable[int] = ()) -> Table:
    """A Table whose columns stand in one line: title, unit in brackets and format, the last two only where there is one.

    "model | T [transits] .7g" has a column of text, and one of numbers with the unit "transits" and the format ".7g".
    """
    matches = (_COLUMN.fullmatch(text) for text in heading.split(" | "))
    columns = tuple(Column(**match.groupdict(default=""), timed=match["unit"] in RUN_TIMES) for match in matches if match)
    return Table(caption, columns, tuple(tuple(row) for row in rows), name, tuple(emphasis))


@dataclass(frozen=True)
class Figure:
    """A chart made on demand, stored as SVG, PNG and CSV. A `lead` figure is shown at the top of the page; a
    `timed` one shows run times; `paper` names the figure of the paper that it redraws ("Fig 5"), and `carries` the beginnings of
    the claims that it shows; a reader may `zoom` into its curves; `beside` names another figure, with curves called "T = ...,
    log10 r = ...", of which the one nearest to the pointed orbit is shown."""

    name: str
    caption: str
    draw: Callable[[], Chart]
    lead: bool = False
    timed: bool = False
    paper: str = ""
    carries: tuple[str, ...] = ()
    zoom: bool = False
    beside: str = ""


@dataclass(frozen=True)
class Number:
    """A value that later reports are compared with. For a value with its own error, `stated` derives the tolerance."""

    value: Real
    tolerance: Real = 1e-6
    """Largest relative difference that is no change."""
    known: Real | None = None
    """The true value, where one is known: a change is then for the better or for the worse (0 for an error of a computation)."""
    known_within: Real = 0.0
    """Its error."""
    id: str = ""
    study: str = ""
    name: str = ""

    __pydantic_config__: ClassVar = RECORDED

    def differs(self, other: float) -> bool:
        """True if `other` is further away than the tolerance; two NaN are equal, and so are two equal infinities."""
        if math.isfinite(self.value) and math.isfinite(other):
            return abs(self.value - other) > self.tolerance * max(abs(self.value), abs(other))
        return self.value != other and not (math.isnan(self.value) and math.isnan(other))


def stated(value: float, error: float, known: float | None = None, known_within: float = 0.0) -> Number:
    """A number that states its own `error`: two results, each within its error of the truth, are at most two errors apart."""
    own = 2.0 * error / abs(value) if value else 1.0  # the mean with that of x is reached where |x| is two errors
    return Number(value, max(ROUNDING, own), known, known_within)


@dataclass(frozen=True)
class Omission:
    """Something that a reader might expect and does not find, with the reason. `claims`: beginnings of the titles of the
    verdicts, of any study, that check it; required for a reason with numbers."""

    what: str
    why: str
    claims: tuple[str, ...] = ()


Answers: TypeAlias = dict[str, tuple[str, ...]]
"""Sentences that answer a study's question -> what each rests on: beginnings of claims of the same study's verdicts. An answer is
true if none of these fails."""


@dataclass(frozen=True)
class StudyResult:
    """Result of a study. The first of its `answers` is the one to the page's question. `model_tables` compare all models at
    several values of a parameter (`validation.report.model_table`). Raises ValueError for an answer that rests on no verdict,
    though there are verdicts, or on a claim that none has; for a verdict that no answer cites; for two tables, or two
    figures, of the same name, which have the same file; and for a name that leads to another folder."""

    answers: Answers
    tables: tuple[Table, ...] = ()
    figures: tuple[Figure, ...] = ()
    verdicts: tuple[Verdict, ...] = ()
    notes: tuple[str, ...] = ()
    numbers: dict[str, Number] = field(default_factory=dict)
    omissions: tuple[Omission, ...] = ()
    model_tables: tuple[ModelTable, ...] = ()

    def __post_init__(self) -> None:
        claims = dict.fromkeys(verdict.claim for verdict in self.verdicts)
        for answer, rests_on in self.answers.items() if claims else ():
            unknown = [name for name in rests_on if not any(title.startswith(name) for title in claims)]
            if unknown or not rests_on:
                raise ValueError(f"the answer {answer!r} rests on {unknown or 'nothing'}; the claims are {[*claims]}")
        beginnings = tuple(name for rests_on in self.answers.values() for name in rests_on)
        if uncited := [name for name in claims if not name.startswith(beginnings)]:
            raise ValueError(f"no answer cites {uncited}")
        for kind, names in {
            "tables": [table.name for table in self.tables],
            "figures": [figure.name for figure in self.figures],
            "tables of models": [table.name for table in self.model_tables],
        }.items():
            if twice := [name for name, count in Counter(names).items() if count > 1]:
                raise ValueError(f"several {kind} have the name {twice[0]!r}")
            if elsewhere := [name for name in names if {"/", "\\"} & {*name}]:
                raise ValueError(f"{kind} are files, and none can have the name {elsewhere[0]!r}")

    def proofs(self, answer: str) -> tuple[Verdict, ...]:
        """The verdicts that the answer rests on."""
        return tuple(verdict for verdict in self.verdicts if verdict.claim.startswith(self.answers[answer]))

    def conclusion_of(self, answer: str) -> str:
        """The answer, or the claims that fail of those that it rests on."""
        proofs = [case for verdict in self.proofs(answer) for case in verdict.rows]
        failed = [case.claim for case in proofs if case.outcome is Outcome.FAIL]
        if not failed:
            return answer
        return f"Not shown: {len(failed)} of {len(proofs)} checks fail ({'; '.join(dict.fromkeys(failed))})."

    @property
    def headline(self) -> str:
        """The first answer, or the claims that fail."""
        return self.conclusion_of(next(iter(self.answers)))

    @property
    def conclusion(self) -> str:
        """All answers, or the claims that fail."""
        return " ".join(map(self.conclusion_of, self.answers))


class Study(Protocol):
    """The shape of a study's module."""

    __name__: str
    NAME: str
    QUESTION: str
    SCENES: tuple[str, ...]
    SECONDS: tuple[float, float]

    def run(self, budget: Budget) -> StudyResult:
        """Answer the question within the budget."""
