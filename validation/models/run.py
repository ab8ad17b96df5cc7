"""One model on one scene from start to end, as `slipwave run`, `compare` and `bench` need it: what is kept of it, the march, the
verdict.

Where the motion decides how long it is (`validation.models.outlook`), it is marched in stretches. At the end of each, the second
half of the run so far is judged. The ends depend on the scene alone and the judgement on the motion alone, so that a continued
run ends where the uninterrupted one would.

Kept are events, the envelope for its figure, and if it is asked the interface's history, the fields of the last transits,
checkpoints.
"""

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from slipwave.compiled.cache import COMPILING
from slipwave.errors import NumericsError, SceneError
from slipwave.files import require_writable
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
from validation.models.history_file import ALL, HistoryFile, Thinning, temporary_samples
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
        kept: Thinning = ALL,
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
        own = {"events": self.watch if scene.record else None, "envelope": self.envelope, "protocol": self.protocol}
        parts = own | {"interface": self.history, "fields": self.fields} | self.named
        saved: dict[str, Resumable] = {label: part for label, part in parts.items() if part is not None}
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


def _history(solver: Solver, until: float, kept: Thinning, samples: Path | None, checkpoint: Path | None) -> HistoryFile:
    """The observer of the interface's history in a run to `until` (transits).

    The samples that are `kept` are in the file `samples`, or in a temporary one, until it is closed. With a `checkpoint` they are
    in a file in its folder, which stays for continued runs.
    """
    if samples is not None:
        require_writable(samples, (samples.suffix,), "--samples")
    path = checkpoint.with_name(f"{checkpoint.name}.samples") if checkpoint else samples or temporary_samples()
    history = HistoryFile(solver.scene.law, solver.nodes, path, until, stays=checkpoint is not None, kept=kept)
    try:
        length = solver.transits_per_piece
        history.expect((min(until, kept.end) - kept.begin) / length * solver.nodes.size if length > 0.0 else 0.0)
    except SceneError:
        history.close()
        raise
    return history


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
    transits = moment("--checkpoint-every", every, scene)
    if not (math.isfinite(transits) and transits > 0.0):
        raise SceneError(f"{label}: must be a positive number of transits, or in scenes with SI units a time as in 10s")
    require_writable(path, (".npz",), "--checkpoint")
    return transits


def second_half(solver: Solver, until: float) -> float:
    """Begin (transits) of the second half of a run to `until`, or of the run so far if it ended before."""
    return 0.5 * min(until, solver.time)


@dataclass(frozen=True)
class Run:
    """The result of a run of `solver` to `until` (transits), where it `ended` for one of four reasons. `watch`, of its events,
    and the `verdict` on the second half are None if events are not recorded. `statistics`: of the second half's cycles, of none
    if they do not represent the motion. `energy` counts to the end of the last step, at `marched` (transits). `wall_s` in
    seconds, without those to compile code; `failed`: what, where and when the numerics failed or the user `stopped` the run, or
    empty: the rest is then what was computed before.
    """

    solver: Solver
    until: float
    watch: EventObserver | None
    verdict: MotionVerdict | None
    statistics: RunStatistics
    final: Final | None
    energy: Energy | None
    marched: float
    wall_s: float
    failed: str = ""
    ended: Ended | None = "until"
    stopped: bool = False

    @property
    def kind(self) -> Kind | None:
        """The kind of the verdict; None if events were not recorded."""
        return self.verdict.kind if self.verdict else None

    @property
    def event_count(self) -> int | None:
        """Number of slip events; None if events were not recorded."""
        return self.watch.count if self.watch else None

    @property
    def events(self) -> Events:
        """All complete cycles."""
        return self.watch.events() if self.watch else NO_EVENTS


def simulate(
    solver: Solver,
    length: float | Length,
    observers: Sequence[Observer] = (),
    most_seconds: float = DAY,
    watch: EventObserver | None = None,
    marks: Sequence[Mark] = (),
) -> Run:
    """March `solver` to the end of `length` (a number: so many transits) with progress on stderr; statistics are those of the
    run's second half. Events are observed by `watch`, if given, else if the scene records anything. A NumericsError of the solver
    and an interruption are not raised but stored in `failed`, with what was computed before. Raises SceneError if the run would
    take more than `most_seconds` (`slipwave.solve.follow`).
    """
    wanted = Length(until=length) if isinstance(length, int | float) else length
    if watch is None and solver.scene.record:
        watch = EventObserver(solver.scene, solver.nodes)
    work = Foresight(solver, 0.0, most_seconds)
    everyone = [*([watch] if watch else []), *observers, work]
    final: Final | None = None
    judged: JudgedHalf | None = None
    ended: Ended | None = None
    until, failed, stopped, began = 0.0, "", False, time.perf_counter() - sum(COMPILING)
    advice = LongRunAdvice(solver)
    try:
        for end in wanted.ends(solver.time):
            if work.seconds(end) > wanted.most_seconds:
                break
            advice.foretell(require_time(solver, end, most_seconds))
            until, final, judged = end, None, None
            work.until = end
            for mark in marks:
                if isinstance(mark, Checkpoints):
                    mark.until = end
            share = share_of_run(solver.scene.drive, end)
            with progress(f"{solver.scene.name}, {solver.model}", end, share, advice) as report:
                final = follow(solver, end, everyone, report, marks)
            judged = _judged(solver, watch, until, final)
            ended = wanted.ended(judged)
            if ended:
                break
    except NumericsError as error:
        failed = str(error)
    except KeyboardInterrupt:
        failed, stopped = f"interrupted at t = {solver.time:.6g} of {until:g} transits", True
    judged = judged or _judged(solver, watch, until, final)
    seconds = time.perf_counter() - sum(COMPILING) - began
    verdict, cycles = _represented(judged, solver.scene.drive, until)
    figures, energy = summarise(cycles, not (verdict and verdict.wanders)), None if failed else solver.energy()
    reason = None if failed else ended or "limit"
    return Run(solver, until, watch, verdict, figures, final, energy, solver.time, seconds, failed, reason, stopped)


def _judged(solver: Solver, watch: EventObserver | None, until: float, final: Final | None) -> JudgedHalf:
    """The second half of a run to `until` (transits) so far, and the verdict on it, if its events are watched; `final`: the state
    at its end, if it was reached."""
    half, drive = second_half(solver, until), solver.scene.drive
    end = 2.0 * half
    if watch is None:
        return JudgedHalf(end, None, NO_EVENTS)
    slides = final is not None and slides_at(final.v, drive.at(end))
    rests = drive.rests_from(half)
    cycles, ringing = watch.events(half), watch.ringing(drive.at(end), half) if rests else math.inf
    return JudgedHalf(end, judge_motion(cycles, watch.judge(half).complete, rests, slides, end, ringing), cycles)


def _represented(judged: JudgedHalf, drive: Drive, until: float) -> tuple[MotionVerdict | None, Events]:
    """The verdict on a run to `until` (transits), "protocol" where the second half under a drive that changes holds no cycles
    that repeat or wander, but a stage of constant V to judge; and the cycles that represent the motion, none of any other."""
    verdict, cycles = judged.verdict, judged.cycles
    if verdict is None:
        return None, NO_EVENTS
    if verdict.repeats:
        return verdict, repeating(cycles, verdict.multiplicity) if verdict.multiplicity else cycles
    levels = [stage for stage in stages_of(drive, until) if stage.kind not in ("ramp", "hold") and stage.end > 0.5 * until]
    return verdict._replace(kind="protocol", needed=math.nan) if levels else verdict, NO_EVENTS


def reconsidered(run: Run, model: str) -> Run:
    """`run` with a corrected verdict if steady sliding is unstable: a decay is then a transient before growth, and steady sliding
    lasts only until rounding has grown. `model` is one with the one-port of the model that ran."""
    if run.kind not in ("steady", "decaying") or run.verdict is None or is_stable(run.solver.scene, model) is not False:
        return run
    if run.kind == "decaying":
        return replace(run, verdict=run.verdict._replace(kind="settling", rate=math.nan))
    grown = LEFT_BY_ROUNDING / growth_rate(run.solver.scene, model)
    return run if run.until > grown else replace(run, verdict=run.verdict._replace(kind="too short", needed=2.0 * grown))
