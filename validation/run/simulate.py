"""One model on one scene from start to end: the run behind `slipwave run`, `compare` and `bench`."""

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass

from slipwave.errors import NumericsError
from slipwave.observe import (
    Energy,
    EventObserver,
    Events,
    Final,
    RunStatistics,
    Solver,
    Verdict,
    follow,
    judge_motion,
    slides_at,
    summarise,
)
from slipwave.observe.follow import Mark, Observer
from slipwave.observe.foresight import DAY, Foresight, require_time
from slipwave.observe.verdict import Kind
from slipwave.scene import Scene
from validation.run.progress import progress


@dataclass(frozen=True)
class Run:
    """The result of a run of `solver` to `until` (transits). `starts` counts slip events, `verdict` is on the second half;
    both are None without a watch. `statistics` are of the second half's cycles, of none if they do not repeat. `wall_s` is in
    seconds; `failed` is empty, or says what, where and when the numerics failed: the rest is then what was known by that time.
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
    until: float,
    observers: Sequence[Observer] = (),
    most_seconds: float = DAY,
    watch: EventObserver | None = None,
    marks: Sequence[Mark] = (),
) -> Run:
    """March `solver` to `until` (transits) with progress on stderr; statistics are those of the run's second half.

    `watch` is passed in if it has already seen the beginning of the run. A scene that records nothing is not watched for events.
    A NumericsError of the solver does not escape: it is kept in `failed`, beside what was computed before. Raises RunInterrupted
    with the same if the user stops it, and SceneError if the run would take more than `most_seconds`
    (`slipwave.observe.foresight`).
    """
    require_time(solver, until, most_seconds)
    watching = [*observers, Foresight(solver, until, most_seconds)] if math.isnan(solver.transits_per_piece) else list(observers)
    watch = watch or EventObserver(solver.scene, solver.nodes)
    watched = bool(solver.scene.record)
    final: Final | None = None
    failed, stopped = "", False
    began = time.perf_counter()
    try:
        with progress(f"{solver.scene.name}, {solver.model}", until) as report:
            final = follow(solver, until, [watch, *watching] if watched else watching, report, marks)
    except NumericsError as error:
        failed = str(error)
    except KeyboardInterrupt:
        failed, stopped = f"interrupted at t = {solver.time:.6g} of {until:g} transits", True
    wall = time.perf_counter() - began
    half = second_half(solver, until)
    verdict = _judge(watch, solver.scene, half, final) if watched else None
    statistics = summarise(watch.events(half if verdict and verdict.repeats else math.inf))
    energy = None if failed else solver.energy()
    done = Run(solver, until, watch.events(), watch.count if watched else None, verdict, statistics, final, energy, wall, failed)
    if stopped:
        raise RunInterrupted(done)
    return done


def second_half(solver: Solver, until: float) -> float:
    """When the second half of a run to `until` (transits) begins; of what was run, if the run ended before."""
    return 0.5 * min(until, solver.time)


def _judge(watch: EventObserver, scene: Scene, half: float, final: Final | None) -> Verdict:
    """The verdict on the second half of a run, which begins at `half` (transits)."""
    end = 2.0 * half
    slides = final is not None and slides_at(math.exp(final.ln_v), scene.drive.at(end))
    return judge_motion(watch.events(half), watch.judge(half).prominence, scene.drive.rests_from(half), slides, end)
