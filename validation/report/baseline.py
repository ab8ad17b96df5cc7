"""The committed baseline: the numbers of an earlier full report, one small JSON file per study, and what has moved since.

python -m validation.report.baseline reports        # take the numbers of reports/ as the new baseline
"""

import json
import sys
from dataclasses import dataclass
from pathlib import Path

from slipwave.sources import ROOT
from validation.report.store import Stored, numbers_of

FOLDER = ROOT / "reports" / "baseline"


@dataclass(frozen=True)
class Change:
    """A number that moved by more than its tolerance; `before` or `now` is None where it is new or gone."""

    study: str
    name: str
    before: float | None
    now: float | None
    tolerance: float


def compare(stored: Stored, quick: bool, folder: Path = FOLDER) -> list[Change] | None:
    """What changed in a study since the baseline of a full report; None if it has none, or if the study failed. A number that a
    quick report leaves out is no change."""
    path = folder / f"{stored.name}.json"
    if stored.result is None or not path.exists():
        return None
    before = numbers_of(json.loads(path.read_text(encoding="utf-8")))
    now = stored.result.numbers
    changes = [Change(stored.name, name, None, n.value, n.tolerance) for name, n in now.items() if name not in before]
    if not quick:
        changes += [Change(stored.name, name, n.value, None, n.tolerance) for name, n in before.items() if name not in now]
    changes += [
        Change(stored.name, name, before[name].value, n.value, n.tolerance)
        for name, n in now.items()
        if name in before and n.differs(before[name].value)
    ]
    return changes


def moved(stored: Stored, quick: bool) -> list[Change]:
    """Numbers that left their baseline; a new number has nothing to be compared with."""
    return [change for change in compare(stored, quick) or [] if change.before is not None]


def take(out: Path, folder: Path = FOLDER) -> list[Path]:
    """Write the numbers stored under out/data as the baseline in `folder`; returns the files written."""
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for path in sorted(out.glob("data/*/result.json")):
        record = json.loads(path.read_text(encoding="utf-8"))
        if record["numbers"]:
            target = folder / f"{record['study']}.json"
            target.write_text(json.dumps(record["numbers"], indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
            written.append(target)
    return written


if __name__ == "__main__":
    print("\n".join(str(path) for path in take(Path(sys.argv[1]))))
