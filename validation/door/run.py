"""`slipwave.run`: one model on one scene."""

import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from slipwave.errors import NumericsError, SceneError
from slipwave.input import SceneSource
from slipwave.input.stored import recall
from slipwave.scene import Scene
from slipwave.solve import FieldSolver, Solver
from slipwave.solve.foresight import DAY
from slipwave.solve.lyapunov import Exponent
from validation.door.checked import checked
from validation.door.result import announced, as_path, deliver, log, scene_of
from validation.door.run_result import RunResult
from validation.registry import build as models
from validation.registry.default_grid import judged, note_on, note_on_given
from validation.registry.families import Built, Options, one_port_of
from validation.run.determinacy import amplified_rounding
from validation.run.length import Length, length_of, require_cycles
from validation.run.parting import exponent_of, require_constant
from validation.run.recording import Records, Wanted, records_of
from validation.run.resuming import time_between
from validation.run.simulate import Run, RunInterrupted, reconsidered, simulate
from validation.run.steps_of_drive import costly_steps
from validation.run.window import Window, kept_of

if TYPE_CHECKING:
    from fullwave.adapt import Choice


@checked
def run(
    source: SceneSource,
    model: str = "auto",
    *,
    until: float | str | None = None,
    cycles: int | None = None,
    cells: int | None = None,
    cfl: float | None = None,
    time: str | None = None,
    tol: float | None = None,
    interface: bool | None = None,
    every: int | None = None,
    window: Window | None = None,
    fields: bool | None = None,
    samples: str | Path | None = None,
    checkpoint: str | Path | None = None,
    checkpoint_every: float | str | None = None,
    lyapunov: bool = False,
    most_seconds: float = DAY,
    settings: Iterable[str] = (),
    **changes: Any,
) -> RunResult:
    """Run one model on a scene, changed by `settings` (texts "key=value") or `changes` (those of `slipwave.read_scene`).

    `until` is in transits, or a text with a unit of time ("60 s"); `cycles` ends the run when its second half has so many.
    Without them the scene gives the length, or the run ends when its motion is settled (`validation.run.length`). `cells`, `cfl`
    and `time` ("exact" or "explicit") are for full waves; `tol` is the requested relative error, with `cells` that of the steps
    of the exact march. `interface` keeps the interface's history, during the run in the file `samples` (default: a temporary
    one); `every` keeps one in so many samples and `window` those from begin to end, as (20, 45) or "20:45" in transits or
    "10s:60s", and each of them asks for the history too; a history that would not fit on the disk, or into a quarter of the
    memory, is refused. `fields` keeps the last 100 transits of a full wave. Both are kept as the scene records where None. A run
    that writes a `checkpoint` every so often (transits, or a time as in "10s") goes on from that file if it exists.
    `lyapunov` asks for the largest Lyapunov exponent, by a second march beside the motion from the end of the run on. If
    `source` is a netCDF file of an earlier run, it is run again: its model and its options hold where none are given.

    Raises SceneError for wrong input and for a run that is expected to take more than `most_seconds`; NumericsError if the
    numerics fail, with the result so far as its `result`.
    """
    if until is not None and cycles is not None:
        raise SceneError(f"cycles = {cycles}: must not be given together with until = {until}")
    length_given = {} if until is not None else {"cycles": cycles}
    given: dict[str, Any] = length_given | {
        "cells": cells,
        "cfl": cfl,
        "tol": tol,
        "time": time,
        "interface": interface,
        "every": every,
        "window": window,
    }
    if interface is None and (every is not None or window is not None):
        given["interface"] = True
    model, options = recall(source, "run", model, given)
    scene = scene_of(source, settings, changes, until)
    cycles = options.get("cycles")
    checkpoint, samples = as_path(checkpoint), as_path(samples)
    require_cycles(scene, cycles)
    if lyapunov:
        require_constant(scene)
    between = time_between(checkpoint, checkpoint_every, scene)
    kept = kept_of(options["every"], options["window"], scene)
    numerical = Options(cells=options["cells"], cfl=options["cfl"], tolerance=options["tol"], time=options["time"])
    built = models.prepare(model, scene, checkpoint is not None and checkpoint.exists(), **numerical)
    _tell(built)
    if isinstance(built.solver, FieldSolver):
        built.solver.keep_ledger()
    length = length_of(scene, one_port_of(built.solver.model), cycles)
    wanted = Wanted(options["interface"], fields, kept, samples, next(length.ends(0.0), math.inf))
    notes = _doubts(built.solver, length, options)
    records = records_of(built.solver, length.until, wanted, checkpoint, between)
    try:
        done, stopped = _march(built.solver, length, records, most_seconds)
        default = _default_grid(built.solver, options) if not done.failed else None
        exponent, failed = None, done.failed
        if lyapunov and not (failed or stopped):
            exponent, failed, stopped = _exponent(done, scene, numerical, most_seconds)
    except BaseException:
        records.close()
        raise
    notes += note_on(default) if default else []
    return deliver(RunResult(done, records, built.choice or default, notes, options, exponent), failed, stopped)


def _default_grid(solver: Solver, options: Mapping[str, Any]) -> "Choice | None":
    """The grid that a full wave took by itself, with its estimated error."""
    chosen = options["cells"] is not None or options["tol"] is not None
    return None if chosen else judged(solver, options["cfl"], options["time"])


def grid_in_words(choice: "Choice") -> str:
    """Cells, steps and estimated error of a grid."""
    steps = f"steps of {'at most ' * choice.adapts}{choice.step:.4g}"
    return f"{choice.cells} cells, {steps}, estimated error of {choice.quantity} {choice.error_estimate:.1e}"


def _tell(built: Built) -> None:
    """Report what was chosen for the user."""
    if built.choice is not None:
        log.info("%s: %s", built.solver.model, grid_in_words(built.choice))
    announced(built.solver.model, built.why)


def _march(solver: Solver, length: Length, records: Records, most: float) -> tuple[Run, bool]:
    """The run, and whether the user stopped it."""
    try:
        done = simulate(solver, length, records.observers, most, records.watch, records.marks)
        return reconsidered(done, one_port_of(solver.model)), False
    except RunInterrupted as stop:
        return stop.run, True


def _exponent(done: Run, scene: Scene, numerical: Options, most: float) -> tuple[Exponent | None, str, bool]:
    """The exponent of a run, by a twin of its solver, or why there is none, and whether the user stopped it. A grid chosen
    for a tolerance is not chosen again."""
    solver = done.solver
    if isinstance(solver, FieldSolver):
        numerical = numerical | Options(cells=solver.cells, tolerance=solver.settings.get("resolution"))
    twin = models.prepare(solver.model, scene, True, **numerical).solver
    try:
        return exponent_of(done, twin, one_port_of(solver.model), most), "", False
    except NumericsError as error:
        return None, str(error), False
    except KeyboardInterrupt:
        return None, f"interrupted at t = {solver.time:.6g} transits, before the Lyapunov exponent was known", True


def _doubts(solver: Solver, length: Length, options: Mapping[str, Any]) -> list[str]:
    """Warnings about the result that are known before the run."""
    amplified = amplified_rounding(solver.scene, one_port_of(solver.model), length.until, options["tol"])
    given = note_on_given(options["cells"], options["tol"])
    return [*([amplified.note] if amplified else []), *given, *costly_steps(solver)]
