"""`slipwave.score`: compares a user's numbers with the frozen benchmark, row by row."""

import csv
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from slipwave.errors import SceneError
from slipwave.files import reason_of
from slipwave.input.wording import nearest, shorten
from validation.frozen.values import FrozenValue, frozen
from validation.results.result import SCHEMA, aligned

DIGITS = 6
"""Digits that every row must agree to, where as many are certified."""


class Scored(NamedTuple):
    """A user's value and the frozen one."""

    known: FrozenValue
    theirs: float

    @property
    def apart(self) -> float:
        """The user's value minus the frozen one."""
        return self.theirs - self.known.value

    @property
    def within(self) -> bool:
        """Whether it lies within the certified bar."""
        return abs(self.apart) <= self.known.bar

    @property
    def digits(self) -> int:
        """Significant digits that agree, at most those that are certified."""
        if self.within:
            return self.known.digits
        share = abs(self.apart / self.known.value)
        return max(0, min(self.known.digits, math.floor(-math.log10(share)))) if math.isfinite(share) else 0

    def passes(self, digits: int) -> bool:
        """Whether it agrees to so many digits, or to all that are certified."""
        return self.within or self.digits >= min(digits, self.known.digits) > 0


class Score(NamedTuple):
    """The rows in both files, the names in one file only, and the requested digits."""

    scored: list[Scored]
    missing: list[str]
    unknown: list[str]
    asked: int

    @property
    def failed(self) -> list[str]:
        """Failures: rows with too few digits, and rows that the benchmark lacks."""
        return [one.known.id for one in self.scored if not one.passes(self.asked)] + self.unknown

    @property
    def summary(self) -> dict[str, Any]:
        """The JSON of `slipwave score`."""
        rows = [
            {
                "id": one.known.id,
                "value": one.known.value,
                "bar": one.known.bar,
                "theirs": one.theirs if math.isfinite(one.theirs) else None,
                "digits": one.digits,
                "certified_digits": one.known.digits,
                "within_bar": one.within,
                "agrees": one.passes(self.asked),
            }
            for one in self.scored
        ]
        rest = {"missing": self.missing, "unknown": self.unknown, "agrees": not self.failed}
        return {"schema": SCHEMA, "digits_asked": self.asked, "rows": rows, **rest}

    def lines(self) -> Iterator[str]:
        """A row for each value, then the names in one file only, and the total."""
        rows = [
            [
                one.known.id,
                f"{one.theirs!r}",
                f"{one.known.value!r}",
                f"{one.known.bar:.0e}",
                f"{one.digits} of {one.known.digits}",
                "within the bar" if one.within else "agrees" if one.passes(self.asked) else "DIFFERS",
            ]
            for one in self.scored
        ]
        yield from aligned(["id", "theirs", "certified", "bar", "digits", ""], rows)
        yield ""
        if self.unknown:
            guesses = [(name, nearest(name, list(frozen()))) for name in self.unknown]
            names = [f"{shorten(name)}{f' (did you mean {guess}?)' if guess else ''}" for name, guess in guesses]
            yield f"not in the benchmark: {', '.join(names)}"
        if self.missing:
            yield f"missing, not judged: {', '.join(self.missing)}"
        good = sum(one.passes(self.asked) for one in self.scored)
        bars = sum(one.within for one in self.scored)
        yield f"{good} of {len(self.scored)} rows agree to {self.asked} digits or all that are certified; {bars} within the bar"


def score(theirs: str | Path, digits: int = DIGITS) -> Score:
    """Compare the values of a CSV file with columns `id` and `value` with the frozen ones, row by row.

    Raises SceneError if it cannot be read, lacks a column, has a repeated or non-numeric value, or no row of the benchmark."""
    if not 1 <= digits <= 15:
        raise SceneError(f"digits = {digits}: must be from 1 to 15")
    known, found = frozen(), _read(Path(theirs))
    if not found.keys() & known.keys():
        raise SceneError(f"THEIRS = {str(theirs)!r}: has no row of the benchmark: ids are {', '.join(list(known)[:4])}, ...")
    scored = [Scored(row, found[name]) for name, row in known.items() if name in found]
    missing, unknown = [name for name in known if name not in found], [name for name in found if name not in known]
    return Score(scored, missing, unknown, digits)


def _read(path: Path) -> dict[str, float]:
    label, found = f"THEIRS = {str(path)!r}", dict[str, float]()
    try:
        with path.open(encoding="utf-8-sig", newline="") as stream:
            table = csv.DictReader(stream, skipinitialspace=True)
            if not {"id", "value"} <= set(table.fieldnames or ()):
                raise SceneError(f"{label}: its first line must name the columns id and value")
            for row in table:
                name = (row["id"] or "").strip()
                if name in found:
                    raise SceneError(f"{label}: line {table.line_num}: {shorten(name)} is given twice")
                try:
                    found[name] = float(row["value"])
                except (TypeError, ValueError):
                    text = shorten(row["value"] or "")
                    raise SceneError(f"{label}: line {table.line_num}: value = {text}: must be a number") from None
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise SceneError(f"{label}: cannot be read: {reason_of(error) if isinstance(error, OSError) else error}") from None
    return found
