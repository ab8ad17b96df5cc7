"""Results of a program that nobody here wrote (docs/benchmark/others), extrapolated to steps of length zero, and those of the
benchmark's second program, which shares nothing with slipwave."""

import csv
from functools import cache

import numpy as np

from slipwave.sources import ROOT

SEM2DPACK = "SEM2DPACK 2.3.8"
_FILE, _PAIRS = (ROOT / "docs" / "benchmark" / name for name in ("others/sem2dpack.csv", "pairs.csv"))
FILES = (_FILE, _PAIRS) if _FILE.exists() else ()
"""The files that a checkout has; a wheel has none."""
_POWERS = (0, 2, 3, 4)
"""Of the step, in its error: Newmark's scheme is of order 2."""


@cache
def sem2dpack(scheme: str = "newmark") -> dict[str, float]:
    """id -> value of SEM2DPACK, extrapolated from its runs at the four shortest steps. A row with fewer runs is left out."""
    runs: dict[str, dict[float, float]] = {}
    with _FILE.open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            if row["scheme"] == scheme:
                runs.setdefault(row["id"], {})[1.0 / float(row["steps_per_transit"])] = float(row["value"])
    values = dict[str, float]()
    for name, known in runs.items():
        if len(known) >= len(_POWERS):
            steps = np.array(sorted(known)[: len(_POWERS)])
            powers = (steps[:, None] / steps[0]) ** np.array(_POWERS)
            values[name] = float(np.linalg.solve(powers, [known[step] for step in steps])[0])
    return values


@cache
def pairs() -> dict[str, float]:
    """id -> value of orbits and special points of pairs of slabs, in which slipwave and the second program agree."""
    with _PAIRS.open(encoding="utf-8", newline="") as file:
        return {row["id"]: float(row["value"]) for row in csv.DictReader(file)}
