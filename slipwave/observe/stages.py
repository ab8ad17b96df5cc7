"""The stages of a laboratory protocol: the stretches between the knots of the drive, and what is measured in each.

    start   the sliding before anything changes
    step    V jumps from one velocity to another and stays
    hold    V is 0
    slide   V is positive again after a hold
    ramp    V changes throughout
    level   V stays at the end of a ramp

A stage has settled if it ends within the run and, in its last tenth, the slip rate is within 1 % of V. It stick-slips if it has
not settled and the slip rate changes by more than a factor e in its third quarter and in its last, there as much as before: a
ringing that decays changes less. Figures that need a settled stage are None where it has not
settled; all are None where it stick-slips.
"""

import math
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, Literal, NamedTuple, TypeAlias

from slipwave.observe.pieces import slack
from slipwave.scene.drive import Drive

StageKind: TypeAlias = Literal["start", "step", "hold", "slide", "ramp", "level"]

LATE = 0.1
"""The share of a stage, at its end, in which it must be steady to have settled."""

STEADY = 0.01
"""Largest |ln(v/V)| there."""

_STICKS = 1.0  # range of ln v in both later quarters of a stage that stick-slips
_LASTS = 0.9  # that of the last quarter, over that of the third


class Stage(NamedTuple):
    """A stretch of the drive from `start` to `end` (transits); V (in V*) `before` it, and at its end."""

    kind: StageKind
    start: float
    end: float
    before: float
    velocity: float

    @property
    def sign(self) -> float:
        """1 if friction first rises in the stage, -1 if it falls: the sign of the change of V, by the direct effect."""
        return 1.0 if self.velocity >= self.before else -1.0


class MeasuredStage(NamedTuple):
    """Measured in a stage so far: friction stress just `before` it, at its `peak` (the lowest where friction falls first) and
    `last`; slip in L since the stage began, `peak_slip` at the peak and `recovered` where the stress had recovered (NaN: not
    yet); the lowest and highest ln v in its third and fourth quarter and in the last tenth; the time reached (transits)."""

    before: float = math.nan
    peak: float = math.nan
    last: float = math.nan
    peak_slip: float = math.nan
    recovered: float = math.nan
    third: tuple[float, float] = (math.inf, -math.inf)
    fourth: tuple[float, float] = (math.inf, -math.inf)
    late: tuple[float, float] = (math.inf, -math.inf)
    reached: float = -math.inf


@dataclass(frozen=True)
class StageFigures:
    """A stage and its figures, stresses in units of the normal stress, slip in L; None where there is no value.

    `steady_stress`: friction at the end of a settled stage. `direct_effect`: peak minus the stress before the step; `evolution`:
    peak minus the new steady stress (a ln(V2/V1) and b ln(V2/V1) of a stiff loading; both negative where V falls).
    `slip_to_recovery`: slip from the peak until 1/e of that is left. `relaxation`: the stress before a hold minus that at its
    end. `healing`: the peak after a hold minus the stress before it.
    """

    kind: StageKind
    start: float
    end: float
    velocity: float
    steady_stress: float | None = None
    direct_effect: float | None = None
    evolution: float | None = None
    slip_to_recovery: float | None = None
    relaxation: float | None = None
    healing: float | None = None
    stick_slips: bool = False


def stages_of(drive: Drive, until: float) -> list[Stage]:
    """The stages of a run to `until` (transits); none if V never changes."""
    if drive.is_constant:
        return []
    knots = [(0.0, drive.initial), *zip(drive.times, drive.velocities, strict=True), (until, drive.velocities[-1])]
    stages: list[Stage] = []
    for (start, first), (end, last) in pairwise(knots):
        if start < min(end, until):
            _append(stages, start, min(end, until), first, last)
    return stages


def _append(stages: list[Stage], start: float, end: float, first: float, last: float) -> None:
    """Add a straight stretch of V; a stretch that continues the last stage prolongs it."""
    before = stages[-1].velocity if stages else first
    if first != last:
        stages.append(Stage("ramp", start, end, before, last))
    elif stages and stages[-1].kind != "ramp" and before == last:
        stages[-1] = stages[-1]._replace(end=end)
    else:
        stages.append(Stage(_kind_of(stages, before, last), start, end, before, last))


def _kind_of(stages: list[Stage], before: float, velocity: float) -> StageKind:
    if velocity == 0.0:
        return "hold"
    if not stages:
        return "start"
    if before == 0.0:
        return "slide"
    return "level" if stages[-1].kind == "ramp" and before == velocity else "step"


def stage_figures(stages: list[Stage], seen: list[MeasuredStage]) -> list[StageFigures]:
    """The figures of the stages that the run has begun. A stage shorter than a step of the run, which lies in none, has no
    figures."""
    figures: list[StageFigures] = []
    begun = max((k + 1 for k, here in enumerate(seen) if here.reached > -math.inf), default=0)
    for k in range(begun):
        figures.append(_figures(stages[k], seen[k], figures[k - 1] if k else None, seen[k - 1].before if k else math.nan))
    return figures


def _figures(stage: Stage, seen: MeasuredStage, earlier: StageFigures | None, before_hold: float) -> StageFigures:
    is_over = seen.reached >= stage.end - slack(stage.end)
    slides = stage.velocity > 0.0 and stage.kind != "ramp"  # at one velocity
    settled = slides and is_over and max(abs(ln_v - math.log(stage.velocity)) for ln_v in seen.late) < STEADY
    facts = StageFigures(stage.kind, stage.start, stage.end, stage.velocity)
    if seen.reached == -math.inf:
        return facts
    third, fourth = (high - low for low, high in (seen.third, seen.fourth))  # -inf without values
    if slides and not settled and min(third, fourth) > _STICKS and fourth >= _LASTS * third:
        return replace(facts, stick_slips=True)
    numbers: dict[str, Any] = {"steady_stress": seen.last} if settled else {}
    was_steady = earlier is not None and earlier.steady_stress is not None
    if stage.kind == "hold" and was_steady:
        numbers["relaxation"] = seen.before - seen.last
    if stage.kind == "slide" and earlier is not None and earlier.relaxation is not None:
        numbers["healing"] = seen.peak - before_hold
    if stage.kind == "step" and was_steady:
        numbers["direct_effect"] = seen.peak - seen.before
        if settled:
            numbers["evolution"] = seen.peak - seen.last
    if stage.kind in ("step", "slide") and not math.isnan(seen.recovered):
        numbers["slip_to_recovery"] = seen.recovered - seen.peak_slip
    return replace(facts, **numbers)
