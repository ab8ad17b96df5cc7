"""One model on one scene from start to end, as `slipwave run`, `compare` and `bench` need it: how long it is, the march, the
verdict.

A run lasts to a given time, until its second half has a number of cycles, or until its motion is settled. Where the motion
decides, it is marched in stretches. At the end of each, the second half of the run so far is judged. The ends depend on the scene
alone and the judgement on the motion alone, so that a continued run ends where the uninterrupted one would.
"""

import math
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Literal, NamedTuple, TypeAlias

from slipwave.errors import NumericsError
from slipwave.observe import EventObserver, Events, MotionVerdict, RunStatistics, judge_motion, slides_at, summarise
from slipwave.observe.events import NO_EVENTS
from slipwave.observe.protocol import stages_of
from slipwave.observe.torus import MANY
from slipwave.observe.verdict import REPEATS, Kind, repeating
from slipwave.scene import Scene
from slipwave.scene.drive import NUDGE_CENTRE, NUDGE_REACH, Drive
from slipwave.solve import Energy, Final, Mark, Observer, Solver, follow
from slipwave.solve.checkpoint import Checkpoints
from slipwave.solve.follow import DAY, Foresight, require_time
from validation.models.outlook import LEFT_BY_ROUNDING, is_stable, outlook
from validation.models.progress import LongRunAdvice, progress, share_of_run

if TYPE_CHECKING:
    pass


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

    @property
    def halves_agree(self) -> bool:
        """Whether period and stress drop have the same mean over the earlier and the later half of the cycles, each of whole
        periods: within 1e-3, or the larger of the margins if they never repeat."""
        assert self.verdict is not None
        events = self.verdict.multiplicity or 1
        half = self.verdict.cycles // (2 * events) * events
        parts = [Events(*(column[part] for column in self.cycles)) for part in (slice(-2 * half, -half), slice(-half, None))]
        earlier, later = (summarise(part, not self.verdict.wanders) for part in parts)
        for name in ("period", "stress_drop"):
            one, other = getattr(earlier, name).mean, getattr(later, name).mean
            margins = [part.margins[name] for part in (earlier, later) if self.verdict.wanders]
            if abs(one - other) > max([REPEATS * one, *margins]):
                return False
        return True


@dataclass(kw_only=True)
class Length:
    """How long a run is: to the time `until` (transits). No stretch is begun beyond which the whole run would take more than
    `most_seconds`."""

    until: float = math.inf
    most_seconds: float = math.inf

    def ends(self, after: float) -> Iterator[float]:
        """The ends of its stretches, rising, of a run that is at the time `after` (transits)."""
        yield self.until

    def ended(self, now: JudgedHalf) -> Ended | None:
        """Reason to end the run here; None to continue."""
        return "until"


@dataclass
class UntilSettled(Length):
    """Run until the motion is no longer a transient, as far as its cycles show, at most to `until`. `model` is one with the
    one-port of the model that runs.

    Cycles that repeat are settled if there are 8 or more, cycles that never repeat if there are 16 or more, and if the means of
    period and stress drop over the earlier and the later half of them agree: within 1e-3, or within the margins of cycles that
    never repeat. A decaying run is settled if steady sliding is stable; a driven run always.
    """

    scene: Scene
    model: str
    most_seconds: float = field(default=LIMIT, kw_only=True)

    def ends(self, after: float) -> Iterator[float]:
        """As `Length`: a quarter of a given time, a half and the whole. Else the first is after the start and 16 expected cycles,
        late enough that the drive rests in the second half, and each later one is a quarter later."""
        if math.isfinite(self.until):
            yield from (end for end in (0.25 * self.until, 0.5 * self.until, self.until) if end > after)
            return
        changes = 0.0 if self.scene.drive.is_constant else self.scene.drive.times[-1]
        expected, first = outlook(self.scene, self.model), 0.0
        if math.isfinite(expected.period):
            dies_out = _DIES_OUT / -expected.rate if expected.stable else math.inf
            first = min(dies_out, _FIRST * expected.period)
        end = min(2.0 * (changes + NUDGE_CENTRE + NUDGE_REACH) + first, LONGEST_RUN)
        while end <= LONGEST_RUN:
            if end > after:
                yield end
            end *= _LONGER

    def ended(self, now: JudgedHalf) -> Ended | None:
        """As `Length`. Only a motion without cycles needs the roots of steady sliding."""
        return "settled" if self._settled(now) else None

    def _settled(self, now: JudgedHalf) -> bool:
        if now.verdict is None:
            return True
        match now.verdict.kind:
            case "driven":
                return True
            case "decaying":
                return is_stable(self.scene, self.model) is not False
            case "steady":
                if is_stable(self.scene, self.model) is not False:
                    return True
                return outlook(self.scene, self.model).rate * now.until > LEFT_BY_ROUNDING
            case "periodic":
                return now.verdict.cycles >= max(_ENOUGH, 2 * (now.verdict.multiplicity or 1)) and now.halves_agree
            case "torus" | "irregular":
                return now.verdict.cycles >= MANY and now.halves_agree
        return False


@dataclass
class UntilCycles(Length):
    """Run until the second half of the run so far has `wanted` complete cycles, checked once per expected cycle. Stable steady
    sliding ends it too, because no cycles will follow. `model` as for `UntilSettled`."""

    wanted: int
    scene: Scene
    model: str

    def ends(self, after: float) -> Iterator[float]:
        """As `Length`."""
        period = outlook(self.scene, self.model).period
        end = cycle = period if math.isfinite(period) else 1.0
        while end < LONGEST_RUN:
            if end > after:
                yield end
            end = max(end + cycle, _STEP * end)

    def ended(self, now: JudgedHalf) -> Ended | None:
        """As `Length`."""
        if now.verdict is None or now.verdict.cycles >= self.wanted:
            return "cycles"
        return "settled" if now.verdict.kind == "steady" and is_stable(self.scene, self.model) is not False else None


def length_of(scene: Scene, model: str, cycles: int | None = None) -> Length:
    """The length of a run: `cycles` if given, else that of the scene, else until settled. `model`: one with the one-port of the
    model that runs."""
    if cycles is not None:
        return UntilCycles(cycles, scene, model)
    if scene.until is not None:
        return Length(until=scene.until)
    settled = UntilSettled(scene, model)
    return settled if scene.record else Length(until=next(settled.ends(0.0)))


def needed(verdict: MotionVerdict | None, scene: Scene, model: str) -> float:
    """Length (transits) of a run with enough cycles, if this one is too short: from its cycles, else from the expected period;
    infinite if no run may be so long. `model` as for `length_of`."""
    if verdict is None or verdict.cycles or verdict.kind != "too short":
        return verdict.needed if verdict else math.nan
    expected = next(UntilSettled(scene, model).ends(0.0))
    return max(verdict.needed, expected) if expected < LONGEST_RUN else math.inf


def second_half(solver: Solver, until: float) -> float:
    """Begin (transits) of the second half of a run to `until`, or of the run so far if it ended before."""
    return 0.5 * min(until, solver.time)


@dataclass(frozen=True)
class Run:
    """The result of a run of `solver` to `until` (transits), where it `ended` for one of four reasons. `starts`: number of slip
    events; `verdict` on the second half; both None if events are not recorded. `statistics`: of the second half's cycles, of none
    if they do not represent the motion. `wall_s` in seconds; `failed`: what, where and when the numerics failed or the user
    `stopped` the run, or empty: the rest is then what was computed before.
    """

    solver: Solver
    until: float
    events: Events
    starts: int | None
    verdict: MotionVerdict | None
    statistics: RunStatistics
    final: Final | None
    energy: Energy | None
    wall_s: float
    failed: str = ""
    ended: Ended | None = "until"
    stopped: bool = False

    @property
    def kind(self) -> Kind | None:
        """The kind of the verdict; None if events were not recorded."""
        return self.verdict.kind if self.verdict else None


def simulate(
    solver: Solver,
    length: float | Length,
    observers: Sequence[Observer] = (),
    most_seconds: float = DAY,
    watch: EventObserver | None = None,
    marks: Sequence[Mark] = (),
) -> Run:
    """March `solver` to the end of `length` (a number: so many transits) with progress on stderr; statistics are those of the
    run's second half. `watch`: the event observer of a continued run. Without anything to record, events are not observed. A
    NumericsError of the solver and an interruption are not raised but stored in `failed`, with what was computed before. Raises
    SceneError if the run would take more than `most_seconds` (`slipwave.solve.follow`).
    """
    watch = watch or EventObserver(solver.scene, solver.nodes)
    wanted = Length(until=length) if isinstance(length, int | float) else length
    marched = JudgedMarch(solver, watch, bool(solver.scene.record))
    failed, stopped, began = "", False, time.perf_counter()
    try:
        marched.to(wanted, observers, marks, most_seconds)
    except NumericsError as error:
        failed = str(error)
    except KeyboardInterrupt:
        failed, stopped = f"interrupted at t = {solver.time:.6g} of {marched.until:g} transits", True
    return marched.run(time.perf_counter() - began, failed, stopped)


class JudgedMarch:
    """A run of `solver` in stretches, judged at the end of each by the events of `watch`, if it is `watched`. `until`: end of the
    last stretch begun (transits); `final`, the state there, and `ended`, the reason, are None if it was not reached."""

    def __init__(self, solver: Solver, watch: EventObserver, watched: bool = True) -> None:
        self.solver, self.watch, self.watched = solver, watch, watched
        self.until = 0.0
        self.final: Final | None = None
        self._judged: JudgedHalf | None = None
        self.ended: Ended | None = None

    def to(self, length: Length, observers: Sequence[Observer] = (), marks: Sequence[Mark] = (), most: float = DAY) -> None:
        """March to the end of `length`. Raises NumericsError where the solver fails, and SceneError if it would take more than
        `most` seconds."""
        work = Foresight(self.solver, 0.0, most)
        everyone = [*([self.watch] if self.watched else []), *observers, work]
        for end in length.ends(self.solver.time):
            if work.seconds(end) > length.most_seconds:
                break
            require_time(self.solver, end, most)
            self.until, self.final, self._judged = end, None, None
            work.until = end
            for mark in marks:
                if isinstance(mark, Checkpoints):
                    mark.until = end
            share = share_of_run(self.solver.scene.drive, end)
            with progress(f"{self.solver.scene.name}, {self.solver.model}", end, share) as report:
                self.final = follow(self.solver, end, everyone, LongRunAdvice(self.solver, share, report), marks)
            self._judged = self.judged()
            self.ended = length.ended(self._judged)
            if self.ended:
                return
        self.ended = "limit"

    def judged(self) -> JudgedHalf:
        """The second half of the run so far, and the verdict on it."""
        half = second_half(self.solver, self.until)
        cycles, drive, end = self.watch.events(half), self.solver.scene.drive, 2.0 * half
        if not self.watched:
            return JudgedHalf(end, None, cycles)
        slides = self.final is not None and slides_at(self.final.v, drive.at(end))
        rests = drive.rests_from(half)
        ringing = self.watch.ringing(drive.at(end), half) if rests else math.inf
        verdict = judge_motion(cycles, self.watch.judge(half).complete, rests, slides, end, ringing)
        return JudgedHalf(end, verdict, cycles)

    def run(self, wall_s: float, failed: str, stopped: bool) -> Run:
        """The result so far."""
        solver, watch, judged = self.solver, self.watch, self._judged or self.judged()
        verdict, cycles = _of_protocol(judged.verdict, solver.scene.drive, self.until), judged.cycles
        if not (verdict and verdict.repeats):
            cycles = NO_EVENTS
        elif verdict.multiplicity:
            cycles = repeating(cycles, verdict.multiplicity)
        return Run(
            solver=solver,
            until=self.until,
            events=watch.events(),
            starts=watch.count if verdict else None,
            verdict=verdict,
            statistics=summarise(cycles, not (verdict and verdict.wanders)),
            final=self.final,
            energy=None if failed else solver.energy(),
            wall_s=wall_s,
            failed=failed,
            ended=None if failed else self.ended,
            stopped=stopped,
        )


def _of_protocol(verdict: MotionVerdict | None, drive: Drive, until: float) -> MotionVerdict | None:
    """`verdict`, or "protocol" where the second half of a run to `until` (transits) of a drive that changes holds no cycles that
    repeat or wander, but a stage of constant V to judge."""
    if verdict is None or verdict.repeats:
        return verdict
    levels = [stage for stage in stages_of(drive, until) if stage.kind not in ("ramp", "hold") and stage.end > 0.5 * until]
    return verdict._replace(kind="protocol") if levels else verdict


def reconsidered(run: Run, model: str) -> Run:
    """`run` with a corrected verdict if steady sliding is unstable: a decay is then a transient before growth, and steady sliding
    lasts only until rounding has grown. `model` is one with the one-port of the model that ran."""
    if run.kind not in ("steady", "decaying") or run.verdict is None or is_stable(run.solver.scene, model) is not False:
        return run
    if run.kind == "decaying":
        return replace(run, verdict=run.verdict._replace(kind="settling", rate=math.nan))
    grown = LEFT_BY_ROUNDING / outlook(run.solver.scene, model).rate
    return run if run.until > grown else replace(run, verdict=run.verdict._replace(kind="too short", needed=2.0 * grown))
