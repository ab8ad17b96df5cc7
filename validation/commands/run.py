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
    Tolerance,
    Until,
    Yes,
    most_seconds,
    read_scene,
)

if TYPE_CHECKING:
    from slipwave.observe import Solver
    from validation.run.simulate import Run


def run(
    source: SceneName,
    model: Model = "auto",
    until: Until = None,
    settings: Settings = None,
    cells: Cells = None,
    cfl: Cfl = None,
    tol: Tolerance = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE.nc", help="write events, and the interface and fields if recorded")
    ] = None,
    fields: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="full wave: write velocity and stress of the last 100 transits, .vtu, .xdmf or .nc"),
    ] = None,
    checkpoint: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="full wave: save the run here on its way, and go on from FILE if it exists"),
    ] = None,
    every: Annotated[
        float | None, typer.Option("--checkpoint-every", metavar="TRANSITS", help="time between checkpoints (default 1000)")
    ] = None,
    yes: Yes = False,
    json: Json = False,
) -> None:
    """Run one model on one scene; print events, periods and stress drops of the run's second half."""
    from fullwave.fields.files import write_field
    from slipwave.observe import follow
    from validation.output import attempt, conclude, printed, require_writable
    from validation.registry.build import build, resolve
    from validation.registry.default_grid import judged, note_on
    from validation.registry.families import one_port_of
    from validation.run.determinacy import amplified_rounding
    from validation.run.recording import FIELD_FILES, fields_for, history_for, write_run
    from validation.run.resuming import march_for, way_on
    from validation.run.simulate import RunInterrupted, simulate

    scene = read_scene(source, settings, until)
    if out is not None:
        require_writable(out, (".nc",))
    if fields is not None:
        require_writable(fields, FIELD_FILES, "--fields")
    chosen, why = resolve(model, scene)
    solver: Any = build(chosen, scene, cells, cfl, tol)
    amplified = amplified_rounding(scene, one_port_of(solver.model), scene.until, tol)
    notes = [amplified.note] if amplified else []
    grid = _grid(solver)
    if grid is not None:
        typer.echo(f"{solver.model}: {_told(grid)}", err=True)
    picture = fields_for(solver, fields, out)
    march = march_for(solver, checkpoint, every, picture or follow)
    if why:
        typer.echo(f"model auto: {chosen} ({why})", err=True)
    stopped = False
    with history_for(solver, scene.until, out, checkpoint) as history:
        try:
            done = simulate(solver, scene.until, [history] if history is not None else [], march, most_seconds(yes))
        except RunInterrupted as stop:
            done, stopped = stop.run, True
        if cells is None and tol is None and not done.failed:
            default = judged(solver, cfl)
            if default is not None:
                solver.choice = default
                notes += note_on(default)
        for note in notes:
            typer.echo(f"note: {note}", err=True)
        field = picture.field if picture is not None else None
        deeds = [lambda: printed(lambda: _show(done, json, notes))]  # first: what follows may meet a full disk
        if fields is not None and field is not None:
            deeds.append(lambda: write_field(fields, field))
        if out is not None:
            deeds.append(lambda: write_run(out, done, history, field if "fields" in scene.record else None))
        problems = attempt(*deeds)
    conclude(done.failed, problems, way_on(solver, checkpoint) if stopped else "")


def _show(done: "Run", json: bool, notes: list[str]) -> None:
    from validation.output import print_json

    if json:
        print_json(result_of(done) | ({"notes": notes} if notes else {}))
    else:
        _print(done, notes)


def result_of(done: "Run") -> dict[str, Any]:
    """The JSON of a run (users rely on its keys); `grid` is there only if the user did not choose its cells, `failed` only if
    the numerics failed."""
    from dataclasses import asdict

    found = done.statistics
    result: dict[str, Any] = {
        "scene": done.solver.scene.name,
        "model": done.solver.model,
        "until": done.until,
        "events": done.starts,
        "verdict": done.verdict.kind if done.verdict else None,
        "multiplicity": done.verdict.multiplicity if done.verdict else None,
        **{name: asdict(getattr(found, name)) for name in ("period", "stress_drop", "elastic_stress_drop")},
        "v_max": found.v_max,
        "v_min": found.v_min,
        "final": asdict(done.final) if done.final else None,
        "energy": _energy(done),
        "failures": done.solver.failures,
        "wall_s": done.wall_s,
    }
    grid = _grid(done.solver)
    return result | ({"grid": grid} if grid else {}) | ({"failed": done.failed} if done.failed else {})


def _grid(solver: "Solver") -> dict[str, Any] | None:
    """The grid that a full wave chose, for a tolerance or by default, and its estimated error (`fullwave.adapt.Choice`)."""
    choice = getattr(solver, "choice", None)
    return {name: getattr(choice, name) for name in ("cells", "step", "quantity", "error_estimate")} if choice else None


def _grid_word(solver: Any) -> str:
    """Who chose the grid: a choice by default tried no others."""
    return "grid chosen for the tolerance" if solver.choice.tried else "default grid"


def _told(grid: dict[str, Any]) -> str:
    return (
        f"{grid['cells']} cells, steps of {grid['step']:.4g}, estimated error of {grid['quantity']} {grid['error_estimate']:.1e}"
    )


def _energy(done: "Run") -> dict[str, float] | None:
    if done.energy is None:
        return None
    ledger = {name: getattr(done.energy, name) for name in ("input", "friction", "radiated", "stored", "residual")}
    viscous = any(slab.viscosity for slab in (done.solver.scene.upper, done.solver.scene.lower))
    return ledger | ({"viscous": done.energy.viscous} if viscous else {})


def _print(done: "Run", notes: list[str]) -> None:
    from validation.commands.wording import describe, statistics_rows, told_events
    from validation.output import figures, print_table

    for line in describe(done.solver.scene):
        print(line)
    grid = _grid(done.solver)
    if grid:
        print(f"{_grid_word(done.solver)}: {_told(grid)}")
    for note in notes:
        print(f"note: {note}")
    print(f"model {done.solver.model}, {done.until:g} transits: {told_events(done.starts, done.verdict)}")
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
