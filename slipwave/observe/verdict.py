"""The verdict on a run, from the figures of the cycles in its second half alone.

    driven      V changes throughout, or it is zero: the drive causes the motion
    protocol    V changes there, or the cycles do not repeat after it has changed: its stages are judged (`stages`)
    steady      v ends within 1e-6 of V, and either there is no event or v_max and v_min of all cycles agree within 1e-6, and the
                prominence does not grow by a fifth on a straight line
    too short   fewer than 3 complete cycles, or fewer than 16 that neither repeat nor come closer
    periodic    in the later half of the cycles (at least three), the figures of every n-th agree within 1e-3 (largest minus
                smallest, over the mean), and do not move on by more; n is the smallest such number from 1 to 8, up to half of
                their number if all cycles repeat. For n > 1 they agree ten times (beyond 8, a hundred times) better than the
                cycles of one period do among themselves: a swing that decays comes near to repeating after n cycles as well
    decaying,   the logarithm of the prominence falls or grows on a straight line, or faster: its slope does not become so
    growing     much smaller that a limit above half of the last prominence is in sight. It must change by a fifth in all, or the
                motion must be so small (v_max/v_min below 1.2) that it can only be exponential
    settling    cycles still change in one direction: they come closer to each other, or drift (`_goes_on`), or they would be
                irregular, but vary less and less (`_narrows`)
    torus       period and v_max of 24 cycles or more are smooth functions of one phase that comes round and advances by the same
                angle from cycle to cycle, within 4 % of their spread, with an amplitude that stays (`torus`)
    irregular   none of these in 16 cycles or more

Figures are period, stress drop, elastic stress drop, v_max and v_min.

Cycles of a motion that still change in one direction neither repeat nor wander for ever (`_goes_on`).

Figures of cycles are compared as logarithms, cycle k with cycle k + n (every n-th, n = 1 ... 8), so that the approach to a period
of n events is seen as well. There are two criteria:

* the differences become smaller (or larger) exponentially: the line through their logarithms changes by ln 2 or more in all,
  and by five times its standard error, and goes on in the later half, which fluctuations of chaos do not;
* a parabola in k leaves at most a tenth of the variance, in most figures: a slow drift. For n > 1 a
  straight line must do that, because half a turn of a torus near a period of n is a parabola too.
"""

from typing import Literal, NamedTuple, TypeAlias

import numpy as np

from slipwave.observe.events import Events
from slipwave.observe.pieces import Array
from slipwave.observe.torus import MANY, MOST_HARMONICS, rotation

LAGS = 8
_LEFT = 0.1  # share of the variance left by a parabola
_SURE = 5.0  # standard errors of the line through differences of cycles
_LATE = 0.2  # of the change, in the later half
_NONE = 1e-13  # rounding of a logarithm, and more than the sum of squares of many
_LONGEST = 0.99  # of the change between two thirds, the largest share that the next third is taken to repeat


def _still_changes(figures: Array) -> bool:
    """Whether the cycles with these `figures` (cycles, 5) approach or leave a limit exponentially, or drift; by the logarithms of
    the figures, or, where they change sign, by themselves over their mean size."""
    sizes, positive = np.abs(figures).mean(axis=0), (figures > 0.0).all(axis=0)
    values = np.where(positive, np.log(np.where(positive, figures, 1.0)), figures / np.where(sizes > 0.0, sizes, 1.0))
    steps = np.diff(values, axis=0)
    one_way = ((steps > 0.0).all(axis=0) | (steps < 0.0).all(axis=0)).all()
    lags = range(1, min(LAGS, len(values) // 4) + 1)
    return bool(one_way) or any(_shrinks(values, lag) or _drifts(values, lag) for lag in lags)


def _goes_on(periods: Array, within: float) -> bool:
    """Whether means over successive periods (periods, 5) will still change by more than `within`, relative to their size: by the
    sum of the geometric series that the changes between their thirds begin."""
    if len(periods) < 3:
        return False
    early, late = _thirds(periods)
    scatter = np.sqrt(np.mean(np.diff(periods, n=2, axis=0) ** 2, axis=0) / 3.0) if len(periods) > 3 else 0.0
    onwards = (early * late > 0.0) & (np.abs(late) > 3.0 * scatter)
    share = np.minimum(np.abs(late) / np.where(early == 0.0, 1.0, np.abs(early)), _LONGEST)
    return bool((onwards & (np.abs(late) * share / (1.0 - share) > within)).any())


def _thirds(values: Array) -> Array:
    """The changes (2, ...) between the means of the thirds of `values` (n, ...), after omitting up to two at the beginning."""
    third = len(values) // 3
    return np.diff(values[-3 * third :].reshape(3, third, *values.shape[1:]).mean(axis=1), axis=0)


def _line(values: Array) -> tuple[float, float, float]:
    """The straight line through `values` (n,), by least squares: its change from the first to the last, the standard error of
    that change, and the share of the variance that it explains."""
    ramp, deviations = np.linspace(-0.5, 0.5, values.size), values - values.mean()
    change = float(ramp @ values / (ramp @ ramp))
    left = deviations - change * ramp
    error = float(np.sqrt(left @ left / max(values.size - 2, 1) / (ramp @ ramp)))
    variance = float(deviations @ deviations)
    return change, error, 1.0 - float(left @ left) / variance if variance > 0.0 else 0.0


def _shrinks(values: Array, lag: int) -> bool:
    """Whether the differences of cycles `lag` apart shrink or grow exponentially."""
    apart = np.log(np.maximum(np.abs(values[lag:] - values[:-lag]).max(axis=1), _NONE))
    if apart.size < 4:
        return bool(apart.size > 1 and apart[-1] < apart[0] - np.log(2.0) and (np.diff(apart) < 0.0).all())
    change, error, _ = _line(apart)
    late, later, _ = _line(apart[apart.size // 2 :])
    lasts = late * change > 0.0 and abs(late) >= max(_LATE * abs(change), later)
    return lasts and abs(change) >= max(np.log(2.0), _SURE * error)


def _drifts(values: Array, lag: int) -> bool:
    """Whether the sequences of every `lag`-th cycle are straight (parabolas for a lag of 1), in most of the figures."""
    if len(values) < max(8, 6 * lag):
        return False
    before, after = np.zeros(values.shape[1]), np.zeros(values.shape[1])
    for k in range(lag):
        rows = values[k::lag]
        powers = np.vander(np.linspace(-1.0, 1.0, len(rows)), 3 if lag == 1 else 2)
        before += np.sum((rows - rows.mean(axis=0)) ** 2, axis=0)
        after += np.sum((rows - powers @ np.linalg.lstsq(powers, rows, rcond=None)[0]) ** 2, axis=0)
    return bool(2 * np.count_nonzero((before > _NONE) & (after <= _LEFT * before)) > values.shape[1])


def _narrows(figures: Array) -> bool:
    """Whether the later cycles of many vary less than the earlier ones in every figure, by halves and by thirds: a swing that
    decays too fast, or of too many frequencies, for the differences of cycles to lie on a line."""
    parts = (len(figures) // 2, len(figures) // 3)
    return all((np.std(figures[-part:], axis=0) < _NARROWS * np.std(figures[:part], axis=0)).all() for part in parts)


Kind: TypeAlias = Literal[
    "steady", "decaying", "growing", "settling", "periodic", "torus", "irregular", "driven", "protocol", "too short"
]

REPEATING: tuple[Kind, ...] = ("periodic", "torus", "irregular")
"""Verdicts on motions that are represented by means over cycles."""

_FEWEST = 3
REPEATS = 1e-3
_MOST_EVENTS = 8  # in one period
_SMALL = 1.2
_FEW, _STRAIGHT = 8, (0.98, 0.9)  # share of the variance that is exponential, of fewer events than 8 and of others
_CHANGED = 0.2  # in the logarithm of the prominence
_KEEPS = 0.8  # of the rate of growth from third to third of the window
_HALF = 0.5  # of the last prominence: the largest limit of a motion that decays
_STEEP, _ENOUGH = 1.0, 6  # fall of the logarithm from third to third, and events, in which a limit is looked for
_SLIDES = 1e-6
_SMOOTH, _ROUND = 0.04, 24  # misfit of a torus, and its fewest cycles; of chaos 0.05 or more in these, in fewer down to 0.005
_STAYS, _ERRORS = 0.03, 4.0  # largest change of the amplitude of a torus over its cycles, itself or in its standard errors
_NOISE, _VAGUE = 0.3, 0.5  # misfits from which it is none: of all harmonics, of those that the cycles resolve
_CLEAR = 0.15  # misfit below which the change of an amplitude has a meaning
_CLEARLY, _CLOSELY = 0.1, 0.01  # differences from period to period, over those within one, of up to 8 events and of more
_NARROWS = 2.0 / 3.0  # of the spread of earlier cycles: of 100 runs of chaos the later ones of 3 have less


class MotionVerdict(NamedTuple):
    """`cycles`: complete cycles in the second half. `multiplicity`: events in a period, if periodic. `change`: largest relative
    difference of a figure between the last two cycles, or of the prominence between the first and the last event if decaying or
    growing; NaN if there are too few. `needed`: length (transits) of a run with enough cycles if this one is too short, else NaN.
    `rotation`: the share of a turn by which a torus advances in a cycle, else None. `rate`: slope of the logarithm of the elastic
    stress drop over the dates (least squares), per transit, if decaying or growing, else NaN."""

    kind: Kind
    cycles: int
    multiplicity: int | None = None
    change: float = np.nan
    needed: float = np.nan
    rotation: float | None = None
    rate: float = np.nan

    @property
    def repeats(self) -> bool:
        """Whether means over the cycles represent the motion, which is no transient."""
        return self.kind in REPEATING

    @property
    def wanders(self) -> bool:
        """Whether the cycles never repeat, so that their means have margins."""
        return self.kind in ("torus", "irregular")


def judge_motion(
    cycles: Events, prominence: Array, drive_rests: bool, slides: bool, until: float, ringing: float = np.inf
) -> MotionVerdict:
    """The verdict on a run to `until` (transits) whose second half has these `cycles` and these events' `prominence`;
    `drive_rests` is true if V is constant there and not zero, `slides` if v ends at V; `ringing`: see `EventObserver`."""
    count, figures = cycles.time.size, np.array(cycles[1:]).T
    if not drive_rests:
        return MotionVerdict("driven", count)
    if _SLIDES < ringing < _CHANGED:
        return MotionVerdict("decaying", count)
    alike = count > 0 and slides_at(float(cycles.v_max.max()), float(cycles.v_min.min()))
    if slides and (prominence.size == 0 or (alike and _trend(prominence, cycles) < _CHANGED)):
        return MotionVerdict("steady", count)
    if count < _FEWEST:
        return MotionVerdict("too short", count, needed=_needed(cycles, until, _FEWEST))
    change = float(np.max(np.abs(figures[-1] / figures[-2] - 1.0)))
    multiplicity = _multiplicity(figures)
    if multiplicity:
        return MotionVerdict("periodic", count, multiplicity, change)
    if trend := _trend(prominence, cycles):
        change = float(prominence[-1] / prominence[0] - 1.0)
        rate = float(np.polyfit(cycles.time - cycles.time[0], np.log(cycles.elastic_stress_drop), 1)[0])
        return MotionVerdict("growing" if trend > 0.0 else "decaying", count, change=change, rate=rate)
    kind, turned = _turns(cycles)
    if kind != "torus" and (kind == "settling" or _still_changes(figures) or (kind == "irregular" and _narrows(figures))):
        return MotionVerdict("settling", count, change=change)
    if count < MANY:
        kind = "too short"
    needed = _needed(cycles, until, max(MANY, 2 * (count >= MANY) * count)) if kind == "too short" else np.nan
    return MotionVerdict(kind, count, change=change, needed=needed, rotation=turned)


def slides_at(rate: float, velocity: float) -> bool:
    """Whether the slip rate is that of the drive."""
    return bool(abs(rate - velocity) <= _SLIDES * velocity)


def _multiplicity(figures: Array) -> int | None:
    """The smallest n for which every n-th cycle is the same, over at least two periods; None if there is none. For n up to 8 the
    later half of the cycles decides; larger n need all cycles. More than one event needs differences far below those within a
    period: a swing that decays passes near its start again, and a torus returns arbitrarily closely."""
    count = len(figures)
    later = figures[-max(_FEWEST, (count + 1) // 2) :]
    tried = min(_MOST_EVENTS, len(later) // 2)
    within = float(np.max(np.ptp(later, axis=0) / np.abs(later.mean(axis=0))))
    for n in range(1, tried + 1):
        if _repeats(later, n, REPEATS if n == 1 else min(REPEATS, _CLEARLY * within)):
            periods = len(later) // n
            means = later[-periods * n :].reshape(periods, n, -1).mean(axis=1)
            return None if _goes_on(means / np.abs(later.mean(axis=0)), REPEATS) else n
    own = float(np.max(np.std(figures, axis=0) / np.abs(figures.mean(axis=0))))
    return next((n for n in range(tried + 1, count // 2 + 1) if _repeats(figures, n, min(REPEATS, _CLOSELY * own))), None)


def repeating(cycles: Events, multiplicity: int) -> Events:
    """The longest run of last `cycles` in which every `multiplicity`-th agrees within `REPEATS`."""
    figures = np.array(cycles[1:]).T
    first, last = 0, len(figures) - 2 * multiplicity  # bisection: the more cycles, the larger their spread
    while first < last:
        middle = (first + last) // 2
        first, last = (first, middle) if _repeats(figures[middle:], multiplicity, REPEATS) else (middle + 1, last)
    return Events(*(column[first:] for column in cycles))


def _repeats(figures: Array, n: int, within: float) -> bool:
    """Whether every n-th cycle is the same: the relative spread of each figure over them is at most `within`."""
    if (np.abs(figures[-1] - figures[-1 - n]) > within * np.abs(figures).max(axis=0)).any():  # no spread is smaller than this
        return False
    return all(np.max(np.ptp(figures[k::n], axis=0) / np.abs(figures[k::n].mean(axis=0))) <= within for k in range(n))


def _trend(prominence: Array, cycles: Events) -> float:
    """Change of the logarithm of the prominence over the window, if it is exponential; else 0, and for fewer than 3 cycles."""
    if cycles.time.size < _FEWEST:
        return 0.0
    values, is_small = np.log(prominence), bool(cycles.v_max[-1] < _SMALL * cycles.v_min[-1])
    early, late = (float(part) for part in _thirds(values))
    change, _, straight = _line(values)
    if early * late <= 0.0 or straight < _STRAIGHT[values.size >= _FEW] or (abs(change) < _CHANGED and not is_small):
        return 0.0
    slower = late / early
    if late > 0.0:
        return change if slower >= _KEEPS else 0.0
    return change if _limit(values) <= _HALF else 0.0


def _limit(values: Array) -> float:
    """The limit of x = limit + A exp(-k t), over the last x, from the logarithms of x: its slope decreases. Of a steep fall only
    the last events are used: those with a change of at most `_STEEP` from third to third, but at least `_ENOUGH`."""
    while values.size >= 2 * _ENOUGH and _thirds(values)[1] < -_STEEP:
        values = values[values.size // 2 :]
    early, late = (float(part) for part in _thirds(values))
    if early >= 0.0 or late >= 0.0:
        return 0.0 if late < 0.0 else 1.0
    slower, fall = late / early, -0.5 * (early + late)
    there = (1.0 - slower) / (1.0 - slower * np.exp(-fall))  # over x between the two last thirds
    return float(there * np.exp(-late))


def _turns(cycles: Events) -> tuple[Kind, float | None]:
    """Kind of cycles that do not repeat, by their phases, and the rotation number of a torus. They are too few if the phase has
    hardly completed a turn, or if more cycles, hence more harmonics, may fit one phase."""
    torus = rotation(np.column_stack([cycles.period, cycles.v_max]))
    if torus is None or torus.misfit >= (_NOISE if torus.terms == torus.most else _VAGUE):
        return "irregular", None
    if torus.terms and torus.misfit < _CLEAR and abs(torus.change) > max(_STAYS, _ERRORS * torus.error):
        return "settling", None
    if torus.misfit < _SMOOTH and torus.terms and cycles.time.size >= _ROUND:
        return "torus", torus.number
    return "irregular" if torus.misfit >= _SMOOTH and torus.terms == MOST_HARMONICS else "too short", None


def _needed(cycles: Events, until: float, wanted: int) -> float:
    """Length of a run whose second half has `wanted` complete cycles and one to spare, from the longest cycle so far."""
    return max(2.0 * (wanted + 2) * float(cycles.period.max()), 1.5 * until) if cycles.time.size else 2.0 * until
