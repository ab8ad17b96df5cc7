"""The seven questions of the page, and the answers of their studies."""

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any

from validation.report import Evidence, Omission, Outcome, Verdict
from validation.report.registered import STUDIES
from validation.report.store import StoredStudy

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


def question_of(study: str) -> str:
    """Anchor of the question that the study of this name answers; that of the checks if its line names none."""
    asked = STUDIES.get(study, "")
    return asked if asked in QUESTIONS else "trust"


def ask(studies: Sequence[StoredStudy], changed: str) -> Iterator[dict[str, Any]]:
    """All questions in display order: `name` and `title`, the `studies` that answer it, their `answers`, with reservations for
    failed checks and unfinished studies, and the verdicts that these rest on, `rests_on`, by study. Studies that no question
    names are listed with the checks. `changed` answers the last question."""
    known = {study.name: study for study in studies}
    own = [*(known[name] for name in STUDIES if name in known), *(study for study in studies if study.name not in STUDIES)]
    for name, title in QUESTIONS.items():
        mine = [study for study in own if question_of(study.name) == name]
        done = [(study, study.result) for study in mine if not study.error]
        said = [result.headline for _, result in done if not result.model_tables]  # the sentences of tables stand above all
        rests_on = [(study, result.proofs(next(iter(result.answers)))) for study, result in done if result.answers]
        if name == "paper":
            judged = [(study, [v for v in study.result.verdicts if v.evidence is Evidence.PAPER]) for study in studies]
            said = _of_paper([v for _, some in judged for v in some]) + said
            rests_on += [(study, tuple(some)) for study, some in judged if some and study not in mine]
        elif name == "trust":
            verdicts = verdicts_of(studies)
            kinds = [f"{sum(v.evidence is kind for v in verdicts)} {kind.value}" for kind in Evidence]
            said += [f"The {len(verdicts)} verdicts rest on six kinds of evidence: {', '.join(kinds)}."]
        elif name == "changed":
            said = [changed]
        failed = {study.name: tally([study])["fail"] for study in mine}
        doubts = [f"{count} check{'s' if count > 1 else ''} of `{study}` failed" for study, count in failed.items() if count]
        doubts += [f"`{study.name}` did not finish" for study in mine if study.error]
        answers = (said or ["Not computed in this report."]) + ([f"But: {'; '.join(doubts)}."] if doubts else [])
        yield {"name": name, "title": title, "studies": mine, "answers": answers, "rests_on": rests_on}


def verdicts_of(studies: Sequence[StoredStudy]) -> list[Verdict]:
    """All verdicts of the studies, in order."""
    return [verdict for study in studies for verdict in study.result.verdicts]


def tally(studies: Sequence[StoredStudy]) -> dict[str, int]:
    """Number of verdicts by outcome, and of failed studies."""
    counts = Counter(verdict.outcome.value for verdict in verdicts_of(studies))
    return {outcome.value: counts[outcome.value] for outcome in Outcome} | {"broken": sum(bool(study.error) for study in studies)}


def left_out(studies: Sequence[StoredStudy]) -> list[tuple[StoredStudy, Omission, list[Verdict], bool]]:
    """Omissions of the report: study, omission, verdicts that check its reason, and whether these are missing although the reason
    has numbers."""
    known, missing = verdicts_of(studies), []
    for study in studies:
        for omission in study.result.omissions:
            proofs = [verdict for verdict in known if omission.claims and verdict.claim.startswith(omission.claims)]
            missing.append((study, omission, proofs, not proofs and any(map(str.isdigit, omission.what + omission.why))))
    return missing


def _of_paper(judged: Sequence[Verdict]) -> list[str]:
    """How many of the verdicts on the paper's claims hold, and which do not."""
    if not judged:
        return []
    wrong = [verdict for verdict in judged if verdict.outcome is not Outcome.PASS]
    said = f"Of {len(judged)} checks against the paper’s claims, under all seven questions, {len(judged) - len(wrong)} hold"
    return [f"{said}; {len(wrong)} do not, and are listed first." if wrong else f"{said}."]
