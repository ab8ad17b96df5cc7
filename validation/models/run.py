"""One model on one scene from start to end, as `slipwave run`, `compare` and `bench` need it: what is kept of it, the march, the
verdict.

Where the motion decides how long it is (`validation.models.outlook`), it is marched in stretches. At the end of each, the second
half of the run so far is judged. The ends depend on the scene alone and the judgement on the motion alone, so that a continued
run ends where the uninterrupted one would.

Kept are events, the envelope for its figure, and if it is asked the interface's history, the fields of the last transits,
checkpoints.
"""

import math
import os
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from slipwave.errors import NumericsError, SceneError
from slipwave.files import part_of, remove_leftovers, require_writable
from slipwave.friction.law import name_of
from slipwave.input.assemble import moment
from slipwave.input.wording import shorten
from slipwave.observe import EventObserver, Events, MotionVerdict, RunStatistics, judge_motion, slides_at, summarise
from slipwave.observe.envelope import Envelope
from slipwave.observe.events import NO_EVENTS
from slipwave.observe.protocol import ProtocolObserver, stages_of
from slipwave.observe.verdict import Kind, repeating
from slipwave.scene import Scene
from slipwave.scene.drive import Drive
from slipwave.solve import Energy, FieldSolver, Final, Mark, Observer, Resumable, Solver, follow
from slipwave.solve.checkpoint import Checkpoints
from slipwave.solve.follow import DAY, Foresight, named_observers, require_time
from validation.models.history_file import ALL, HistoryFile, Kept
from validation.models.outlook import LEFT_BY_ROUNDING, Ended, JudgedHalf, Length, growth_rate, is_stable
from validation.models.own import digests
from validation.models.progress import LongRunAdvice, progress, share_of_run

if TYPE_CHECKING:
    from fullwave.fields.record import FieldRecord


MOST_CYCLES = 1_000_000

_EVERY = 1000.0  # transits between two checkpoints

FIELD_FILES = (".vtu", ".xdmf", ".nc")
"""Kinds of file that fields are written to."""

FIELD_WINDOW = 100.0
"""Transits before the end of the run whose fields are kept: more than a cycle of the paper's scenes, never all of a long run."""


class Records:
    """Records of a run: events by `watch`, the `envelope` for its figure, the stages of a `protocol`, and, if requested, the
    interface's `history`, the last `fields`, `checkpoints` and the observers `named` by the scene."""

    def __init__(
        self,
        solver: Solver,
        length: Length,
        interface: bool | None = None,
        fields: bool | None = None,
        kept: Kept = ALL,
        samples: Path | None = None,
        checkpoint: Path | None = None,
        every: float | None = None,
    ) -> None:
        """The records of a run of `solver` of this length, which continues from its `checkpoint` if that exists: the history of
        the `interface` and the last `fields` (None: by the scene's `record`); which samples of the history are `kept`, and the
        file of the `samples` during the run (default: temporary). A checkpoint is written `every` so many transits (1000).

        Raises SceneError for fields of a model that has none and for a checkpoint of another run.
        """
        scene, until = solver.scene, length.until
        self.history = self.fields = self.checkpoints = None
        if "interface" in scene.record if interface is None else interface:
            self.history = _history(solver, min(until, next(length.ends(0.0), math.inf)), kept, samples, checkpoint)
        if "fields" in scene.record if fields is None else fields:
            self.fields = _fields(solver, until, fields)
        self.watch = EventObserver(scene, solver.nodes)
        self.envelope = Envelope(scene, solver.nodes, kept.begin, kept.end)
        self.protocol = None if scene.drive.is_constant else ProtocolObserver(scene, solver.nodes, until)
        self.named = named_observers(solver)
        if checkpoint is None:
            return
        watched = {"events": self.watch} if scene.record else {}
        others = {"envelope": self.envelope, "protocol": self.protocol, "interface": self.history, "fields": self.fields}
        saved: dict[str, Resumable] = {label: part for label, part in (watched | others | self.named).items() if part is not None}
        files = digests([name_of(scene.law)], [solver.model])
        self.checkpoints = Checkpoints(solver, saved, checkpoint, until, every or _EVERY, files)
        if checkpoint.exists():
            try:
                self.checkpoints.resume()
            except BaseException:
                self.close()
                raise

    @property
    def observers(self) -> list[Observer]:
        """The observers of the run except `watch`."""
        every = (self.envelope, self.protocol, self.history, *self.named.values())
        return [observer for observer in every if observer is not None]

    @property
    def marks(self) -> list[Mark]:
        """The marks of the run: fields first, so that a checkpoint contains them."""
        return [mark for mark in (self.fields, self.checkpoints) if mark is not None]

    def close(self) -> None:
        """Close the history's file, which is removed unless it belongs to a checkpoint."""
        if self.history is not None:
            self.history.close()


def _fields(solver: Solver, until: float, fields: bool | None) -> "FieldRecord | None":
    """The record of the last FIELD_WINDOW transits, for which `fields` asks or, where that is None, the scene's `record`.

    Raises SceneError, naming what asked, if the solver has no fields.
    """
    if not isinstance(solver, FieldSolver):
        asked = "fields" if fields else 'run.record: "fields"'
        raise SceneError(f"{asked}: model {solver.model} has no grid to take fields from; use a full-wave model")
    if math.isinf(until):
        raise SceneError(
            f"run.until: missing; the fields of a run's last {FIELD_WINDOW:g} transits are kept, so it needs a length"
        )
    from fullwave.fields.record import FieldRecord

    return FieldRecord(solver, max(until - FIELD_WINDOW, 0.0), until)


def _history(solver: Solver, until: float, kept: Kept, samples: Path | None, checkpoint: Path | None) -> HistoryFile:
    """The observer of the interface's history in a run to `until` (transits).

    The samples that are `kept` are in the file `samples`, or in a temporary one, until it is closed. With a `checkpoint` they are
    in a file in its folder, which stays for continued runs.
    """
    path = checkpoint.with_name(f"{checkpoint.name}.samples") if checkpoint else samples or _temporary_samples()
    history = HistoryFile(solver.scene.law, solver.nodes, path, until, stays=checkpoint is not None, kept=kept)
    try:
        length = solver.transits_per_piece
        history.expect((min(until, kept.end) - kept.begin) / length * solver.nodes.size if length > 0.0 else 0.0)
    except SceneError:
        history.close()
        raise
    return history


def _temporary_samples() -> Path:
    import tempfile

    folder = Path(tempfile.gettempdir())
    remove_leftovers(folder)
    handle, name = tempfile.mkstemp(prefix=".slipwave-", suffix=part_of(folder, ".samples").name)
    os.close(handle)
    return Path(name)


def time_between(path: Path | None, every: float | str | None, scene: Scene) -> float | None:
    """The time between checkpoints in transits, if given. Raises SceneError, naming the option, if checkpoints cannot be written
    as requested."""
    if every is None:
        if path is not None:
            require_writable(path, (".npz",), "--checkpoint")
        return None
    label = f"--checkpoint-every = {shorten(every)}"
    if path is None:
        raise SceneError(f"{label}: needs --checkpoint FILE")
    found = moment("--checkpoint-every", every, scene)
    if not (math.isfinite(found) and found > 0.0):
        raise SceneError(f"{label}: must be a positive number of transits, or in scenes with SI units a time as in 10s")
    require_writable(path, (".npz",), "--checkpoint")
    return found


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
    grown = LEFT_BY_ROUNDING / growth_rate(run.solver.scene, model)
    return run if run.until > grown else replace(run, verdict=run.verdict._replace(kind="too short", needed=2.0 * grown))
