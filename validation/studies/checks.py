"""Whether the checks would see a mistake: planted faults that tests notice, and how often stated errors hold the truth."""

import json
from pathlib import Path
from typing import Any

from scipy.stats import binomtest

import slipwave
from validation.report import (
    EXACT,
    Budget,
    Evidence,
    Number,
    Omission,
    StudyResult,
    Table,
    Verdict,
    Verdicts,
    every,
    holding,
    table,
)

NAME = "checks"
QUESTION = "Would the checks see a mistake?"
SCENES: tuple[str, ...] = ()
SECONDS = (0.1, 0.1)

FAULTS = Path(slipwave.__file__).parents[1] / "reports" / "baseline" / "faults.json"
COVERAGE = FAULTS.with_name("coverage-record.json")
FILES = (FAULTS, COVERAGE)

ENOUGH = 0.95


def run(budget: Budget) -> StudyResult:
    """Show the records of `make faults` and of the coverage of stated errors, each of which takes longer than a report."""
    if not (FAULTS.is_file() and COVERAGE.is_file()):
        what, why = "Planted faults, and how often stated errors hold the truth.", "Their records are in a checkout only."
        return StudyResult(
            answers={
                "Not answered in this report.": (),
            },
            omissions=(Omission(what, why),),
        )
    faults: list[dict[str, Any]] = json.loads(FAULTS.read_text(encoding="utf-8"))["faults"]
    kinds: dict[str, dict[str, Any]] = json.loads(COVERAGE.read_text(encoding="utf-8"))
    shares, held, verdicts = _stated_errors(kinds)
    worst = min(shares, key=shares.__getitem__)
    caught = sum(bool(fault["caught_by"]) for fault in faults)
    answer = (
        f"{caught} of {len(faults)} planted faults are noticed by the tests that they name. Stated errors hold the truth in at "
        f"least {100.0 * shares[worst]:.1f} of 100 computations of known truth, in each of {len(kinds)} kinds (the "
        f"least: {worst})."
    )
    return StudyResult(
        answers={
            answer: ("Planted faults", "Stated errors"),
        },
        tables=(_of_faults(faults), held),
        verdicts=(*_caught(faults), *verdicts),
        notes=("`make faults` plants them again, one at a time, in a copy of the checkout.",),
        numbers={f"held, {kind}": Number(share, 0.02) for kind, share in shares.items()},
    )


def _of_faults(faults: list[dict[str, Any]]) -> Table:
    rows = [
        (fault["name"], fault["where"].partition("::")[0], Path(fault["caught_by"].partition("::")[0]).name or "nothing")
        for fault in faults
    ]
    caption = (
        "Planted faults: changes that make the program wrong, one at a time, and the test that notices each; what each "
        "would do to "
        "a user is in reports/baseline/faults.json."
    )
    survivors = (number for number, fault in enumerate(faults) if not fault["caught_by"])
    return table("faults", caption, "fault | changed | noticed in", rows, survivors)


def _caught(faults: list[dict[str, Any]]) -> Verdicts:
    """A verdict for each package."""
    for package in dict.fromkeys(fault["where"].partition("/")[0] for fault in faults):
        mine = [fault for fault in faults if fault["where"].startswith(f"{package}/")]
        survivors = [fault["name"] for fault in mine if not fault["caught_by"]]
        remark = f"in `{package}`" + (f"; survives: {', '.join(survivors)}" if survivors else "")
        title = "Planted faults are noticed by the tests that they name"
        yield every(title, EXACT, len(mine) - len(survivors), len(mine), remark)


def _stated_errors(kinds: dict[str, dict[str, Any]]) -> tuple[dict[str, float], Table, list[Verdict]]:
    """Of each kind of stated error the figure whose errors hold the truth least often: their share, and whether it suffices."""
    shares, rows, verdicts = dict[str, float](), [], []
    for kind, row in kinds.items():
        figure, counts = min(row["figures"].items(), key=lambda pair: pair[1]["held"] / pair[1]["number"])
        held, many = counts["held"], counts["number"]
        span = binomtest(held, many).proportion_ci(method="wilson")
        shares[kind] = share = held / many
        percent = [100.0 * share, 100.0 * span.low, 100.0 * span.high]
        rows.append((kind, row["bar"], row["truth"], figure, many, *percent, counts["width"]))
        verdict = holding(
            "Stated errors hold the truth in at least 95 of 100 computations",
            Evidence(row["evidence"]),
            "95.0 of 100 or more",
            f"{100.0 * share:.1f} of 100",
            share >= ENOUGH,
            f"{kind}: {figure}",
        )
        verdicts.append(verdict.with_margin(1.0 - share, 1.0 - ENOUGH))
    heading = (
        "kind | stated error | truth | figure | number .0f | held [%] .1f | at least [%] .1f | at most [%] .1f | bar/error .3g"
    )
    caption = (
        "Stated errors and true ones of random scenes (alike, unlike, layered, held by grips or machines, viscous): of each kind "
        "the figure whose errors hold the truth least often, with the 95 % interval (Wilson) of that share, and the median of "
        "stated over true error."
    )
    return shares, table("coverage", caption, heading, rows), verdicts
