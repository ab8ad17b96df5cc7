"""The seven questions of the page, and the answers of their studies."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from validation.report import Evidence, Omission, Outcome, Verdict
from validation.report.registered import STUDIES
from validation.report.store import Stored


class Question(NamedTuple):
    """A question: its anchor, which its studies name (`validation.report.registered.STUDIES`), and its text."""

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
    Question("begin", "Where does stick-slip begin, and what comes after?"),
    Question("paper", "What of the paper holds?"),
    Question("trust", "Can I trust the checks?"),
    Question("changed", "What changed?"),
)


@dataclass(frozen=True)
class Asked:
    """A question with the studies of this report that answer it; its answers, and the verdicts that these rest on, by study."""

    question: Question
    studies: tuple[Stored, ...]
    answers: tuple[str, ...]
    rests_on: tuple[tuple[Stored, tuple[Verdict, ...]], ...]


def ask(studies: Sequence[Stored], changed: str) -> list[Asked]:
    """All questions with their studies; studies that no question names are listed with the checks. `changed` answers the last
    question."""
    listed = {name for question in QUESTIONS for name in question.studies}
    known = {study.name: study for study in studies}
    found = []
    for question in QUESTIONS:
        mine = [known[name] for name in question.studies if name in known]
        mine += [study for study in studies if question.name == "trust" and study.name not in listed]
        found.append(_asked(question, mine, studies, changed))
    return found


def _asked(question: Question, mine: Sequence[Stored], studies: Sequence[Stored], changed: str) -> Asked:
    """The answers of its studies, with reservations: failed checks and unfinished studies."""
    done = [(study, study.result) for study in mine if study.result]
    said = [result.headline for _, result in done if not result.model_tables]  # the sentences of tables stand above all questions
    rests_on = [(study, result.proofs(result.answers[0])) for study, result in done if result.answers]
    if question.name == "paper":
        judged = [(study, tuple(v for v in verdicts_of([study]) if v.evidence is Evidence.PAPER)) for study in studies]
        said = _of_paper([v for _, some in judged for v in some]) + said
        rests_on += [(study, some) for study, some in judged if some and study not in mine]
    elif question.name == "trust":
        verdicts = verdicts_of(studies)
        kinds = [f"{sum(v.evidence is kind for v in verdicts)} {kind.value}" for kind in Evidence]
        said += [f"The {len(verdicts)} verdicts rest on six kinds of evidence: {', '.join(kinds)}."]
    elif question.name == "changed":
        said = [changed]
    doubts = [
        f"{len(failed)} check{'s' if len(failed) > 1 else ''} of `{study.name}` failed"
        for study in mine
        if (failed := [verdict for verdict in verdicts_of([study]) if verdict.outcome is Outcome.FAIL])
    ]
    doubts += [f"`{study.name}` did not finish" for study in mine if study.error]
    said = (said or ["Not computed in this report."]) + ([f"But: {'; '.join(doubts)}."] if doubts else [])
    return Asked(question, tuple(mine), tuple(said), tuple(rests_on))


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


def _of_paper(judged: Sequence[Verdict]) -> list[str]:
    """How many of the verdicts on the paper's claims hold, and which do not."""
    if not judged:
        return []
    wrong = [verdict for verdict in judged if verdict.outcome is not Outcome.PASS]
    said = f"Of {len(judged)} checks against the paper’s claims, under all seven questions, {len(judged) - len(wrong)} hold"
    return [f"{said}; {len(wrong)} do not, and are listed first." if wrong else f"{said}."]
