"""Whether the checks would see a mistake: planted faults that tests notice, and how often stated errors hold the truth."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from scipy.stats import binomtest

import slipwave
from validation.report import EXACT, Budget, Evidence, Number, Omission, StudyAnswer, StudyResult, Table, Verdict, every, holding
from validation.report import table as made

NAME = "checks"
QUESTION = "Would the checks see a mistake?"
SCENES: tuple[str, ...] = ()
SECONDS = (0.1, 0.1)

FAULTS = Path(slipwave.__file__).parents[1] / "reports" / "baseline" / "faults.json"
COVERAGE = FAULTS.with_name("coverage-record.json")
FILES = (FAULTS, COVERAGE)

ENOUGH = 0.95


class LeastHeld(NamedTuple):
    """A kind of stated error and the figure whose errors hold the truth least often: how many computations there are, how many of
    them hold it, the 95 % interval (Wilson) of that share, and the median of stated over true error."""

    kind: str
    figure: str
    many: int
    share: float
    low: float
    high: float
    width: float


def run(budget: Budget) -> StudyResult:
    """Show the records of `make faults` and of the coverage of stated errors, each of which takes longer than a report."""
    if not (FAULTS.is_file() and COVERAGE.is_file()):
        what, why = "Planted faults, and how often stated errors hold the truth.", "Their records are in a checkout only."
        return StudyResult(answers=(StudyAnswer("Not answered in this report."),), omissions=(Omission(what, why),))
    faults: list[dict[str, Any]] = json.loads(FAULTS.read_text(encoding="utf-8"))["faults"]
    kinds: dict[str, dict[str, Any]] = json.loads(COVERAGE.read_text(encoding="utf-8"))
    least = [min((_held(kind, figure, counts) for figure, counts in one["figures"].items()), key=lambda held: held.share)
             for kind, one in kinds.items()]  # fmt: skip
    worst, caught = min(least, key=lambda held: held.share), sum(map(bool, (fault["caught_by"] for fault in faults)))
    answer = (
        f"{caught} of {len(faults)} planted faults are noticed by the tests that they name. Stated errors hold the truth in at "
        f"least {100.0 * worst.share:.1f} of 100 computations of known truth, in each of {len(kinds)} kinds (the least: "
        f"{worst.kind})."
    )
    return StudyResult(
        answers=(StudyAnswer(answer, ("Planted faults", "Stated errors")),),
        tables=(_of_faults(faults), _of_errors(kinds, least)),
        verdicts=(*_caught(faults), *(_holds(held, Evidence(kinds[held.kind]["evidence"])) for held in least)),
        notes=("`make faults` plants them again, one at a time, in a copy of the checkout.",),
        numbers={f"held, {held.kind}": Number(held.share, 0.02) for held in least},
    )


def _held(kind: str, figure: str, counts: dict[str, Any]) -> LeastHeld:
    many, held = counts["number"], counts["held"]
    low, high = binomtest(held, many).proportion_ci(method="wilson")
    return LeastHeld(kind, figure, many, held / many, float(low), float(high), counts["width"])


def _of_faults(faults: list[dict[str, Any]]) -> Table:
    rows = [(fault["name"], fault["where"].partition("::")[0], _test_in_words(fault["caught_by"])) for fault in faults]
    caption = (
        "Planted faults: changes that make the program wrong, one at a time, and the test that notices each; what each "
        "would do to "
        "a user is in reports/baseline/faults.json."
    )
    survivors = (number for number, fault in enumerate(faults) if not fault["caught_by"])
    return made("faults", caption, "fault | changed | noticed in", rows, survivors)


def _test_in_words(test: str) -> str:
    return test.partition("::")[0].rpartition("/")[2] or "nothing"


def _caught(faults: list[dict[str, Any]]) -> Iterator[Verdict]:
    """A verdict for each package."""
    for package in dict.fromkeys(fault["where"].partition("/")[0] for fault in faults):
        mine = [fault for fault in faults if fault["where"].startswith(f"{package}/")]
        survivors = [fault["name"] for fault in mine if not fault["caught_by"]]
        remark = f"in `{package}`" + (f"; survives: {', '.join(survivors)}" if survivors else "")
        title = "Planted faults are noticed by the tests that they name"
        yield every(title, EXACT, len(mine) - len(survivors), len(mine), remark)


def _of_errors(kinds: dict[str, dict[str, Any]], least: list[LeastHeld]) -> Table:
    heading = (
        "kind | stated error | truth | figure | number .0f | held [%] .1f | at least [%] .1f | at most [%] .1f | bar/error .3g"
    )
    caption = (
        "Stated errors and true ones of random scenes (alike, unlike, layered, held by grips or machines, viscous): of each kind "
        "the figure whose errors hold the truth least often, with the 95 % interval (Wilson) of that share, and the median of "
        "stated over true error."
    )
    rows = [
        (
            *(one.kind, kinds[one.kind]["bar"], kinds[one.kind]["truth"], one.figure, one.many),
            *(100.0 * one.share, 100.0 * one.low, 100.0 * one.high, one.width),
        )
        for one in least
    ]
    return made("coverage", caption, heading, rows)


def _holds(held: LeastHeld, evidence: Evidence) -> Verdict:
    title, remark = "Stated errors hold the truth in at least 95 of 100 computations", f"{held.kind}: {held.figure}"
    expected, ours = "95.0 of 100 or more", f"{100.0 * held.share:.1f} of 100"
    verdict = holding(title, evidence, expected, ours, held.share >= ENOUGH, remark)
    return verdict.with_margin(1.0 - held.share, 1.0 - ENOUGH)
