"""One model on one scene from start to end: the run behind `slipwave run`, `compare` and `bench`."""

import logging
import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from slipwave.errors import NumericsError
from slipwave.friction import respond, steady_state, unknown_of
from slipwave.observe import EventObserver, Events, MotionVerdict, RunStatistics, judge_motion, slides_at, summarise
from slipwave.observe.events import NO_EVENTS
from slipwave.observe.stages import stages_of
from slipwave.observe.verdict import Kind, repeating
from slipwave.scene import Scene
from slipwave.scene.drive import Drive
from slipwave.solve import Energy, Final, Mark, Observer, Solver, follow
from slipwave.solve.checkpoint import Checkpoints
from slipwave.solve.follow import DAY, Foresight, require_time
from validation.compute.length import LEFT_BY_ROUNDING, Ended, JudgedHalf, Length, Until, second_half
from validation.compute.outlook import is_stable, outlook
from validation.compute.progress import progress

LONG = 60.0
"""Seconds from which on a cheaper model is named."""

_SOON = 5.0  # seconds after which the rest of the run is extrapolated
_DEAR = {"delay", "fd", "sbp", "fem", "dg"}


@dataclass(frozen=True)
class Run:
    """The result of a run of `solver` to `until` (transits), where it `ended` for one of four reasons. `starts` counts slip
    events, `verdict` is on the second half; both are None without a watch. `statistics` are of the second half's cycles, of none
    if they do not represent the motion. `wall_s` is in seconds; `failed` is empty, or says what, where and when the numerics
    failed or the user `stopped` it: the rest is then what was known by that time.
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
        """The verdict's word; None if events were not watched."""
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
    run's second half.

    `watch` is passed in if it has already seen the beginning of the run. A scene that records nothing is not watched for events.
    A NumericsError of the solver and an interruption do not escape: they are kept in `failed`, beside what was computed before.
    Raises SceneError if the run would take more than `most_seconds` (`slipwave.solve.follow`).
    """
    watch = watch or EventObserver(solver.scene, solver.nodes)
    wanted = Until(length) if isinstance(length, int | float) else length
    marched = _Marched(solver, watch, bool(solver.scene.record))
    failed, stopped, began = "", False, time.perf_counter()
    try:
        marched.march(wanted, observers, marks, most_seconds)
    except NumericsError as error:
        failed = str(error)
    except KeyboardInterrupt:
        failed, stopped = f"interrupted at t = {solver.time:.6g} of {marched.until:g} transits", True
    return marched.run(time.perf_counter() - began, failed, stopped)


class _Marched:
    """A run in stretches, judged at the end of each. `until` is the end of the last stretch begun (transits), `final` the state
    there and `ended` the reason, both None if it was not reached."""

    def __init__(self, solver: Solver, watch: EventObserver, watched: bool) -> None:
        self.solver, self.watch, self.watched = solver, watch, watched
        self.until = 0.0
        self.final: Final | None = None
        self._judged: JudgedHalf | None = None
        self.ended: Ended | None = None

    def march(self, length: Length, observers: Sequence[Observer], marks: Sequence[Mark], most: float) -> None:
        """To the end. Raises NumericsError where the solver fails, and SceneError if it would take more than `most` seconds."""
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
            with progress(f"{self.solver.scene.name}, {self.solver.model}", end) as report:
                self.final = follow(self.solver, end, everyone, LongRunAdvice(self.solver, end, report), marks)
            self._judged = self.judged()
            self.ended = length.ended(self._judged)
            if self.ended:
                return
        self.ended = "limit"

    def judged(self) -> JudgedHalf:
        """The second half of what was run so far, and the verdict on it."""
        half = second_half(self.solver, self.until)
        cycles = self.watch.events(half)
        return JudgedHalf(2.0 * half, self._verdict(half, cycles) if self.watched else None, cycles)

    def _verdict(self, half: float, cycles: Events) -> MotionVerdict:
        """On the second half of what was run, which begins at `half` (transits) and has these `cycles`."""
        drive, end = self.solver.scene.drive, 2.0 * half
        slides = self.final is not None and slides_at(math.exp(self.final.ln_v), drive.at(end))
        return judge_motion(cycles, self.watch.judge(half).complete, drive.rests_from(half), slides, end)

    def run(self, wall_s: float, failed: str, stopped: bool) -> Run:
        """What is known of it."""
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
    """`run`, whose verdict is not that of a lasting motion if steady sliding is unstable: what decays is then a transient that
    growing disturbances follow, and what still slides steadily has not had the time in which rounding alone would have left it.
    `model` is one with the one-port of the model that ran."""
    if run.kind not in ("steady", "decaying") or run.verdict is None or is_stable(run.solver.scene, model) is not False:
        return run
    if run.kind == "decaying":
        return replace(run, verdict=run.verdict._replace(kind="settling", rate=math.nan))
    grown = LEFT_BY_ROUNDING / outlook(run.solver.scene, model).rate
    return run if run.until > grown else replace(run, verdict=run.verdict._replace(kind="too short", needed=2.0 * grown))


def error_without_echoes(scene: Scene) -> float:
    """Largest relative change of v by one echo of a change of V, which quasidynamic leaves out: 2 Z v_z/F_z at the largest V."""
    velocity = max(scene.drive.velocities)
    slopes = respond(scene.law, unknown_of(scene.law, velocity), steady_state(scene.law, velocity))
    return float(2.0 * scene.impedance * slopes[1] / slopes[3])


class LongRunAdvice:
    """Takes how far a run of `solver` to `until` (transits) has come, for `report`; says once that it is long, and names the
    cheaper model with its estimated error."""

    def __init__(self, solver: Solver, until: float, report: Callable[[float], None]) -> None:
        self._solver, self._until, self._report = solver, until, report
        self._first: tuple[float, float] | None = None
        elastic = all(slab.viscosity is None for slab in solver.scene.slabs)
        self._silent = solver.model.partition(":")[0] not in _DEAR or not elastic

    def __call__(self, done: float) -> None:
        """The time `done` (transits) is reached."""
        self._report(done)
        now = time.monotonic()
        began, start = self._first = self._first or (now, done)  # what came before may have been compilation
        if self._silent or now - began < _SOON or done <= start:
            return
        self._silent = True
        seconds = (now - began) * (self._until - start) / (done - start)
        if seconds > LONG:
            logging.getLogger("slipwave").info(
                "this run will take about %.0f s; --model quasidynamic is cheaper and leaves out the echoes of waves, each of "
                "which changes v by up to %.1g of itself (estimated; more where the motion stick-slips)",
                seconds,
                error_without_echoes(self._solver.scene),
            )
