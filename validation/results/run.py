"""`slipwave.run`: one model on one scene."""

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import ClassVar

from slipwave.errors import NumericsError, SceneError
from slipwave.input import SceneSource
from slipwave.observe.verdict import REPEATING
from slipwave.scene import Scene
from slipwave.solve import Solver, has_fields
from slipwave.solve.follow import DAY
from slipwave.solve.lyapunov import INTERVALS, TRANSIENT, Exponent, largest_exponent
from validation.compute import build as models
from validation.compute.default_grid import grid_in_words, judged_grid, note_on, note_on_given
from validation.compute.length import MOST_CYCLES, Length, length_of, require_counted
from validation.compute.models import Options, one_port_of
from validation.compute.outlook import amplified_rounding, costly_steps, outlook
from validation.compute.progress import progress
from validation.compute.recording import Wanted, Window, kept_of, records_of, time_between
from validation.compute.run import Run, reconsidered, simulate
from validation.results.command import command
from validation.results.options import ModelOptions, NumericalOptions, RunsOptions, announced, log, option
from validation.results.run_result import RunResult


@dataclass(frozen=True, kw_only=True)
class RunOptions(NumericalOptions, RunsOptions, ModelOptions):
    """Options of `slipwave.run`."""

    EXAMPLES: ClassVar = (
        "slipwave run paper --model modal:2 --set slab.log10_r=-2.6 --plot run.png",
        "slipwave run paper --out run.nc --every 10",
        "slipwave run run.nc",
    )

    cycles: int | None = option(
        "end when the second half of the run has N complete cycles, not --until",
        metavar="N",
        stored=True,
        least=1,
        most=MOST_CYCLES,
        must=f"be a whole number from 1 to {MOST_CYCLES}",
    )
    interface: bool | None = option(
        "keep the interface's history, or not; a history that would not fit on the disk, or into a quarter of the memory, is "
        "refused (default: as the scene records)",
        only="python",
        stored=True,
    )
    fields: bool | None = option(
        "keep the last 100 transits of a full wave, or not (default: as the scene records)", only="python"
    )
    samples: Path | None = option("file of the history during the run (default: a temporary one)", only="python")
    checkpoint: Path | None = option("save checkpoints here during the run, and go on from FILE if it exists", metavar="FILE")
    checkpoint_every: float | str | None = option(
        "time between checkpoints, in transits or as 10s (default 1000)", metavar="TRANSITS|TIME"
    )
    every: int | None = option(
        "keep one in N samples of the interface's history",
        metavar="N",
        stored=True,
        least=1,
        must="be 1 or more: one in so many samples is kept",
    )
    window: Window | None = option(
        "keep only the history from A to B, in transits or as 10s:60s; in Python also a pair of them", metavar="A:B", stored=True
    )
    lyapunov: bool = option("how fast motions close by part: the largest Lyapunov exponent, by a second march", False)


@command
def run(source: SceneSource, options: RunOptions) -> RunResult:
    """Run one model on a scene.

    Without `until` and `cycles` the scene gives the length, or the run ends when its motion is settled
    (`validation.compute.length`). If `source` is a netCDF file of an earlier run, it is run again: its model and its options hold
    where none are given.

    Raises SceneError for wrong input and for a run that is expected to take more than `most_seconds`; NumericsError if the
    numerics fail, with the result so far as its `result`.
    """
    until, checkpoint = options.until, options.checkpoint
    if until is not None and options.cycles is not None:
        raise SceneError(f"cycles = {options.cycles}: must not be given together with until = {until}")
    if options.interface is None and (options.every is not None or options.window is not None):
        options = replace(options, interface=True)
    options = options.recalled(source, "run", without=["cycles"] if until is not None else [])
    scene = options.scene_of(source, until)
    require_counted(scene, options.cycles)
    if options.lyapunov:
        require_constant(scene)
    every = time_between(checkpoint, options.checkpoint_every, scene)
    kept = kept_of(options.every, options.window, scene)
    built = models.prepare(options.model, scene, checkpoint is not None and checkpoint.exists(), **options.numerical)
    if built.choice is not None:
        log.info("%s: %s", built.solver.model, grid_in_words(built.choice))
    announced(built.solver.model, built.why)
    if has_fields(built.solver):
        built.solver.keep_ledger()
    start = built.solver.state()
    one_port = one_port_of(built.solver.model)
    length = length_of(scene, one_port, options.cycles)
    shortest = next(length.ends(0.0), math.inf)
    wanted = Wanted(options.interface, options.fields, kept, options.samples, shortest, checkpoint, every)
    notes = _doubts(built.solver, length, options)
    records = records_of(built.solver, length.until, wanted)
    try:
        done = simulate(built.solver, length, records.observers, options.most_seconds, records.watch, records.marks)
        done = done if done.stopped else reconsidered(done, one_port)
        is_default = options.cells is None and options.tol is None and not done.failed and has_fields(built.solver)
        default = judged_grid(built.solver, start, options.cfl, options.time) if is_default else None
        exponent, failed, stopped = None, done.failed, done.stopped
        if options.lyapunov and not (failed or stopped):
            exponent, failed, stopped = _exponent(done, scene, options)
    except BaseException:
        records.close()
        raise
    notes += note_on(default) if default else []
    for note in notes:
        log.info("note: %s", note)
    parts = done, records, built.choice or default, notes, options.stored, exponent
    return RunResult(*parts, failed=failed, stopped=stopped)


def _exponent(done: Run, scene: Scene, options: RunOptions) -> tuple[Exponent | None, str, bool]:
    """The exponent of a run, by a twin of its solver, or why there is none, and whether the user stopped it. A grid chosen
    for a tolerance is not chosen again."""
    solver, numerical = done.solver, options.numerical
    if has_fields(solver):
        numerical = numerical | Options(cells=solver.cells, tolerance=solver.settings.get("resolution"))
    twin = models.prepare(solver.model, scene, True, **numerical).solver
    try:
        return exponent_of(done, twin, one_port_of(solver.model), options.most_seconds), "", False
    except NumericsError as error:
        return None, str(error), False
    except KeyboardInterrupt:
        return None, f"interrupted at t = {solver.time:.6g} transits, before the Lyapunov exponent was known", True


def _doubts(solver: Solver, length: Length, options: RunOptions) -> list[str]:
    """Warnings about the result that are known before the run."""
    amplified = amplified_rounding(solver.scene, one_port_of(solver.model), length.until, options.tol)
    given = note_on_given(options.cells, options.tol) if has_fields(solver) else []
    return [*([amplified.note] if amplified else []), *given, *costly_steps(solver)]


def require_constant(scene: Scene) -> None:
    """Raises SceneError if the drive changes: then motions part because they are driven."""
    if not scene.drive.is_constant or scene.velocity == 0.0:
        raise SceneError(f"scene {scene.name!r}: a Lyapunov exponent needs a constant drive.velocity")


def exponent_of(done: Run, twin: Solver, model: str, most_seconds: float = DAY) -> Exponent:
    """The exponent of the motion from the end of a run on; `twin` is another solver of its scene, and `model` one with the
    one-port of the model that ran.

    Raises NumericsError for a run whose cycles do not represent its motion: a disturbance of steady sliding fades or grows as
    `slipwave stability` says, and a transient has no exponent; else as `largest_exponent`."""
    solver = done.solver
    if done.verdict is not None and not done.verdict.repeats:
        advice = "run longer" if done.verdict.kind in ("too short", "settling") else "slipwave stability gives its rate"
        raise NumericsError(
            f"{solver.model}: a Lyapunov exponent is measured of runs with the verdict {', '.join(REPEATING[:-1])} or "
            f"{REPEATING[-1]}; this one is {done.verdict.kind}: {advice} (scene {solver.scene.name!r})"
        )
    period = float(done.events.period[-1]) if done.events.period.size else outlook(solver.scene, model).period
    cycle = period if math.isfinite(period) else 1.0
    with progress(f"{solver.scene.name}, {solver.model}, beside a second motion", float(TRANSIENT + INTERVALS)) as report:
        return largest_exponent(solver, twin, cycle, report, most_seconds=most_seconds)
