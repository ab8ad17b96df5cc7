"""python -m tests.verification.means        # makes the record of means that `which-model` reads; half an hour, resumes

Runs are lengthened until twice the standard errors of T and of the stress drop are below 0.2 % of them, in other scenes than the
paper's 0.5 %. Delete a motion from the record to compute it anew.
"""

import json
import math
import sys
from collections.abc import Callable, Iterator
from dataclasses import asdict
from functools import partial

from llvmlite.binding import get_host_cpu_name

from slipwave.files import whole_or_absent
from validation.measure.regimes import Regime
from validation.report.advice import JUDGED
from validation.studies import which_model
from validation.studies.which_model.means import RECORD, paper_at

HOW = "python -m tests.verification.means; digits of irregular motions are those of this processor"
_FIRST, _LONGER, _MOST = 20000.0, 1.2, 16.0
PAPER, SCENES = 2e-3, 5e-3
"""Widths allowed: of the first table, and of that of other scenes."""


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


def motions() -> Iterator[tuple[str, str, Callable[[float], Regime], float]]:
    """Model, scene and options, motion and width of every cell of both tables that may have means."""
    for log10_r in which_model.BEYOND[False]:
        for model in which_model.EVERY:
            yield model, paper_at(log10_r), partial(which_model.regime_at, model, log10_r), PAPER
    for place in which_model.scenes.places_of(False):
        for model in which_model.IN_SCENES:
            yield model, place[0].settings, partial(which_model.regime_in, model, place), SCENES


def make_record() -> None:
    known = json.loads(RECORD.read_bytes()) if RECORD.exists() else {"how": HOW, "processor": get_host_cpu_name(), "means": {}}
    for model, settings, motion, width in motions():
        own = known["means"].setdefault(model, {})
        found = None if settings in own else long_run(motion, width, f"{model}, {settings}")
        if found and found.figures and found.command.startswith("run"):
            own[settings] = asdict(found)
            with whole_or_absent(RECORD) as temporary:
                temporary.write_text(json.dumps(known, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


if __name__ == "__main__":
    make_record()
