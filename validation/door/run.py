"""`slipwave.run`: one model on one scene."""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fullwave.fields.files import write_field
from slipwave.input import SceneSource
from slipwave.observe import Solver
from slipwave.observe.foresight import DAY
from slipwave.scene.doubts import doubts
from validation.door.result import Result, deliver, finite, scene_of, told
from validation.registry import build as models
from validation.registry.default_grid import judged, note_on
from validation.registry.families import Built, one_port_of
from validation.run.determinacy import amplified_rounding
from validation.run.recording import Records, records_of, write_run
from validation.run.resuming import require_checkpoint
from validation.run.simulate import Run, RunInterrupted, simulate

if TYPE_CHECKING:
    from fullwave.adapt import Choice


@dataclass(frozen=True, repr=False, eq=False)
class RunResult(Result):
    """A run that is `done`, with what was kept of it on its way in `records`. `choice` is the grid that was chosen for a full
    wave, `notes` are remarks on the numbers."""

    done: Run
    records: Records
    choice: "Choice | None"
    notes: list[str]

    @property
    def summary(self) -> dict[str, Any]:
        """The JSON of `slipwave run` (users rely on its keys). `grid` is there only if the user did not choose its cells,
        `failed` only if the numerics failed."""
        done, found = self.done, self.done.statistics
        result: dict[str, Any] = {
            "scene": done.solver.scene.name,
            "model": done.solver.model,
            "until": done.until,
            "events": done.starts,
            "verdict": done.kind,
            "multiplicity": done.verdict.multiplicity if done.verdict else None,
            "rotation_number": done.verdict.rotation if done.verdict else None,
            **{name: asdict(getattr(found, name)) for name in ("period", "stress_drop", "elastic_stress_drop")},
            "v_max": found.v_max,
            "v_min": found.v_min,
            "final": asdict(done.final) if done.final else None,
            "energy": self.energy,
            "failures": done.solver.failures,
            "wall_s": done.wall_s,
        }
        if "time" in done.solver.settings:
            result["time"] = done.solver.settings["time"]
        if self.choice:
            result["grid"] = {name: getattr(self.choice, name) for name in ("cells", "step", "quantity", "error_estimate")}
        more = {"failed": done.failed, "notes": [*doubts(done.solver.scene), *self.notes]}
        return dict(finite(result | {name: value for name, value in more.items() if value}))

    @property
    def energy(self) -> dict[str, float] | None:
        """The energy ledger since t = 0 by name; None for models that keep none and for a run that failed."""
        ledger = self.done.energy
        if ledger is None:
            return None
        viscous = ["viscous"] * any(slab.viscosity for slab in self.done.solver.scene.slabs)
        return {name: getattr(ledger, name) for name in ("input", "friction", "radiated", "stored", "residual", *viscous)}

    def to_netcdf(self, path: str | Path) -> None:
        """Write events, and history and fields where the scene records them. Raises SceneError if the file cannot be written."""
        record = self.records.fields if "fields" in self.done.solver.scene.record else None
        field = record.field if record is not None and self.done.final is not None else None
        write_run(Path(path), self.done, self.records.history, field)

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
    until: float | None = None,
    cells: int | None = None,
    cfl: float | None = None,
    time: str | None = None,
    tol: float | None = None,
    history: bool | Path = True,
    fields: bool | None = None,
    checkpoint: Path | None = None,
    checkpoint_every: float | None = None,
    most_seconds: float = DAY,
    **changes: Any,
) -> RunResult:
    """Run one model on a scene; `changes` are those of `slipwave.read_scene`.

    `until` is in transits (default: the scene's). `cells`, `cfl` and `time` ("exact" or "explicit") are for full waves; `tol` is
    the requested relative error. If the scene records the interface, its `history` is kept in a temporary file, in the file
    given, or not at all. `fields` keeps the last 100 transits of a full wave (default: as the scene records). A run that writes a
    `checkpoint` every so many transits goes on from that file if it exists.

    Raises SceneError for wrong input and for a run that is expected to take more than `most_seconds`; NumericsError if the
    numerics fail, with the result so far as its `result`.
    """
    scene = scene_of(source, changes, until)
    require_checkpoint(checkpoint, checkpoint_every)
    resumed = checkpoint is not None and checkpoint.exists()
    built = models.prepare(model, scene, resumed, cells=cells, cfl=cfl, tolerance=tol, time=time)
    _tell(built)
    notes = _doubts(built.solver, tol)
    records = records_of(built.solver, scene.until, history, fields, checkpoint, checkpoint_every)
    try:
        done, stopped = _march(built.solver, records, most_seconds)
        default = judged(built.solver, cfl, time) if cells is None and tol is None and not done.failed else None
    except BaseException:
        records.close()
        raise
    notes += note_on(default) if default else []
    return deliver(RunResult(done, records, built.choice or default, notes), done.failed, stopped)


def grid_in_words(choice: "Choice") -> str:
    """Cells, steps and estimated error of a grid."""
    steps = f"steps of {'at most ' * choice.adapts}{choice.step:.4g}"
    return f"{choice.cells} cells, {steps}, estimated error of {choice.quantity} {choice.error_estimate:.1e}"


def _tell(built: Built) -> None:
    """Report what was chosen for the user."""
    if built.choice is not None:
        told.info("%s: %s", built.solver.model, grid_in_words(built.choice))
    if built.why:
        told.info("model auto: %s (%s)", built.solver.model, built.why)


def _march(solver: Solver, records: Records, most: float) -> tuple[Run, bool]:
    """The run, and whether the user stopped it."""
    try:
        return simulate(solver, solver.scene.until, records.observers, most, records.watch, records.marks), False
    except RunInterrupted as stop:
        return stop.run, True


def _doubts(solver: Solver, tol: float | None) -> list[str]:
    """Warnings about the result that are known before the run."""
    amplified = amplified_rounding(solver.scene, one_port_of(solver.model), solver.scene.until, tol)
    return [amplified.note] if amplified else []
