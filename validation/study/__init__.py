"""What a study is: one question, answered with tables, figures, verdicts and numbers. A study's file offers

    NAME      words joined by hyphens, as in `slipwave report --only NAME`
    QUESTION  one sentence
    SCENES    gallery names of the scenes it runs; their contents are part of the key under which its result is stored
    FILES     optional: files and folders of the checkout that it reads; part of that key too
    SECONDS   (quick, full) rough wall time, for the order (the longest begin first) and the time left
    TIMED     optional: True if it measures run times; such studies run alone, after all others
    run(budget) -> StudyResult

Texts may hold the small markup of `validation.study.text`: x_{sub}, 10^{-9}, *emphasis*, `code`.
"""

import math
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import TYPE_CHECKING, Protocol, TypeVar

from validation.study.model_table import ModelTable
from validation.study.text import Cell as Cell
from validation.study.text import around, minus

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

Item = TypeVar("Item")

_ROUNDING = 1e-11
"""Least tolerance of a number that states its error, relative: the rounding errors of an orbit, which another processor makes
anew; 2e-12 occurs (`reduced.orbit.periodic`)."""


class Outcome(StrEnum):
    """How a claim fared. A claim of the paper's that fails is a finding, and so is a promised speed that was not reached;
    any other promise of ours that fails is a failure."""

    PASS = "pass"
    FINDING = "finding"
    FAIL = "fail"


class Evidence(StrEnum):
    """Five kinds of evidence, never mixed: what a claim was compared with."""

    EXACT = "exact"
    SELF = "self-convergence"
    WITNESS = "independent witness"
    PAPER = "paper"
    ASYMPTOTIC = "asymptotics"


EXACT, SELF, WITNESS, PAPER, ASYMPTOTIC = Evidence


@dataclass(frozen=True)
class Budget:
    """How much a study may spend. `quick` asks for the cheap version; `report(share)` takes how far it is, 0 to 1."""

    quick: bool = False
    report: Callable[[float], None] = field(default=lambda share: None, compare=False)

    def each(self, items: Collection[Item], end: float = 1.0, begin: float = 0.0) -> Iterator[Item]:
        """The items of the study's part from the share `begin` to `end`; reports after each how far it is."""
        for count, item in enumerate(items, 1):
            yield item
            self.report(begin + (end - begin) * count / len(items))


RUN_TIMES = ("s", "ms", "μs", "of times")
"""Units of columns that hold run times, or ratios of run times; in sentences these stand between ~{ and }."""


@dataclass(frozen=True)
class Column:
    """Heading, unit and number format (a format spec such as ".7g"; empty for text) of a table's column."""

    title: str
    unit: str = ""
    format: str = ""

    @property
    def timed(self) -> bool:
        """Whether it holds run times or their ratios (by its unit): no two reports have the same."""
        return self.unit in RUN_TIMES


@dataclass(frozen=True)
class Table:
    """Rows under columns; the caption explains every symbol and the clock. `emphasis` lists rows printed bold."""

    name: str
    caption: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[Cell, ...], ...]
    emphasis: tuple[int, ...] = ()


_COLUMN = re.compile(r"(?P<title>.*?)(?: \[(?P<unit>[^]]*)\])?(?: (?P<format>\.\d+[efg%]))?")


def table(name: str, caption: str, heading: str, rows: Iterable[Iterable[Cell]], emphasis: Iterable[int] = ()) -> Table:
    """A Table whose columns stand in one line: title, unit in brackets and format, the last two only where there is one.

    "model | T [transits] .7g" has a column of text, and one of numbers with the unit "transits" and the format ".7g".
    """
    found = (_COLUMN.fullmatch(text) for text in heading.split(" | "))
    columns = tuple(Column(**match.groupdict(default="")) for match in found if match)
    return Table(name, caption, columns, tuple(tuple(row) for row in rows), tuple(emphasis))


@dataclass(frozen=True)
class Figure:
    """A picture drawn on demand by matplotlib, stored as SVG, PNG and CSV. A `lead` figure is shown at the top of the page; a
    `timed` one shows run times; `paper` names the figure of the paper that it draws again ("Fig 5"), and `carries` how the claims
    begin that it shows; a reader may `zoom` into its curves, and sees `beside` a point the nearest curve of that other figure,
    whose curves are called "T = ..., log10 r = ..."."""

    name: str
    caption: str
    draw: "Callable[[], Drawing]"
    lead: bool = False
    timed: bool = False
    paper: str = ""
    carries: tuple[str, ...] = ()
    zoom: bool = False
    beside: str = ""


@dataclass(frozen=True)
class Verdict:
    """One claim and one kind of evidence: what was expected, what was found (the same quantity), and the outcome.

    `size` and `limit`, in `unit` (none: a pure number), are one quantity as it was measured and as it is allowed: how far a
    number lies from another (`claim`) or from the middle of a range (`in_range`), what is asked over what was found (`at_least`),
    how many miss (`every`). Without them the claim is one of yes or no. `refuted` says what would refute the claim, where that is
    more than the opposite of what was expected. `id` is the verdict's name on the page and in files (`validation.study.names`).
    ValueError if it passes beyond its limit: then the two are not of one kind.
    """

    claim: str
    evidence: Evidence
    expected: str
    ours: str
    outcome: Outcome
    remark: str = ""
    size: float | None = None
    limit: float | None = None
    unit: str = ""
    refuted: str = ""
    id: str = ""

    def __post_init__(self) -> None:
        if self.outcome is Outcome.PASS and self.margin is not None and not self.margin <= 1.0 + _ROUNDING:
            raise ValueError(f"{self.claim}: holds, though {self.size:g} is more than {self.limit:g}")

    @property
    def margin(self) -> float | None:
        """The share of what is allowed that was found; None for a claim of yes or no."""
        return self.size / self.limit if self.size is not None and self.limit else None

    def with_margin(self, size: float, limit: float, unit: str = "") -> "Verdict":
        """The verdict with what was measured and what is allowed."""
        return replace(self, size=size if math.isfinite(size) else None, limit=limit, unit=unit)

    @property
    def timed(self) -> bool:
        """Whether a run time was judged (by its unit)."""
        return self.unit in RUN_TIMES

    @property
    def refutation(self) -> str:
        """What would refute the claim."""
        if self.refuted:
            return self.refuted
        itself = ", or agreement to the last bit: then a thing was compared with itself" if self.evidence is WITNESS else ""
        return f"anything but {self.expected}" + (itself if self.limit is not None else "")


@dataclass(frozen=True)
class Number:
    """A value that the committed baseline remembers; it has changed when it moves by more than `tolerance`, relative. `known` is
    the true value, if it is known, within `known_within`: a change is then for the better or for the worse (0 for an error of a
    computation). Where the value states its own error, `stated` makes the tolerance of it."""

    value: float
    tolerance: float = 1e-6
    known: float | None = None
    known_within: float = 0.0

    def differs(self, other: float) -> bool:
        """True if `other` is further away than the tolerance; two NaN are equal, and so are two equal infinities."""
        if math.isfinite(self.value) and math.isfinite(other):
            return abs(self.value - other) > self.tolerance * max(abs(self.value), abs(other))
        return self.value != other and not (math.isnan(self.value) and math.isnan(other))


def stated(value: float, error: float, known: float | None = None, known_within: float = 0.0) -> Number:
    """A number that states its own `error`: two results, each within its error of the truth, are at most two errors apart."""
    own = 2.0 * error / abs(value) if value else math.inf
    return Number(value, max(_ROUNDING, own), known, known_within)


@dataclass(frozen=True)
class Omission:
    """Something a reader might expect here and does not find, with the reason. `claims` begin the titles of the verdicts, of any
    study, that check it; a reason with numbers has one."""

    what: str
    why: str
    claims: tuple[str, ...] = ()


@dataclass(frozen=True)
class StudyResult:
    """All a study has to say; `answer` is one sentence that is true if no verdict fails, `conclusion` what may be said.
    `model_tables` compare all models at several places (`validation.study.model_table`)."""

    answer: str
    tables: tuple[Table, ...] = ()
    figures: tuple[Figure, ...] = ()
    verdicts: tuple[Verdict, ...] = ()
    notes: tuple[str, ...] = ()
    numbers: dict[str, Number] = field(default_factory=dict)
    omissions: tuple[Omission, ...] = ()
    model_tables: tuple[ModelTable, ...] = ()

    @property
    def conclusion(self) -> str:
        """The answer, or which claims fail: no study answers yes if a verdict fails."""
        failed = [verdict.claim for verdict in self.verdicts if verdict.outcome is Outcome.FAIL]
        if not failed:
            return self.answer
        return f"Not shown: {len(failed)} of {len(self.verdicts)} checks fail ({'; '.join(dict.fromkeys(failed))})."


class Study(Protocol):
    """The shape of a study's module."""

    NAME: str
    QUESTION: str
    SCENES: tuple[str, ...]
    SECONDS: tuple[float, float]

    def run(self, budget: Budget) -> StudyResult:
        """Answer the question within the budget."""


def judge(holds: bool, otherwise: Outcome = Outcome.FAIL) -> Outcome:
    """PASS if the claim holds, else `otherwise`."""
    return Outcome.PASS if holds else otherwise


def _otherwise(evidence: Evidence) -> Outcome:
    return Outcome.FINDING if evidence is PAPER else Outcome.FAIL


def claim(
    title: str,
    evidence: Evidence,
    ours: float,
    within: float,
    remark: str = "",
    shown: str = "",
    near: float = 0.0,
    unit: str = "",
) -> Verdict:
    """PASS if `ours` lies `within` so much of `near`: 0 for an error, 1 for a ratio. NaN does not pass, nor does an independent
    witness that agrees to the last bit: then a thing was compared with itself. A claim of the paper's that does not hold is a
    finding, no failure of this program. `shown` says more than the distance; it ends the remark."""
    size = abs(ours - near)
    holds = size < within and not (evidence is WITNESS and size == 0.0)
    outcome, known = judge(holds, _otherwise(evidence)), size if math.isfinite(size) else None
    expected, found = (f"{words} {unit}".strip() for words in around(near, ours, within))
    remark = "; ".join(filter(None, (remark, shown)))
    return Verdict(title, evidence, expected, found, outcome, remark, known, within, unit)


def at_least(title: str, evidence: Evidence, ours: float, least: float, remark: str = "", unit: str = "") -> Verdict:
    """PASS if `ours` reaches `least`, which is positive. A claim of the paper's that does not hold is a finding."""
    expected, found = around(0.0, ours, least)
    asked, shown = f"{expected.removeprefix('below ')} {unit}".strip() + " or more", f"{'−' * (ours < 0.0)}{found} {unit}".strip()
    share = least / ours if ours > 0.0 else math.inf
    return holding(title, evidence, asked, shown, share <= 1.0, remark, _otherwise(evidence)).with_margin(share, 1.0)


def in_range(
    title: str, evidence: Evidence, ends: tuple[float, float], ours: Sequence[float], remark: str = "", form: str = ".3g"
) -> Verdict:
    """PASS if all of `ours` lie between the `ends`; shown are the ends, the least and the largest in this `form`. A claim of the
    paper's that does not hold is a finding."""
    found, (middle, half) = (min(ours), max(ours)), (0.5 * (ends[0] + ends[1]), 0.5 * (ends[1] - ends[0]))
    words = (" to ".join(dict.fromkeys(format(one, form) for one in pair)) for pair in (ends, found))
    expected, shown = (minus(one).replace("%", " %") for one in words)
    off = max((abs(one - middle) for one in ours), key=lambda one: (math.isnan(one), one))
    return holding(title, evidence, expected, shown, off < half, remark, _otherwise(evidence)).with_margin(off, half)


def every(title: str, evidence: Evidence, held: int, of: int, remark: str = "", what: str = "") -> Verdict:
    """PASS if all of so many held, and there were any; `what` says what they are. A claim of the paper's that does not hold is
    a finding."""
    expected, ours = (f"{count} of {of} {what}".strip() for count in (of, held))
    return holding(title, evidence, expected, ours, held == of > 0, remark, _otherwise(evidence)).with_margin(of - held, 1.0)


def holding(
    title: str, evidence: Evidence, expected: str, ours: str, holds: bool, remark: str = "", otherwise: Outcome = Outcome.FAIL
) -> Verdict:
    """The verdict on a claim in words: PASS if it `holds`."""
    return Verdict(title, evidence, expected, ours, judge(holds, otherwise), remark)


def of_paper(title: str, expected: str, ours: str, holds: bool, remark: str = "", evidence: Evidence = PAPER) -> Verdict:
    """The verdict on a claim of the paper's in words: one that does not hold is a finding."""
    return holding(title, evidence, expected, ours, holds, remark, Outcome.FINDING)
