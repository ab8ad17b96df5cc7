"""`slipwave run`: one model on one scene."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from validation.commands.options import (
    Cells,
    Cfl,
    Json,
    Model,
    SceneName,
    Settings,
    TimeMarch,
    Tolerance,
    Until,
    Yes,
    most_seconds,
    read_scene,
)

if TYPE_CHECKING:
    from fullwave.adapt import Choice
    from slipwave.observe import Solver
    from validation.registry.families import Built
    from validation.run.recording import Records
    from validation.run.simulate import Run


def run(
    source: SceneName,
    model: Model = "auto",
    until: Until = None,
    settings: Settings = None,
    cells: Cells = None,
    cfl: Cfl = None,
    time: TimeMarch = None,
    tol: Tolerance = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE.nc", help="write events, and the interface and fields if recorded")
    ] = None,
    fields: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="full wave: write velocity and stress of the last 100 transits, .vtu, .xdmf or .nc"),
    ] = None,
    checkpoint: Annotated[
        Path | None, typer.Option(metavar="FILE", help="save checkpoints here during the run, and go on from FILE if it exists")
    ] = None,
    every: Annotated[
        float | None, typer.Option("--checkpoint-every", metavar="TRANSITS", help="time between checkpoints (default 1000)")
    ] = None,
    yes: Yes = False,
    json: Json = False,
) -> None:
    """Run one model on one scene; print events, periods and stress drops of the run's second half."""
    from validation.output import conclude, require_writable
    from validation.registry.build import prepare
    from validation.registry.default_grid import judged, note_on
    from validation.run.recording import FIELD_FILES, records_of
    from validation.run.resuming import require_checkpoint, way_on

    scene = read_scene(source, settings, until)
    if out is not None:
        require_writable(out, (".nc",))
    if fields is not None:
        require_writable(fields, FIELD_FILES, "--fields")
    require_checkpoint(checkpoint, every)
    resumed = checkpoint is not None and checkpoint.exists()
    built = prepare(model, scene, resumed, cells=cells, cfl=cfl, tolerance=tol, time=time)
    _announce(built)
    notes = _doubts(built.solver, tol)
    with records_of(built.solver, scene.until, out, fields, checkpoint, every) as records:
        done, stopped = _march(built.solver, records, most_seconds(yes))
        default = judged(built.solver, cfl, time) if cells is None and tol is None and not done.failed else None
        notes += note_on(default) if default else []
        for note in notes:
            typer.echo(f"note: {note}", err=True)
        problems = _write(done, built.choice or default, notes, json, records, out, fields)
    conclude(done.failed, problems, way_on(checkpoint) if stopped else "")


def _announce(built: "Built") -> None:
    """Report on stderr what was chosen for the user."""
    if built.choice is not None:
        typer.echo(f"{built.solver.model}: {_grid_words(built.choice)}", err=True)
    if built.why:
        typer.echo(f"model auto: {built.solver.model} ({built.why})", err=True)


def _march(solver: "Solver", records: "Records", most: float) -> "tuple[Run, bool]":
    """The run, and whether the user stopped it."""
    from validation.run.simulate import RunInterrupted, simulate

    try:
        return simulate(solver, solver.scene.until, records.observers, most, records.watch, records.marks), False
    except RunInterrupted as stop:
        return stop.run, True


def _doubts(solver: "Solver", tol: float | None) -> list[str]:
    """Warnings about the result that are known before the run."""
    from validation.registry.families import one_port_of
    from validation.run.determinacy import amplified_rounding

    amplified = amplified_rounding(solver.scene, one_port_of(solver.model), solver.scene.until, tol)
    return [amplified.note] if amplified else []


def _write(
    done: "Run", choice: "Choice | None", notes: list[str], json: bool, records: "Records", out: Path | None, fields: Path | None
) -> list[str]:
    """Print the result and write the requested files; returns one line for each that could not be written."""
    from fullwave.fields.files import write_field
    from validation.output import attempt, printed
    from validation.run.recording import write_run

    record = records.fields if done.final is not None else None
    tasks = [lambda: printed(lambda: _show(done, choice, json, notes))]  # first: writing the files may find a full disk
    if fields is not None and record is not None:
        tasks.append(lambda: write_field(fields, record.field))
    if out is not None:
        within = record if "fields" in done.solver.scene.record else None
        tasks.append(lambda: write_run(out, done, records.history, within.field if within is not None else None))
    return attempt(*tasks)


def _show(done: "Run", choice: "Choice | None", json: bool, notes: list[str]) -> None:
    from validation.output import print_json

    if json:
        print_json(result_of(done, choice) | ({"notes": notes} if notes else {}))
    else:
        _print(done, choice, notes)


def result_of(done: "Run", choice: "Choice | None" = None) -> dict[str, Any]:
    """The JSON of a run (users rely on its keys); `grid` is there only if the user did not choose its cells, `failed` only if
    the numerics failed."""
    from dataclasses import asdict

    found = done.statistics
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
        "energy": _energy(done),
        "failures": done.solver.failures,
        "wall_s": done.wall_s,
    }
    if "time" in done.solver.settings:
        result["time"] = done.solver.settings["time"]
    if choice:
        result["grid"] = {name: getattr(choice, name) for name in ("cells", "step", "quantity", "error_estimate")}
    return result | ({"failed": done.failed} if done.failed else {})


def _grid_words(choice: "Choice") -> str:
    steps = f"steps of {'at most ' * choice.adapts}{choice.step:.4g}"
    return f"{choice.cells} cells, {steps}, estimated error of {choice.quantity} {choice.error_estimate:.1e}"


def _energy(done: "Run") -> dict[str, float] | None:
    if done.energy is None:
        return None
    ledger = {name: getattr(done.energy, name) for name in ("input", "friction", "radiated", "stored", "residual")}
    viscous = any(slab.viscosity for slab in done.solver.scene.slabs)
    return ledger | ({"viscous": done.energy.viscous} if viscous else {})


def _print(done: "Run", choice: "Choice | None", notes: list[str]) -> None:
    from validation.commands.wording import describe, events_in_words, statistics_rows
    from validation.output import figures, print_table

    for line in describe(done.solver.scene):
        print(line)
    if choice is not None:  # the default grid tried no others
        print(f"{'grid chosen for the tolerance' if choice.tried else 'default grid'}: {_grid_words(choice)}")
    for note in notes:
        print(f"note: {note}")
    march = f" ({done.solver.settings['time']} in time)" if "time" in done.solver.settings else ""
    print(f"model {done.solver.model}{march}, {done.until:g} transits: {events_in_words(done.starts, done.verdict)}")
    if done.verdict and done.verdict.repeats:
        print()
        print_table(*statistics_rows(done.statistics, done.solver.scene))
    if done.final:
        state = {"ln v": done.final.ln_v, "psi": done.final.psi, "mu": done.final.mu}
        print("\nat the end: " + ", ".join(f"{name} = {figures(value, 12)}" for name, value in state.items()))
    if done.energy:
        print("energy: " + ", ".join(f"{name} {figures(value, 6)}" for name, value in (_energy(done) or {}).items()))
    if done.solver.failures:
        print(f"interface solves that did not converge: {done.solver.failures}")
    print(f"wall time {done.wall_s:.3g} s")
