"""python -m tests.verification.on_record        # makes the records of motions and special points that studies read; resumes

Runs are lengthened until twice the standard errors of T and of the stress drop are below 0.2 % of them, in other scenes than the
paper's 0.5 % or 1 %. Delete a motion from the record to compute it anew.
"""

import csv
import math
import sys
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

from llvmlite.binding import get_host_cpu_name

from slipwave.files import whole_or_absent
from slipwave.observe.statistics import Estimate
from validation.measure.in_words import able, motion_at, scene_of
from validation.measure.on_record import MOTIONS, SPECIAL_POINTS, KnownPoint, branch_points, first_point, motions, special_points
from validation.measure.regimes import FIGURES, Regime
from validation.report.compared import JUDGED
from validation.studies import asymmetry, reflection, which_model
from validation.studies.which_model.motions import paper_at, regime_at, regime_in

_FIRST, _LONGER, _MOST = 20000.0, 1.2, 16.0
PAPER, SCENES, MANY = 2e-3, 5e-3, 1e-2
"""Widths allowed: of the first table, of that of other scenes, and of tables with a row for a model in many scenes."""


def long_run(motion: Callable[[float], Regime], width: float, label: str) -> Regime:
    """`motion` (of a run of so many transits) of a run long enough for twice the standard errors of T and of the stress drop to
    be below `width`, relative; of a short one if it repeats, slides or runs away."""
    until = _FIRST
    while True:
        found = motion(until)
        wide = (
            max((2.0 * found.figures[one].error / found.figures[one].value for one in JUDGED if found.cycles), default=0.0)
            / width
        )
        print(f"{label}: {found.words}, {until:g} transits, {wide:.2f} of the width allowed", file=sys.stderr, flush=True)
        if wide <= 1.0:
            return found
        longer = _LONGER * until * min(wide**2, _MOST)
        digit = 10.0 ** (math.floor(math.log10(longer)) - 1)
        until = digit * math.ceil(longer / digit)


def wanted() -> Iterator[tuple[str, str, Callable[[float], Regime], float, bool]]:
    """Model, scene, motion and width of every motion that studies ask the record for; whether one that repeats is kept."""
    for log10_r in which_model.BEYOND:
        for model in which_model.EVERY:
            yield model, paper_at(log10_r), partial(regime_at, model, log10_r), PAPER, False
    for place in which_model.places_of():
        for model in which_model.IN_SCENES:
            yield model, place.settings, partial(regime_in, model, place.settings), SCENES, False
    for pair in asymmetry.PAIRS:
        for model in asymmetry.MODELS:
            yield model, pair.settings, partial(motion_at, model, pair.settings), MANY, True
    for column in reflection.columns().values():
        for model in reflection.MODELS:
            if able(model, scene_of(column.settings)):
                yield model, column.settings, partial(motion_at, model, column.settings), MANY, True
    for words in reflection.plane().values():
        yield "delay", words, partial(motion_at, "delay", words), math.inf, True


def points_wanted() -> Iterator[tuple[str, Callable[[], list[KnownPoint]]]]:
    """Scene and options of every branch whose special points studies ask the record for, and these."""
    for pair in asymmetry.FOLLOWED:
        yield pair.settings, lambda pair=pair: [first_point("LP", pair.settings)]
    for face in reflection.BRANCHES:
        yield face.settings(), partial(branch_points, face.settings(), reflection.RANGE, **reflection.WHOLE)


def make_record() -> None:
    for scene, points in points_wanted():
        if scene not in special_points():
            add(
                SPECIAL_POINTS,
                [{**dict(zip(KnownPoint._fields, map(str, one), strict=True)), "scene": scene} for one in points()],
            )
    for model, scene, motion, width, always in wanted():
        found = None if (model, scene) in motions() else long_run(motion, width, f"{model}, {scene}")
        if found and (always or (found.figures and found.command.startswith("run"))):
            add(MOTIONS, [row_of(model, scene, found)])


def row_of(model: str, scene: str, motion: Regime) -> dict[str, str]:
    row = {"model": model, "regime": motion.words, "cycles": str(motion.cycles), "command": motion.command}
    for symbol, name in FIGURES.items():
        row[name], row[f"{name}_error"] = written(motion.figures.get(symbol))
    return row | {"scene": scene, "processor": get_host_cpu_name()}


def add(path: Path, more: list[dict[str, str]]) -> None:
    """Add lines to a file; those of a scene keep their order."""
    with path.open(encoding="utf-8", newline="") as file:
        lines = csv.DictReader(file)
        rows, columns = [*lines, *more], lines.fieldnames or ()
    with whole_or_absent(path) as temporary, temporary.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, columns, lineterminator="\n")
        writer.writeheader()
        writer.writerows(sorted(rows, key=lambda one: (one.get("model", ""), one["scene"])))


def written(one: Estimate | None) -> tuple[str, str]:
    """A value, to a thousandth of its error, and the error."""
    if one is None:
        return "", ""
    digits = 17 if not one.error > 0.0 else min(17, max(8, 4 + math.ceil(math.log10(abs(one.value) / one.error))))
    return f"{one.value:.{digits}g}", f"{one.error:.3g}"


if __name__ == "__main__":
    make_record()
