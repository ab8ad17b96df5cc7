"""Lengths of a run that its motion decides: until its second half has a number of cycles, or until its motion is settled.

Such a run is marched in stretches. At the end of each, the second half of the run so far is judged. The ends depend on the scene
alone and the judgement on the motion alone, so that a continued run ends where the uninterrupted one would.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, NamedTuple, TypeAlias

from slipwave.observe import Events, MotionVerdict, summarise
from slipwave.observe.torus import MANY
from slipwave.observe.verdict import REPEATS
from slipwave.scene import Scene
from slipwave.scene.drive import NUDGE_CENTRE, NUDGE_REACH
from validation.compute.outlook import LEFT_BY_ROUNDING, Outlook

Ended: TypeAlias = Literal["until", "cycles", "settled", "limit"]
"""Reason of the end of a run: at the given time, with the requested cycles, settled, or at the limit of work."""

LIMIT = 300.0
"""Longest run time (s), by a count of the work, of a run until it is settled."""

LONGEST_RUN = 1e9
"""Transits; the longest run."""

MOST_CYCLES = 1_000_000

_FIRST = 16.0  # expected cycles, half of them judged
_LONGER = 1.25  # from one look to the next
_DIES_OUT = 16.0  # decay times until 1e-7 of a disturbance is left
_ENOUGH = 8  # cycles that repeat
_STEP = 1.02  # from one look for cycles to the next, if a cycle is shorter


class JudgedHalf(NamedTuple):
    """The second half of a run `until` now (transits): its `cycles`, and the verdict, None if events are not recorded."""

    until: float
    verdict: MotionVerdict | None
    cycles: Events


@dataclass(frozen=True)
class UntilSettled:
    """Run until the motion is no longer a transient, as far as its cycles show. No stretch is begun beyond which the whole run
    would take more than `most_seconds`.

    Cycles that repeat are settled if there are 8 or more, cycles that never repeat if there are 16 or more, and if the means of
    period and stress drop over the earlier and the later half of them agree: within 1e-3, or within the margins of cycles that
    never repeat. A decaying run is settled if steady sliding is stable; a driven run always.
    """

    scene: Scene
    expected: Outlook
    most_seconds: float = LIMIT
    until: float = math.inf

    def ends(self, after: float) -> Iterator[float]:
        """The ends of its stretches, rising, of a run that is at the time `after` (transits): the first after the start and 16
        expected cycles, long enough that the drive rests in its second half. Each later end is a quarter later."""
        changes = 0.0 if self.scene.drive.is_constant else self.scene.drive.times[-1]
        end = min(2.0 * (changes + NUDGE_CENTRE + NUDGE_REACH) + self._first(), LONGEST_RUN)
        while end <= LONGEST_RUN:
            if end > after:
                yield end
            end *= _LONGER

    def ended(self, now: JudgedHalf) -> Ended | None:
        """Reason to end the run here; None to continue."""
        return "settled" if self._settled(now) else None

    def _first(self) -> float:
        if math.isinf(self.expected.period):
            return 0.0
        dies_out = _DIES_OUT / -self.expected.rate if self.expected.stable else math.inf
        return min(dies_out, _FIRST * self.expected.period)

    def _settled(self, now: JudgedHalf) -> bool:
        if now.verdict is None:
            return True
        match now.verdict.kind:
            case "driven":
                return True
            case "steady":
                return self.expected.stable is not False or self.expected.rate * now.until > LEFT_BY_ROUNDING
            case "decaying":
                return self.expected.stable is not False
            case "periodic":
                return now.verdict.cycles >= max(_ENOUGH, 2 * (now.verdict.multiplicity or 1)) and halves_agree(now)
            case "torus" | "irregular":
                return now.verdict.cycles >= MANY and halves_agree(now)
        return False


def halves_agree(now: JudgedHalf) -> bool:
    """Whether period and stress drop have the same mean over the earlier and the later half of the cycles, each of whole
    periods: within 1e-3, or the larger of the margins if they never repeat."""
    assert now.verdict is not None
    events = now.verdict.multiplicity or 1
    half = now.verdict.cycles // (2 * events) * events
    parts = [Events(*(column[part] for column in now.cycles)) for part in (slice(-2 * half, -half), slice(-half, None))]
    earlier, later = (summarise(part, not now.verdict.wanders) for part in parts)
    for name in ("period", "stress_drop"):
        one, other = getattr(earlier, name).mean, getattr(later, name).mean
        margins = [getattr(part.margins, name) for part in (earlier, later) if now.verdict.wanders]
        if abs(one - other) > max([REPEATS * one, *margins]):
            return False
    return True


@dataclass(frozen=True)
class UntilCycles:
    """Run until the second half of the run so far has `wanted` complete cycles, checked once per expected cycle. Stable steady
    sliding ends it too, because no cycles will follow."""

    wanted: int
    expected: Outlook
    most_seconds: float = math.inf
    until: float = math.inf

    def ends(self, after: float) -> Iterator[float]:
        """As `UntilSettled`."""
        cycle = self.expected.period if math.isfinite(self.expected.period) else 1.0
        end = cycle
        while end < LONGEST_RUN:
            if end > after:
                yield end
            end = max(end + cycle, _STEP * end)

    def ended(self, now: JudgedHalf) -> Ended | None:
        """As `UntilSettled`."""
        if now.verdict is None or now.verdict.cycles >= self.wanted:
            return "cycles"
        return "settled" if now.verdict.kind == "steady" and self.expected.stable is not False else None
