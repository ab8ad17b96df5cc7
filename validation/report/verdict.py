"""Verdicts: one claim, one kind of evidence, what was expected, what was found, and the outcome."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Annotated, ClassVar, TypeAlias

from pydantic import ConfigDict, WithJsonSchema

from validation.report.text import around, minus

ROUNDING = 1e-11
"""Least relative tolerance of a number that states its error: the rounding errors of an orbit, which differ between processors;
2e-12 occurs (`reduced.orbit.periodic`)."""


class Outcome(StrEnum):
    """Outcome of a claim. A failing claim of the paper is a finding, and so is a promised speed that was not reached; any other
    failing promise of ours is a failure. `OPEN`: what was measured is too uncertain to tell (`verify` alone)."""

    PASS = "pass"
    FINDING = "finding"
    FAIL = "fail"
    OPEN = "not decided"


class Evidence(StrEnum):
    """Six kinds of evidence, never mixed: what a claim was compared with. A witness is of ours, another program is not."""

    EXACT = "exact"
    SELF = "self-convergence"
    WITNESS = "independent witness"
    PROGRAM = "another program"
    PAPER = "paper"
    ASYMPTOTIC = "asymptotics"


EXACT, SELF, WITNESS, PROGRAM, PAPER, ASYMPTOTIC = Evidence

RUN_TIMES = ("s", "ms", "μs", "of times")
"""Units of columns that hold run times, or ratios of run times; in sentences these stand between ~{ and }."""


RECORDED = ConfigDict(use_attribute_docstrings=True, ser_json_inf_nan="strings", json_schema_serialization_defaults_required=True)
"""How a part of a study's result stands in report.json, as it is."""

Real = Annotated[float, WithJsonSchema({"anyOf": [{"type": "number"}, {"enum": ["NaN", "Infinity", "-Infinity"]}]})]
"""A number; what JSON lacks is written as a word."""


@dataclass(frozen=True)
class Verdict:
    """One claim, one kind of evidence, and how it fared; of several cases, how the worst of them did.

    `found` and `limit`: distance of a number from another (`claim`) or from the middle of a range (`in_range`), ratio of required
    to found (`at_least`), number of misses (`every`). Raises ValueError for a pass beyond the limit: then `found` and `limit` are
    different quantities.
    """

    claim: str
    evidence: Evidence
    expected: str
    """What was expected, in words."""
    ours: str
    """What was found, in words."""
    outcome: Outcome
    """`finding`: a published claim, or a promised speed, that does not hold; `fail`: anything else that does not."""
    remark: str = ""
    found: Real | None = None
    """What was measured, as a number of the same quantity as `limit`; null where the claim is one in words."""
    limit: Real | None = None
    """`found` lies below it if the claim holds."""
    unit: str = ""
    id: str = ""
    """Stable from report to report; the anchor of its row on the page."""
    study: str = ""
    cases: tuple["Verdict", ...] = ()
    """The same claim for several grids, models or scenes, each named by its remark."""

    __pydantic_config__: ClassVar = RECORDED

    def __post_init__(self) -> None:
        if self.outcome is Outcome.PASS and self.margin is not None and not self.margin <= 1.0 + ROUNDING:
            raise ValueError(f"{self.claim}: holds, though {self.found:g} is more than {self.limit:g}")

    @property
    def margin(self) -> float | None:
        """Ratio of `found` to `limit`; None for a claim of yes or no."""
        return self.found / self.limit if self.found is not None and self.limit else None

    def with_margin(self, size: float, limit: float, unit: str = "") -> "Verdict":
        """The verdict with measured `size` and allowed `limit`."""
        return replace(self, found=size if math.isfinite(size) else None, limit=limit, unit=unit)

    @property
    def rows(self) -> tuple["Verdict", ...]:
        """Its cases; of a claim with a single case the verdict itself."""
        return self.cases or (self,)

    @property
    def line(self) -> str:
        """What was expected and what was found, in one line."""
        return f"{self.claim}: expected {self.expected}, found {self.ours}{f' ({self.remark})' if self.remark else ''}"

    @property
    def timed(self) -> bool:
        """Whether a run time was judged (by its unit)."""
        return self.unit in RUN_TIMES


Verdicts: TypeAlias = Iterator[Verdict]
"""What a part of a study judges, in order."""


def judge(holds: bool, evidence: Evidence = EXACT) -> Outcome:
    """PASS if the claim holds; else a finding for a claim of the paper, and for any other a failure."""
    return Outcome.PASS if holds else Outcome.FINDING if evidence is PAPER else Outcome.FAIL


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
    """PASS if `ours` lies `within` this distance of `near`: 0 for an error, 1 for a ratio. NaN fails, and so does an independent
    check that agrees to the last bit, which was compared with itself. A claim of the paper that does not hold is a finding, no
    failure of this program. `shown`: text appended to the remark."""
    size = abs(ours - near)
    holds = size < within and not (evidence in (WITNESS, PROGRAM) and size == 0.0)
    outcome, known = judge(holds, evidence), size if math.isfinite(size) else None
    expected, measured = (f"{words} {unit}".strip() for words in around(near, ours, within))
    remark = "; ".join(filter(None, (remark, shown)))
    return Verdict(title, evidence, expected, measured, outcome, remark, known, within, unit)


def at_least(title: str, evidence: Evidence, ours: float, least: float, remark: str = "") -> Verdict:
    """PASS if `ours` >= `least` > 0. A claim of the paper that does not hold is a finding."""
    expected, measured = around(0.0, ours, least)
    asked, shown = f"{expected.removeprefix('below ')} or more", f"{'−' * (ours < 0.0)}{measured}"
    share = least / ours if ours > 0.0 else math.inf
    return holding(title, evidence, asked, shown, share <= 1.0, remark).with_margin(share, 1.0)


def in_range(
    title: str, evidence: Evidence, ends: tuple[float, float], ours: Sequence[float], remark: str = "", form: str = ".3g"
) -> Verdict:
    """PASS if all of `ours` lie between the `ends`; shown are the ends, the least and the largest in this `form`. A claim of the
    paper's that does not hold is a finding."""
    extremes, (middle, half) = (min(ours), max(ours)), (0.5 * (ends[0] + ends[1]), 0.5 * (ends[1] - ends[0]))
    words = (" to ".join(dict.fromkeys(format(number, form) for number in pair)) for pair in (ends, extremes))
    expected, shown = (minus(text).replace("%", " %") for text in words)
    off = max((abs(number - middle) for number in ours), key=lambda number: (math.isnan(number), number))
    return holding(title, evidence, expected, shown, off < half, remark).with_margin(off, half)


def every(title: str, evidence: Evidence, held: int, of: int, remark: str = "", what: str = "") -> Verdict:
    """PASS if `held` equals `of` > 0; `what`: the name of the cases. A claim of the paper that does not hold is a finding."""
    expected, ours = (f"{count} of {of} {what}".strip() for count in (of, held))
    return holding(title, evidence, expected, ours, held == of > 0, remark).with_margin(of - held, 1.0)


def holding(
    title: str,
    evidence: Evidence,
    expected: str,
    ours: str,
    holds: bool,
    remark: str = "",
    otherwise: Outcome | None = None,
) -> Verdict:
    """The verdict on a claim in words: PASS if it `holds`; if not, `otherwise`, or as `judge` says."""
    missed = None if holds else otherwise
    return Verdict(title, evidence, expected, ours, missed or judge(holds, evidence), remark)
