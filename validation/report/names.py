"""Permanent names of verdicts: `claim`, and as much of the evidence and the remark as distinguishes those of one claim; and
one verdict for the cases of one claim."""

import re
import unicodedata
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

from validation.report import Evidence, Outcome, Verdict
from validation.report.text import bare

_WORDS = 8
"""Number of words of a claim in its name."""


def with_names(study: str, verdicts: Sequence[Verdict]) -> tuple[Verdict, ...]:
    """The verdicts of a study with their `id`, each once: a number is appended to repeated names."""
    seen, named = Counter[str](), []
    for verdict in verdicts:
        # the claim and, after a point, the fewest clauses that distinguish it from others of this claim, or else the evidence
        clauses, alike = _clauses(verdict), [other for other in verdicts if _slug(other.claim) == _slug(verdict.claim)]
        apart = (n for n in range(len(clauses) + 1) if sum(_clauses(other)[:n] == clauses[:n] for other in alike) == 1)
        name = ".".join(filter(None, (_slug(verdict.claim), _slug(" ".join(clauses[: next(apart, 1)])))))
        seen[name] += 1
        again = f"-{seen[name]}" if seen[name] > 1 else ""
        named.append(replace(verdict, study=study, id=f"{study}.{name}{again}"))
    return tuple(named)


def by_claim(study: str, verdicts: Sequence[Verdict]) -> tuple[Verdict, ...]:
    """The verdicts of a study with their `id`; several on one claim by one kind of evidence become the `cases` of one verdict,
    which has the outcome and the numbers of the worst of them."""
    alike: dict[tuple[str, Evidence], list[Verdict]] = {}
    for verdict in with_names(study, verdicts):
        alike.setdefault((verdict.claim, verdict.evidence), []).append(verdict)
    order, whole = (Outcome.PASS, Outcome.OPEN, Outcome.FINDING, Outcome.FAIL), []
    for cases in alike.values():
        worst = max(cases, key=lambda case: (order.index(case.outcome), case.margin or 0.0))
        remark = f"the worst of {len(cases)}: {worst.remark}".rstrip(": ")
        whole.append(replace(worst, remark=remark, cases=tuple(cases)) if len(cases) > 1 else worst)
    named = with_names(study, [replace(verdict, remark="") for verdict in whole])
    return tuple(replace(verdict, id=name.id) if verdict.cases else verdict for verdict, name in zip(whole, named, strict=True))


def _clauses(verdict: Verdict) -> list[str]:
    return [verdict.evidence.name, *re.split("[;,:] ", verdict.remark)]


def _slug(words: str) -> str:
    """The first words in lower case, joined by hyphens: Latin letters, numerals and points; names for the rest."""
    spelled = "".join(map(_spelled, bare(words).replace("^-", "^−")))
    return "-".join(re.findall(r"[a-z0-9]+(?:\.[0-9]+)*", spelled.lower())[:_WORDS])


def _spelled(letter: str) -> str:
    """The name of a Greek letter, of a minus sign and of a root; other characters as they are."""
    if letter in "−√":
        return {"−": " minus ", "√": " root "}[letter]
    name = unicodedata.name(letter, "")
    return f" {name.split()[-1]} " if name.startswith("GREEK") else letter
