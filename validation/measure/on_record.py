"""What long computations found once, by `python -m tests.verification.on_record`: final motions of long runs, and special points
of branches over log10 r. Studies read them and compute a few again. Digits of irregular motions are those of the processor named
beside them."""

import csv
import math
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import slipwave as sw
from slipwave.observe.statistics import Estimate
from validation.measure.in_words import scene_of
from validation.measure.memo import critical_r
from validation.measure.regimes import FIGURES, Regime
from validation.references import published

MOTIONS, SPECIAL_POINTS = (Path(published.__file__).with_name(name) for name in ("motions.csv", "special-points.csv"))


class KnownPoint(NamedTuple):
    """A special point of `kind` at the upper slab's `log10_r`, and its period (transits)."""

    kind: str
    log10_r: float
    period: float


@cache
def motions() -> dict[tuple[str, str], Regime]:
    """Every motion on record: (model, the words that give its scene in a command) -> motion."""
    return {(row["model"], row["scene"]): _motion(row) for row in _rows(MOTIONS)}


def on_record(model: str, scene: str) -> Regime | None:
    """The motion of a model, given its scene and options as words of a command; None if it was never computed."""
    return motions().get((model, scene))


@cache
def special_points() -> dict[str, tuple[KnownPoint, ...]]:
    """The words that give a scene in a command -> the special points on record of the delay system's branch, in its order."""
    points: dict[str, tuple[KnownPoint, ...]] = {}
    for row in _rows(SPECIAL_POINTS):
        point = KnownPoint(row["kind"], float(row["log10_r"]), float(row["period"]))
        points[row["scene"]] = (*points.get(row["scene"], ()), point)
    return points


def branch_points(words: str, ends: tuple[float, float], **options: Any) -> list[KnownPoint]:
    """The special points of the delay system's branch between two log10 r, with `options` of `slipwave.branch`."""
    special = sw.branch(scene_of(words), {"log10_r": ends}, model="delay", **options).summary["special"]
    return [KnownPoint(point["type"], point["log10_r"], point["period"]) for point in special]


def first_point(kind: str, words: str) -> KnownPoint:
    """The first special point of a kind on this branch, near the onset: a fold is the least r with cycles there."""
    onset = math.log10(critical_r("delay", scene_of(words)))
    return branch_points(words, (onset - 0.02, onset + 0.02), stop_at=kind, tol=1e-9)[-1]


def _rows(path: Path) -> Iterator[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as file:
        yield from csv.DictReader(file)


def _motion(row: dict[str, str]) -> Regime:
    figures = {symbol: Estimate(float(row[name]), float(row[f"{name}_error"])) for symbol, name in FIGURES.items() if row[name]}
    return Regime(row["regime"], figures, int(row["cycles"]), row["command"])
