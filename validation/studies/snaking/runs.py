"""Direct runs of the delay system beside its branch: where they end, and the multiplier with which they settle."""

from typing import NamedTuple

import numpy as np

from slipwave.observe.pieces import Array
from validation.measure.settle import settle
from validation.registry.build import build
from validation.studies.bifurcation.branches import scene_at

_MOST = 9000.0
_LAST = 0.7  # share of a run after which its cycles are judged
_LINEAR = (1e-5, 1e-3)  # deviations of T (transits) between which a multiplier is fitted


class Run(NamedTuple):
    """A run from the scene's own start: the periods of all its cycles, and of those of its last part (transits); whether they
    settled."""

    log10_r: float
    periods: Array
    last: Array
    settled: bool


def run_at(log10_r: float) -> Run:
    """A run of the delay system until its cycles stop changing, or over 9000 transits."""
    found = settle(build("delay", scene_at(log10_r), tolerance=1e-10), tolerance=1e-8, most=_MOST)
    periods, last = (found.observer.events(share * found.transits).period for share in (0.0, _LAST))
    return Run(log10_r, periods, last, found.settled)


def multiplier_of(run: Run, period: float) -> complex:
    """The leading pair of multipliers (its member above the real axis) from a run that settles on the orbit of this `period`:
    deviations d_n of its cycles obey d_(n+1) = 2 Re(m) d_n - |m|^2 d_(n-1), which is fitted where they are small."""
    deviations = run.periods - period
    size = np.maximum(np.abs(deviations[:-1]), np.abs(deviations[1:]))
    far, near = (int(np.nonzero(size > bound)[0][-1]) for bound in reversed(_LINEAR))
    window = deviations[far : near + 1]
    weights = 1.0 / np.hypot(window[1:-1], window[:-2])
    before = np.column_stack([window[1:-1], -window[:-2]])
    twice, square = np.linalg.lstsq(weights[:, None] * before, weights * window[2:], rcond=None)[0]
    return complex(0.5 * twice, np.sqrt(square - 0.25 * twice**2))
