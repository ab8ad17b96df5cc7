"""The seven questions of the page, and the answers of their studies."""

from collections.abc import Sequence
from typing import NamedTuple

from validation.report import Evidence, Omission, Outcome, Verdict
from validation.report.registered import STUDIES
from validation.report.store import Stored

QUESTIONS = {
    "which": "Which model may I use?",
    "cost": "What does an answer cost?",
    "exact": "Is the exact solution exact?",
    "begin": "Where does stick-slip begin, and what comes after?",
    "paper": "What of the paper holds?",
    "trust": "Can I trust the checks?",
    "changed": "What changed?",
}
"""Anchor of a question, which its studies name (`validation.report.registered.STUDIES`), and its text."""


class Asked(NamedTuple):
    """A question with the studies of this report that answer it; its answers, and the verdicts that these rest on, by study."""

    name: str
    title: str
    studies: list[Stored]
    answers: list[str]
    rests_on: list[tuple[Stored, tuple[Verdict, ...]]]


def ask(studies: Sequence[Stored], changed: str) -> list[Asked]:
    """All questions with their studies, in display order; studies that no question names are listed with the checks. `changed`
    answers the last question."""
    known = {study.name: study for study in studies}
    own = [*(known[name] for name in STUDIES if name in known), *(study for study in studies if study.name not in STUDIES)]
    return [
        _asked(name, [study for study in own if STUDIES.get(study.name, "trust") == name], studies, changed) for name in QUESTIONS
    ]


def _asked(name: str, mine: list[Stored], studies: Sequence[Stored], changed: str) -> Asked:
    """The answers of its studies, with reservations: failed checks and unfinished studies."""
    done = [(study, study.result) for study in mine if study.result]
    said = [result.headline for _, result in done if not result.model_tables]  # the sentences of tables stand above all questions
    rests_on = [(study, result.proofs(result.answers[0])) for study, result in done if result.answers]
    if name == "paper":
        judged = [(study, tuple(v for v in verdicts_of([study]) if v.evidence is Evidence.PAPER)) for study in studies]
        said = _of_paper([v for _, some in judged for v in some]) + said
        rests_on += [(study, some) for study, some in judged if some and study not in mine]
    elif name == "trust":
        verdicts = verdicts_of(studies)
        kinds = [f"{sum(v.evidence is kind for v in verdicts)} {kind.value}" for kind in Evidence]
        said += [f"The {len(verdicts)} verdicts rest on six kinds of evidence: {', '.join(kinds)}."]
    elif name == "changed":
        said = [changed]
    doubts = [
        f"{len(failed)} check{'s' if len(failed) > 1 else ''} of `{study.name}` failed"
        for study in mine
        if (failed := [verdict for verdict in verdicts_of([study]) if verdict.outcome is Outcome.FAIL])
    ]
    doubts += [f"`{study.name}` did not finish" for study in mine if study.error]
    said = (said or ["Not computed in this report."]) + ([f"But: {'; '.join(doubts)}."] if doubts else [])
    return Asked(name, QUESTIONS[name], mine, said, rests_on)


def verdicts_of(studies: Sequence[Stored]) -> list[Verdict]:
    """All verdicts of the studies that finished, in order."""
    return [verdict for study in studies if study.result for verdict in study.result.verdicts]


def tally(studies: Sequence[Stored]) -> dict[str, int]:
    """Number of verdicts by outcome, and of failed studies."""
    verdicts = verdicts_of(studies)
    counts = {outcome.value: sum(v.outcome is outcome for v in verdicts) for outcome in Outcome}
    return counts | {"broken": sum(study.result is None for study in studies)}


def left_out(studies: Sequence[Stored]) -> list[tuple[Stored, Omission, list[Verdict], bool]]:
    """Omissions of the report: study, omission, verdicts that check its reason, and whether these are missing although the reason
    has numbers."""
    known, found = verdicts_of(studies), []
    for study in studies:
        for one in study.result.omissions if study.result else ():
            proofs = [verdict for verdict in known if one.claims and verdict.claim.startswith(one.claims)]
            found.append((study, one, proofs, not proofs and any(map(str.isdigit, one.what + one.why))))
    return found


def _of_paper(judged: Sequence[Verdict]) -> list[str]:
    """How many of the verdicts on the paper's claims hold, and which do not."""
    if not judged:
        return []
    wrong = [verdict for verdict in judged if verdict.outcome is not Outcome.PASS]
    said = f"Of {len(judged)} checks against the paper’s claims, under all seven questions, {len(judged) - len(wrong)} hold"
    return [f"{said}; {len(wrong)} do not, and are listed first." if wrong else f"{said}."]
