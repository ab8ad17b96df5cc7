"""The seven questions of the page, and the answers of their studies."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from validation.report.store import Stored
from validation.studies import STUDIES
from validation.study import Evidence, Omission, Outcome, Verdict


class Question(NamedTuple):
    """A question: its anchor, which its studies name (`validation.studies.STUDIES`), and its text."""

    name: str
    title: str

    @property
    def studies(self) -> tuple[str, ...]:
        """The studies that answer it, in display order."""
        return tuple(study for study, question in STUDIES.items() if question == self.name)


QUESTIONS = (
    Question("which", "Which model may I use?"),
    Question("cost", "What does an answer cost?"),
    Question("exact", "Is the exact solution exact?"),
    Question("onset", "Where does stick-slip begin, and what comes after?"),
    Question("paper", "What of the paper holds?"),
    Question("trust", "Can I trust the checks?"),
    Question("changed", "What changed?"),
)


@dataclass(frozen=True)
class Asked:
    """A question with the studies of this report that answer it; `said`: their common answer, if no single study gives it."""

    question: Question
    studies: tuple[Stored, ...]
    said: str = ""

    @property
    def answer(self) -> str:
        """The answer, with reservations: failed checks and unfinished studies."""
        lead = next((study for study in self.studies if study.result), None)
        said = self.said or (lead.result.conclusion if lead and lead.result else "Not computed in this report.")
        doubts = [
            f"{len(failed)} check{'s' if len(failed) > 1 else ''} of `{study.name}` failed"
            for study in self.studies
            if (failed := [verdict for verdict in verdicts_of([study]) if verdict.outcome is Outcome.FAIL])
        ]
        doubts += [f"`{study.name}` did not finish" for study in self.studies if study.error]
        return f"{said} But: {'; '.join(doubts)}." if doubts else said


def ask(studies: Sequence[Stored], changed: str) -> list[Asked]:
    """All questions with their studies; studies that no question names are listed with the checks. `changed` answers the last
    question."""
    listed = {name for question in QUESTIONS for name in question.studies}
    known = {study.name: study for study in studies}
    said = {"paper": _of_paper(studies), "trust": _of_checks(studies), "changed": changed}
    if any(study.result and study.result.model_tables for study in studies):
        said["which"] = (
            "The table above, every number of it with what proves it, other scenes, and where a model has the wrong regime."
        )
    found = []
    for question in QUESTIONS:
        mine = [known[name] for name in question.studies if name in known]
        mine += [study for study in studies if question.name == "trust" and study.name not in listed]
        found.append(Asked(question, tuple(mine), said.get(question.name, "")))
    return found


def verdicts_of(studies: Sequence[Stored]) -> list[Verdict]:
    """All verdicts of the studies that finished, in order."""
    return [verdict for study in studies if study.result for verdict in study.result.verdicts]


def left_out(studies: Sequence[Stored]) -> list[tuple[Stored, Omission, list[Verdict], bool]]:
    """Omissions of the report: study, omission, verdicts that check its reason, and whether these are missing although the reason
    has numbers."""
    known, found = verdicts_of(studies), []
    for study in studies:
        for one in study.result.omissions if study.result else ():
            proofs = [verdict for verdict in known if one.claims and verdict.claim.startswith(one.claims)]
            found.append((study, one, proofs, not proofs and any(map(str.isdigit, one.what + one.why))))
    return found


def _of_paper(studies: Sequence[Stored]) -> str:
    """Text: how many of the paper's claims hold, and which do not."""
    judged = [verdict for verdict in verdicts_of(studies) if verdict.evidence is Evidence.PAPER]
    if not judged:
        return ""
    wrong = [verdict for verdict in judged if verdict.outcome is not Outcome.PASS]
    said = (
        f"Of {len(judged)} checks against printed numbers and claims, under all seven questions, {len(judged) - len(wrong)} hold"
    )
    return f"{said}; {len(wrong)} do not, and are listed first." if wrong else f"{said}."


def _of_checks(studies: Sequence[Stored]) -> str:
    """Text: the evidence of the verdicts, and the results of the planted faults."""
    verdicts = verdicts_of(studies)
    kinds = [f"{sum(v.evidence is kind for v in verdicts)} {kind.value}" for kind in Evidence]
    programmes = ("planted-faults", "coverage", "manufactured")
    known = {study.name: study.result.conclusion for study in studies if study.result}
    answers = [known[name] for name in programmes if name in known]
    return " ".join([*answers, f"The {len(verdicts)} verdicts rest on five kinds of evidence: {', '.join(kinds)}."])
