"""The first fold of both systems over V: how far it lies below the Hopf point, and that only the products εV and rV matter."""

import math
from collections.abc import Iterator, Mapping, Sequence

import slipwave as sw
from validation.references.onset import onset_of
from validation.report import EXACT, PAPER, Verdict, claim, in_range
from validation.report.known import JUST_BELOW
from validation.report.text import plain
from validation.report.verdict import ROUNDING

Fold = tuple[float, float]  # log10 r and V
_TOLERANCE = 1e-6
_LOW, _HIGH = -2.73, -2.3  # log10 r at V = 100 between which the fold is searched for
_ENDS = (50, 200)  # V towards which a curve is followed from V = 100


def folds_over_drive(model: str, most: int) -> list[Fold]:
    """The first fold of `model` over V, from at most so many points on each side of V = 100."""
    over = f"log10_r={_LOW}:{_HIGH}"
    curves = [
        sw.curve("paper", of="LP", over=over, along=f"V=100:{end}", model=model, tol=_TOLERANCE, most_points=most)
        for end in _ENDS
    ]
    return sorted(((one["log10_r"], one["V"]) for curve in curves for one in curve.points), key=lambda fold: fold[1])


def fold_at(velocity: float) -> float:
    """log10 r of the delay system's first fold at this V, computed at V = 100 with epsilon and r larger by V/100."""
    scene = sw.read("paper", {"slab.epsilon": 2.8e-7 * velocity})
    larger = math.log10(velocity / 100.0)
    over = f"log10_r={_LOW + larger}:{_HIGH + larger}"
    found = sw.branch(scene, model="delay", over=over, stop_at="LP", tol=_TOLERANCE)
    return float(found.special[-1]["log10_r"]) - larger


def _below(model: str, fold: Fold) -> float:
    """Relative distance in r below the Hopf point."""
    scene = sw.read("paper")
    onset = onset_of(scene.law, scene.upper.epsilon, fold[1])
    return float(1.0 - 10.0 ** fold[0] / (onset.r_delay if model == "delay" else onset.r_kelvin_voigt))


def fold_verdicts(curves: Mapping[str, Sequence[Fold]], again: float) -> Iterator[Verdict]:
    """`again`: the last fold of the delay system by `fold_at`."""
    log10_r, velocity = curves["delay"][-1]
    title = "Only the products εV and rV matter: the fold at V is that at V = 100 with ε and r larger by V/100"
    yield claim(
        title, EXACT, log10_r, ROUNDING, f"log_{{10}} r of the delay system’s first fold at V = {velocity:.1f}", near=again
    )
    for model, folds in curves.items():
        low, high = folds[0][1], folds[-1][1]
        yield in_range(
            "P8 The Hopf point is very mildly subcritical, at other V (and so at other ε) too",
            PAPER,
            (0.0, JUST_BELOW),
            [_below(model, fold) for fold in folds],
            f"{model}: of r_{{c}}, how far below lie {len(folds)} folds at V from {low:.0f} to {high:.0f}; at fixed V that is ε "
            f"from {plain(2.8e-7 * low, '.2g')} to {plain(2.8e-7 * high, '.2g')}",
            ".2%",
        )
