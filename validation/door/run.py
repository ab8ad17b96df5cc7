"""`slipwave.run`: one model on one scene."""

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fullwave.fields.files import write_field
from slipwave.errors import NumericsError, SceneError
from slipwave.input import SceneSource
from slipwave.input.stored import recall
from slipwave.observe import Events, Solver
from slipwave.observe.foresight import DAY
from slipwave.observe.lyapunov import Exponent
from slipwave.observe.snapshot import FieldSolver
from slipwave.observe.solver import Leaping
from slipwave.observe.stages import StageFigures
from slipwave.scene import Scene
from slipwave.scene.doubts import doubts
from validation.door.motion_figure import motion_axes, motion_figure
from validation.door.protocol_figure import protocol_figure
from validation.door.provenance import SCHEMA, provenance
from validation.door.result import Dataset, Result, announced, as_path, deliver, finite, log, scene_of
from validation.door.return_map import return_map
from validation.registry import build as models
from validation.registry.default_grid import judged, note_on
from validation.registry.families import Built, Options, one_port_of
from validation.run.determinacy import amplified_rounding
from validation.run.event_table import write_events
from validation.run.late_steps import late_steps
from validation.run.length import Length, length_of, require_cycles, second_half
from validation.run.parting import exponent_of, require_constant
from validation.run.quantities import cycle_in_si
from validation.run.reasons import needed, reasons
from validation.run.recording import Records, Wanted, records_of
from validation.run.resuming import require_checkpoint
from validation.run.run_dataset import run_dataset, write_run
from validation.run.simulate import Run, RunInterrupted, simulate
from validation.run.stage_table import stage_results
from validation.run.window import Window, kept_of
from validation.study.drawing import Drawing, styled

if TYPE_CHECKING:
    from fullwave.adapt import Choice


@dataclass(frozen=True, repr=False, eq=False)
class RunResult(Result):
    """A run that is `done`, with what was kept of it on its way in `records`. `choice` is the grid that was chosen for a full
    wave, `notes` are remarks on the numbers, `options` those of the call; `exponent`, if asked for, is the largest Lyapunov
    exponent of the motion from the end on."""

    done: Run
    records: Records
    choice: "Choice | None"
    notes: list[str]
    options: Mapping[str, Any]
    exponent: Exponent | None = None

    @property
    def summary(self) -> dict[str, Any]:
        """The JSON of `slipwave run` (users rely on its keys). `grid` is there only if the user did not choose its cells,
        `protocol`, its stages, only if the drive changes, `lyapunov` only if it was asked for, `failed` only if the numerics
        failed."""
        done, found = self.done, self.done.statistics
        result: dict[str, Any] = {
            "schema": SCHEMA,
            "scene": done.solver.scene.name,
            "model": done.solver.model,
            "until": done.until,
            "events": done.starts,
            "verdict": done.kind,
            "multiplicity": done.verdict.multiplicity if done.verdict else None,
            "rotation_number": done.verdict.rotation if done.verdict else None,
            "rate": done.verdict.rate if done.verdict else None,
            **{name: asdict(getattr(found, name)) for name in ("period", "stress_drop", "elastic_stress_drop")},
            "v_max": found.v_max,
            "v_min": found.v_min,
            "margins": asdict(found.margins) if done.verdict and done.verdict.wanders else None,
            "final": asdict(done.final) if done.final else None,
            "energy": self.energy,
            "ended": done.ended,
            "reasons": self.reasons,
            "failures": done.solver.failures,
            "wall_s": done.wall_s,
        } | cycle_in_si(found.values(), done.solver.scene)
        if "time" in done.solver.settings:
            result["time"] = done.solver.settings["time"]
        if isinstance(done.solver, Leaping) and done.solver.skipped:
            result["left_out"] = done.solver.skipped
        if self.choice:
            result["grid"] = {name: getattr(self.choice, name) for name in ("cells", "step", "quantity", "error_estimate")}
        more = {
            "protocol": stage_results(self.stages, done.solver.scene),
            "lyapunov": self.exponent._asdict() if self.exponent else None,
            "failed": done.failed,
            "notes": [*doubts(done.solver.scene), *self.notes],
        }
        return dict(finite(result | {name: value for name, value in more.items() if value}))

    @property
    def stages(self) -> list[StageFigures]:
        """The stages of a protocol with their figures; none if V never changes."""
        return self.records.protocol.figures if self.records.protocol else []

    @cached_property
    def reasons(self) -> list[str]:
        """Why the motion is what it is, and what would change it, in words."""
        return reasons(self.done, one_port_of(self.done.solver.model))

    @property
    def needed(self) -> float:
        """Length (transits) of a run with enough cycles, if this one is too short."""
        return needed(self.done, one_port_of(self.done.solver.model))

    @property
    def energy(self) -> dict[str, float] | None:
        """The energy ledger since t = 0 by name; None for models that keep none and for a run that failed."""
        ledger = self.done.energy
        if ledger is None:
            return None
        viscous = ["viscous"] * any(slab.viscosity for slab in self.done.solver.scene.slabs)
        return {name: getattr(ledger, name) for name in ("input", "friction", "radiated", "stored", "residual", *viscous)}

    @cached_property
    def dataset(self) -> Dataset:
        """Cycles by `event`, stages of a protocol by `stage`; the interface's history by `time`, if it was kept, all of it in
        memory."""
        return run_dataset(self.done, self._facts(), self.stages, self.records.history)

    def to_netcdf(self, path: str | Path) -> None:
        """Write the dataset, block by block, and the fields as a group if the scene records them. Raises SceneError if the file
        cannot be written."""
        record = self.records.fields if "fields" in self.done.solver.scene.record else None
        field = record.field if record is not None and self.done.final is not None else None
        write_run(Path(path), self.done, self._facts(), self.stages, self.records.history, field)

    def plot(self) -> Drawing:
        """Stress and slip rate over time, or of a protocol friction over time and slip, if the history was kept
        (`interface=True`); else the stress drop and the largest slip rate of each cycle."""
        done, data, scene = self.done, self.dataset, self.done.solver.scene
        title = f"{scene.name}, {done.solver.model}: {done.kind or 'events not watched'}"
        with styled():
            if "interface_stress" in data:
                if self.records.protocol is not None:
                    return protocol_figure(scene, done.solver.model, data, self.stages)
                return motion_figure(scene, title, data)
            figure, above, below = motion_axes(scene, title)
            for axes, name in ((above, "stress_drop"), (below, "v_max")) if "event_time" in data.coords else ():
                axes.plot(data["event_time"], data[name], ".", color="#111111")
            above.set_ylabel("stress drop / normal stress")
            below.set_ylabel("largest slip rate / V*")
            return figure

    def plot_return_map(self) -> Drawing:
        """The period of each cycle of the run's second half over that of the one before. Raises SceneError for fewer than two
        cycles."""
        done, cycles = self.done, self.done.events
        inside = cycles.time >= second_half(done.solver, done.until)
        if inside.sum() < 2:
            raise SceneError("a return map needs two complete cycles in the second half of the run")
        title = f"{done.solver.scene.name}, {done.solver.model}: {done.kind}"
        with styled():
            return return_map(title, Events(*(column[inside] for column in cycles)))

    def _facts(self) -> dict[str, Any]:
        facts = provenance("run", self.done.solver.scene, self.done.solver.model, self.options)
        return facts | {"ended": self.done.ended or "failed", "reasons": "; ".join(self.reasons)}

    def write_events(self, path: str | Path) -> None:
        """Write one line for each complete cycle to a .csv file, in SI if the scene has units."""
        write_events(Path(path), self.done.events, self.done.solver.scene)

    def write_fields(self, path: str | Path) -> None:
        """Write velocity and stress of the last transits to a .vtu, .xdmf or .nc file; nothing if the run kept none."""
        if self.records.fields is not None and self.done.final is not None:
            write_field(Path(path), self.records.fields.field)

    def close(self) -> None:
        """Remove the temporary file that holds the interface's history."""
        self.records.close()


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
    checkpoint_every: float | None = None,
    lyapunov: bool = False,
    most_seconds: float = DAY,
    settings: Iterable[str] = (),
    **changes: Any,
) -> RunResult:
    """Run one model on a scene, changed by `settings` (texts "key=value") or `changes` (those of `slipwave.read_scene`).

    `until` is in transits, or a text with a unit of time ("60 s"); `cycles` ends the run when its second half has so many.
    Without them the scene gives the length, or the run ends when its motion is settled (`validation.run.length`). `cells`, `cfl`
    and `time` ("exact" or "explicit") are for full waves; `tol` is the requested relative error. `interface` keeps the
    interface's history, during the run in the file `samples` (default: a temporary one); `every` keeps one in so many samples
    and `window` those from begin to end, as (20, 45) or "20:45" in transits or "10s:60s", and each of them asks for the history
    too. `fields` keeps the last 100 transits of a full wave. Both are kept as the scene records where None. A run that writes a
    `checkpoint` every so many transits goes on from that file if it exists. `lyapunov` asks for the largest Lyapunov exponent,
    by a second march beside the motion from the end of the run on. If `source` is a netCDF file of an earlier run, it is run
    again: its model and its options hold where none are given.

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
    require_checkpoint(checkpoint, checkpoint_every)
    numerical = Options(cells=options["cells"], cfl=options["cfl"], tolerance=options["tol"], time=options["time"])
    wanted = Wanted(options["interface"], fields, kept_of(options["every"], options["window"], scene), samples)
    built = models.prepare(model, scene, checkpoint is not None and checkpoint.exists(), **numerical)
    _tell(built)
    if isinstance(built.solver, FieldSolver):
        built.solver.keep_ledger()
    length = length_of(scene, one_port_of(built.solver.model), cycles)
    notes = _doubts(built.solver, length, options["tol"])
    records = records_of(built.solver, length.until, wanted, checkpoint, checkpoint_every)
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
        return simulate(solver, length, records.observers, most, records.watch, records.marks), False
    except RunInterrupted as stop:
        return stop.run, True


def _exponent(done: Run, scene: Scene, numerical: Options, most: float) -> tuple[Exponent | None, str, bool]:
    """The exponent of a run, by a twin of its solver, or why there is none, and whether the user stopped it. A grid chosen
    for a tolerance is not chosen again."""
    solver = done.solver
    if isinstance(solver, FieldSolver):
        numerical = numerical | Options(cells=solver.cells, tolerance=None)
    twin = models.prepare(solver.model, scene, True, **numerical).solver
    try:
        return exponent_of(done, twin, one_port_of(solver.model), most), "", False
    except NumericsError as error:
        return None, str(error), False
    except KeyboardInterrupt:
        return None, f"interrupted at t = {solver.time:.6g} transits, before the Lyapunov exponent was known", True


def _doubts(solver: Solver, length: Length, tol: float | None) -> list[str]:
    """Warnings about the result that are known before the run."""
    amplified = amplified_rounding(solver.scene, one_port_of(solver.model), length.until, tol)
    return [*([amplified.note] if amplified else []), *late_steps(solver)]
