"""What the reductions' errors must show."""

import math
from itertools import pairwise

import numpy as np

from reduced.impedance import reduction_of
from validation.report.text import plain
from validation.studies.model_error_runs import Runs, curves, error, scene_at
from validation.study import Evidence, Verdict, judge

TARGETS = {"modal:1": 1e-3, "modal:2": 1e-5}
"""Model -> largest error of the period of the paper's scene."""

_LADDER = ("modal:1", "modal:2", "modal:4", "modal:8")
_PRINTED = 1.0 - 70.73 / 73.5


def all_verdicts(runs: Runs) -> tuple[Verdict, ...]:
    """In the order of the page."""
    return (*(target(runs, model) for model in TARGETS), _paper(runs), _modes(runs), _fit(runs), _no_modes())


def target(runs: Runs, model: str) -> Verdict:
    """Whether `model` keeps its promise at log10 r = -2.68."""
    off, limit = abs(error(runs, model, -2.68, "period")), TARGETS[model]
    return Verdict(
        "The slabs’ exact modes give the period of the paper’s scene",
        Evidence.WITNESS,
        f"below {plain(limit, '.0e')}",
        plain(off, ".1e"),
        judge(off < limit),
        f"`{model}` at log_{{10}} r = −2.68, against the delay system",
    )


def _paper(runs: Runs) -> Verdict:
    ours = -error(runs, "kelvin-voigt", -2.68, "period")
    return Verdict(
        "The paper’s ODE falls short of the exact period by some 4 %",
        Evidence.PAPER,
        f"{100 * _PRINTED:.1f} %",
        f"{100 * ours:.2f} %",
        judge(abs(ours - _PRINTED) < 1e-3),
        "70.73 against 73.5 transits as printed, log_{10} r = −2.68",
    )


def _modes(runs: Runs) -> Verdict:
    """The largest error over the range of r, for 1, 2, 4 and 8 modes."""
    errors = curves(runs)
    largest = [[float(np.nanmax(errors[model][1 + which])) for model in _LADDER] for which in (0, 1)]
    falls = all(later < sooner for some in largest for sooner, later in pairwise(some))
    return Verdict(
        "Every doubling of the number of modes lessens the largest error over the range of r",
        Evidence.WITNESS,
        "falling",
        ", ".join(plain(value, ".0e") for value in largest[0]),
        judge(falls),
        "period shown, drop asked too; 1, 2, 4, 8 modes. At a single r it need not fall: errors change sign along r",
    )


def _fit(runs: Runs) -> Verdict:
    fitted, modal = runs["fitted:4"][-2.68], runs["modal:4"][-2.68]
    off = abs(fitted.period / modal.period - 1.0) if fitted and modal else math.nan
    return Verdict(
        "A fit of the exact impedance of alike slabs finds their modes",
        Evidence.EXACT,
        "same period",
        f"differs by {plain(off, '.0e')}" if off else "the same",
        judge(off < 1e-8),
        "`fitted:4` against `modal:4`: an elastic slab behind a rigid face has no better poles to offer",
    )


def _no_modes() -> Verdict:
    none, block = (reduction_of(scene_at(-2.68), model) for model in ("modal:0", "block12"))
    same = none.mass == block.mass and not none.frequencies and none.damping == block.damping
    return Verdict(
        "No mode at all is the ρh/12 block", Evidence.EXACT, "the same equations", "same" if same else "not", judge(same)
    )
