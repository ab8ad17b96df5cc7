"""The record of how often stated errors hold the truth (`validation.coverage.kinds`), and what it says."""

import json
import sys
from collections.abc import Iterable
from itertools import groupby
from pathlib import Path
from typing import NamedTuple, TypeAlias

import numpy as np
from scipy.stats import binomtest

from slipwave.files import whole_or_absent
from slipwave.sources import ROOT, digest_of
from validation.coverage import kinds
from validation.coverage.kinds import KINDS, Held, computation

RECORD = ROOT / "reports" / "baseline" / "coverage-record.json"
_AT_ONCE = 10  # computations between two writings
_CHANCE = 1e-15  # rounding error of what is taken for the truth, relative


class Coverage(NamedTuple):
    """How a kind of `figure` fares: how `many` bars there are, the `share` that hold the truth with its 95 % interval (Wilson),
    and how many times larger than the error a bar is, in the median."""

    figure: str
    many: int
    share: float
    low: float
    high: float
    width: float


def coverage_of(computations: Iterable[list[Held]]) -> list[Coverage]:
    """The coverage of each figure."""
    found = sorted((held for one in computations for held in one), key=lambda held: held.figure)
    return [_covered(figure, list(members)) for figure, members in groupby(found, key=lambda held: held.figure)]


def _covered(figure: str, group: list[Held]) -> Coverage:
    holds = sum(held.error <= held.bar for held in group)
    low, high = binomtest(holds, len(group)).proportion_ci(method="wilson")
    width = float(np.median([held.bar / max(held.error, _CHANCE) for held in group]))
    return Coverage(figure, len(group), holds / len(group), float(low), float(high), width)


Record: TypeAlias = dict[str, list[list[Held]]]
"""By kind: its computations, in order."""


def definition() -> str:
    """Digest of what is computed, the program text of `validation.coverage.kinds`: another record is of something else."""
    return digest_of([Path(kinds.__file__).resolve()])


def known_computations(path: Path = RECORD) -> Record:
    """What was recorded by this definition; empty if nothing was."""
    stored = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    if stored.get("definition") != definition():
        return {}
    return {kind: [[Held(*held) for held in one] for one in found] for kind, found in stored["kinds"].items()}


def store_computations(record: Record, path: Path = RECORD) -> None:
    """A line for each computation."""
    lines = {kind: ",\n".join(f"   {_line(one)}" for one in found) for kind, found in record.items()}
    every = ",\n".join(f"  {json.dumps(kind)}: [\n{text}\n  ]" for kind, text in lines.items())
    with whole_or_absent(path) as part:
        part.write_text(f'{{\n "definition": "{definition()}",\n "kinds": {{\n{every}\n }}\n}}\n', encoding="utf-8")


def _line(computed: list[Held]) -> str:
    return json.dumps([[held.figure, float(f"{held.bar:.4g}"), float(f"{held.error:.4g}")] for held in computed])


def make_record(path: Path = RECORD) -> None:
    """Compute what the record lacks, and store it time and again."""
    record = {kind: known_computations(path).get(kind, []) for kind in KINDS}
    for kind, known in record.items():
        for number in range(len(known), KINDS[kind].recorded):
            known.append(computation(kind, number))
            if (number + 1) % _AT_ONCE == 0 or number + 1 == KINDS[kind].recorded:
                store_computations(record, path)
                print(f"{kind}: {number + 1} of {KINDS[kind].recorded}", file=sys.stderr, flush=True)
