"""The verdict on a run, from the figures of the cycles in its second half alone.

    driven      V is not constant there, or it is zero: the drive causes the motion
    steady      v ends within 1e-6 of V, and either there is no event or v_max and v_min of all cycles agree within 1e-6
    too short   fewer than 3 complete cycles, or fewer than 8 that neither repeat nor converge
    periodic    in the later half of the cycles (at least three), the figures of every n-th agree within 1e-3 (largest minus
                smallest, over the mean); n is the smallest such number from 1 to 8
    decaying,   the logarithm of the prominence falls or grows from each third of the events to the next, the second time at
    growing     least half as fast as the first, that is, exponentially. It must change by ln 2 in all, or the motion must be so
                small (v_max/v_min below 1.2) that it can only be exponential
    settling    cycles change, but towards a limit: the change from one to the next at the end is at most half of that at the
                beginning, or all figures change in one direction
    torus       period and v_max of 16 cycles or more are smooth functions of one phase that advances by the same angle from cycle
                to cycle, within a tenth of their spread (`torus`)
    irregular   none of these in 8 cycles or more

Figures are period, stress drop, elastic stress drop, v_max and v_min.
"""

from typing import Literal, NamedTuple, TypeAlias

import numpy as np

from slipwave.observe.events import Events
from slipwave.observe.pieces import Array
from slipwave.observe.torus import rotation

Kind: TypeAlias = Literal["steady", "decaying", "growing", "settling", "periodic", "torus", "irregular", "driven", "too short"]

REPEATING: tuple[Kind, ...] = ("periodic", "torus", "irregular")
"""Verdicts on motions that means over cycles represent."""

WANDERING: tuple[Kind, ...] = ("torus", "irregular")
"""Verdicts on motions that go on without ever repeating."""

FEWEST, ENOUGH = 3, 8
REPEATS = 1e-3
_MOST_EVENTS = 8  # in one period
_SMALL = 1.2
_SLIDES = 1e-6
_SMOOTH = 0.1  # misfit of a torus; of noise at least 0.2 in 16 cycles and 0.3 in 24, of chaos more


class Verdict(NamedTuple):
    """`cycles`: complete cycles in the second half. `multiplicity`: events in a period, if periodic. `change`: largest relative
    difference of a figure between the last two cycles, or of the prominence between the first and the last event if decaying or
    growing; NaN if there are too few. `needed`: length in transits with which a run too short would have enough cycles, else
    NaN. `rotation`: the share of a turn by which a torus advances in a cycle, else None. `rate`: of the logarithm of the
    elastic stress drop, per transit, if decaying or growing, else NaN."""

    kind: Kind
    cycles: int
    multiplicity: int | None = None
    change: float = np.nan
    needed: float = np.nan
    rotation: float | None = None
    rate: float = np.nan

    @property
    def repeats(self) -> bool:
        """Whether means over the cycles represent the motion; those of a transient do not."""
        return self.kind in REPEATING

    @property
    def wanders(self) -> bool:
        """Whether the cycles never repeat, so that means over some of them are uncertain."""
        return self.kind in WANDERING


def judge_motion(cycles: Events, prominence: Array, drive_rests: bool, slides: bool, until: float) -> Verdict:
    """The verdict on a run to `until` (transits) whose second half has these `cycles` and these events' `prominence`;
    `drive_rests` is true if V is constant there and not zero, `slides` if v ends at V."""
    count, figures = cycles.time.size, np.array(cycles[1:]).T
    if not drive_rests:
        return Verdict("driven", count)
    if slides and (prominence.size == 0 or (count and slides_at(float(cycles.v_max.max()), float(cycles.v_min.min())))):
        return Verdict("steady", count)
    if count < FEWEST:
        return Verdict("too short", count, needed=_needed(cycles, until, FEWEST))
    multiplicity = _multiplicity(figures[-max(FEWEST, (count + 1) // 2) :])
    change = float(np.max(np.abs(figures[-1] / figures[-2] - 1.0)))
    if multiplicity:
        return Verdict("periodic", count, multiplicity, change)
    trend = _trend(prominence, float(cycles.v_max[-1] / cycles.v_min[-1]))
    if trend:
        change = float(prominence[-1] / prominence[0] - 1.0)
        return Verdict("growing" if trend > 0.0 else "decaying", count, change=change, rate=_rate(cycles))
    if _converges(figures):
        return Verdict("settling", count, change=change)
    if count < ENOUGH:
        return Verdict("too short", count, change=change, needed=_needed(cycles, until, ENOUGH))
    turned = _rotation(cycles)
    return Verdict("torus" if turned else "irregular", count, change=change, rotation=turned)


def slides_at(rate: float, velocity: float) -> bool:
    """Whether the slip rate is that of the drive."""
    return bool(abs(rate - velocity) <= _SLIDES * velocity)


def _multiplicity(figures: Array) -> int | None:
    """The smallest n for which every n-th cycle is the same, over at least two periods; None if there is none."""
    for n in range(1, min(_MOST_EVENTS, len(figures) // 2) + 1):
        spreads = [np.ptp(figures[k::n], axis=0) / np.abs(figures[k::n].mean(axis=0)) for k in range(n)]
        if np.max(spreads) <= REPEATS:
            return n
    return None


def _trend(prominence: Array, ratio: float) -> float:
    """Change of the logarithm of the prominence over the last third of the window, if it is exponential; else 0."""
    first, second, third = (float(part.mean()) for part in np.array_split(np.log(prominence), 3))
    early, late = second - first, third - second
    steadily = early * late > 0.0 and abs(late) >= 0.5 * abs(early)
    return late if steadily and (abs(np.log(prominence[-1] / prominence[0])) >= np.log(2.0) or ratio < _SMALL) else 0.0


def _rate(cycles: Events) -> float:
    """Rate at which the elastic stress drop grows, per transit: the slope of its logarithm over the dates, least squares."""
    return float(np.polyfit(cycles.time - cycles.time[0], np.log(cycles.elastic_stress_drop), 1)[0])


def _converges(figures: Array) -> bool:
    """Whether the changes from cycle to cycle shrink to half, or all figures change in one direction."""
    steps = np.abs(np.diff(figures, axis=0) / figures[1:]).max(axis=1)
    half = len(steps) // 2
    one_way = [bool(np.all(np.diff(column) > 0.0) or np.all(np.diff(column) < 0.0)) for column in figures.T]
    return bool(steps[-half:].max() <= 0.5 * steps[:half].max()) or all(one_way)


def _rotation(cycles: Events) -> float | None:
    """The rotation number, if period and v_max are smooth functions of the same phase; else None."""
    found = [rotation(figure) for figure in (cycles.period, cycles.v_max)]
    smooth = [one.number for one in found if one is not None and one.misfit < _SMOOTH]
    return smooth[0] if len(smooth) == 2 and abs(smooth[0] - smooth[1]) < 1.0 / cycles.time.size else None


def _needed(cycles: Events, until: float, wanted: int) -> float:
    """Length of a run whose second half has `wanted` complete cycles and one to spare, from the longest cycle so far."""
    return max(2.0 * (wanted + 2) * float(cycles.period.max()), 1.5 * until) if cycles.time.size else 2.0 * until
