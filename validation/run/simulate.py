"""One model on one scene from start to end: the run behind `slipwave run`, `compare` and `bench`."""

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

from slipwave.errors import NumericsError
from slipwave.observe import EventObserver, Events, RunStatistics, Verdict, summarise
from slipwave.observe.stages import stages_of
from slipwave.observe.verdict import Kind, repeating
from slipwave.scene.drive import Drive
from slipwave.solve import Energy, Final, Mark, Observer, Solver
from slipwave.solve.foresight import DAY
from validation.run.course import Course
from validation.run.length import LEFT, Ended, Length, Until
from validation.run.outlook import outlook


@dataclass(frozen=True)
class Run:
    """The result of a run of `solver` to `until` (transits), where it `ended` for one of four reasons. `starts` counts slip
    events, `verdict` is on the second half; both are None without a watch. `statistics` are of the second half's cycles, of none
    if they do not represent the motion. `wall_s` is in seconds; `failed` is empty, or says what, where and when the numerics
    failed: the rest is then what was known by that time.
    """

    solver: Solver
    until: float
    events: Events
    starts: int | None
    verdict: Verdict | None
    statistics: RunStatistics
    final: Final | None
    energy: Energy | None
    wall_s: float
    failed: str = ""
    ended: Ended | None = "until"

    @property
    def kind(self) -> Kind | None:
        """The verdict's word; None if events were not watched."""
        return self.verdict.kind if self.verdict else None

    def errors(self, reference: "Run") -> dict[str, float]:
        """Relative errors of the mean period and stress drop; NaN where a run has none, or failed."""
        ours, theirs = self.statistics, reference.statistics
        found = {name: getattr(ours, name).mean / getattr(theirs, name).mean - 1.0 for name in ("period", "stress_drop")}
        return dict.fromkeys(found, math.nan) if self.failed else found


class RunInterrupted(KeyboardInterrupt):
    """The user stopped a run; `run` is what was known by then, its statistics those of the second half of what was run."""

    def __init__(self, run: Run) -> None:
        super().__init__(run.failed)
        self.run = run


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
    A NumericsError of the solver does not escape: it is kept in `failed`, beside what was computed before. Raises RunInterrupted
    with the same if the user stops it, and SceneError if the run would take more than `most_seconds`
    (`slipwave.solve.foresight`).
    """
    watch = watch or EventObserver(solver.scene, solver.nodes)
    wanted = Until(length) if isinstance(length, int | float) else length
    course = Course(solver, wanted, watch, observers, marks, most_seconds)
    failed, stopped = "", False
    began = time.perf_counter()
    try:
        course.march()
    except NumericsError as error:
        failed = str(error)
    except KeyboardInterrupt:
        failed, stopped = f"interrupted at t = {solver.time:.6g} of {course.until:g} transits", True
    done = _result(course, time.perf_counter() - began, failed)
    if stopped:
        raise RunInterrupted(done)
    return done


def reconsidered(run: Run, model: str) -> Run:
    """`run`, whose verdict is not that of a lasting motion if steady sliding is unstable: what decays is then a transient that
    growing disturbances follow, and what still slides steadily has not had the time in which rounding alone would have left it.
    `model` is one with the one-port of the model that ran."""
    if run.kind not in ("steady", "decaying") or run.verdict is None or outlook(run.solver.scene, model).stable is not False:
        return run
    if run.kind == "decaying":
        return replace(run, verdict=run.verdict._replace(kind="settling", rate=math.nan))
    grown = LEFT / outlook(run.solver.scene, model).rate
    return run if run.until > grown else replace(run, verdict=run.verdict._replace(kind="too short", needed=2.0 * grown))


def _of_protocol(verdict: Verdict | None, drive: Drive, until: float) -> Verdict | None:
    """`verdict`, or "protocol" where the second half of a run to `until` (transits) of a drive that changes holds no cycles that
    repeat or wander, but a stage of constant V to judge."""
    levels = [stage for stage in stages_of(drive, until) if stage.kind not in ("ramp", "hold") and stage.end > 0.5 * until]
    return verdict._replace(kind="protocol") if verdict and not verdict.repeats and levels else verdict


def _result(course: Course, wall_s: float, failed: str) -> Run:
    solver, watch, judged = course.solver, course.watch, course.judged()
    verdict, cycles = _of_protocol(judged.verdict, solver.scene.drive, course.until), watch.events(math.inf)
    if verdict and verdict.repeats:
        cycles = repeating(judged.cycles, verdict.multiplicity) if verdict.multiplicity else judged.cycles
    return Run(
        solver=solver,
        until=course.until,
        events=watch.events(),
        starts=watch.count if verdict else None,
        verdict=verdict,
        statistics=summarise(cycles, not (verdict and verdict.wanders)),
        final=course.final,
        energy=None if failed else solver.energy(),
        wall_s=wall_s,
        failed=failed,
        ended=None if failed else course.ended,
    )
