"""`slipwave run`: one model on one scene."""

from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import slipwave
from slipwave.files import part_of
from validation.commands.options import (
    Cells,
    Cfl,
    Json,
    Law,
    Model,
    SceneName,
    Settings,
    TimeMarch,
    Tolerance,
    Until,
    Yes,
    most_seconds,
)
from validation.output import FIGURES, conclude, deliver, figures, print_json, print_table, require_writable

if TYPE_CHECKING:
    from validation.door.run_result import RunResult

CycleCount = Annotated[
    int | None, typer.Option(metavar="N", help="end when the second half of the run has N complete cycles, not --until")
]
OutFile = Annotated[Path | None, typer.Option(metavar="FILE.nc", help="write events, and the interface and fields if recorded")]
FieldFile = Annotated[
    Path | None,
    typer.Option(metavar="FILE", help="full wave: write velocity and stress of the last 100 transits, .vtu, .xdmf or .nc"),
]
EventFile = Annotated[Path | None, typer.Option(metavar="FILE.csv", help="write the slip events, in s and Pa for scenes in SI")]
CheckpointFile = Annotated[
    Path | None, typer.Option(metavar="FILE", help="save checkpoints here during the run, and go on from FILE if it exists")
]
CheckpointEvery = Annotated[
    str | None, typer.Option(metavar="TRANSITS|TIME", help="time between checkpoints, in transits or as 10s (default 1000)")
]
Every = Annotated[int | None, typer.Option(metavar="N", help="keep one in N samples of the interface's history")]
Window = Annotated[str | None, typer.Option(metavar="A:B", help="keep only the history from A to B, in transits or as 10s:60s")]
Plot = Annotated[Path | None, typer.Option(metavar="FILE", help="draw stress and slip rate over time: .png, .pdf or .svg")]
MapFile = Annotated[
    Path | None, typer.Option("--return-map", metavar="FILE", help="draw the period of each cycle over that of the one before")
]
Lyapunov = Annotated[
    bool, typer.Option("--lyapunov", help="how fast motions close by part: the largest Lyapunov exponent, by a second march")
]

EXAMPLES = (
    "slipwave run paper --model modal:2 --set slab.log10_r=-2.6 --plot run.png",
    "slipwave run paper --out run.nc --every 10",
    "slipwave run run.nc",
)


def run(
    source: SceneName,
    model: Model = "auto",
    until: Until = None,
    cycles: CycleCount = None,
    settings: Settings = None,
    law: Law = None,
    cells: Cells = None,
    cfl: Cfl = None,
    time: TimeMarch = None,
    tol: Tolerance = None,
    out: OutFile = None,
    fields: FieldFile = None,
    events: EventFile = None,
    checkpoint: CheckpointFile = None,
    checkpoint_every: CheckpointEvery = None,
    every: Every = None,
    window: Window = None,
    plot: Plot = None,
    map_file: MapFile = None,
    lyapunov: Lyapunov = False,
    yes: Yes = False,
    json: Json = False,
) -> None:
    """Run one model on one scene; print events, periods and stress drops of the run's second half."""
    from validation.door.result import delivered, save_drawing
    from validation.run.recording import FIELD_FILES
    from validation.run.resuming import way_on

    require_writable(out, (".nc",))
    require_writable(fields, FIELD_FILES, "--fields")
    require_writable(plot, FIGURES, "--plot")
    require_writable(map_file, FIGURES, "--return-map")
    require_writable(events, (".csv",), "--events")
    result, failed, stopped = delivered(
        lambda: slipwave.run(
            source,
            model,
            until=until,
            settings=settings or (),
            cycles=cycles,
            cells=cells,
            cfl=cfl,
            time=time,
            tol=tol,
            interface=None if out is not None else False,
            every=every,
            window=window,
            fields=True if fields is not None else None if out is not None else False,
            samples=part_of(out, ".samples") if out is not None else None,
            checkpoint=checkpoint,
            checkpoint_every=checkpoint_every,
            lyapunov=lyapunov,
            most_seconds=most_seconds(yes),
        )
    )
    for note in result.notes:
        typer.echo(f"note: {note}", err=True)
    files = (
        (result.write_events, events),
        (result.write_fields, fields),
        (result.to_netcdf, out),
        (result.save_plot, plot),
        (lambda path: save_drawing(path, result.plot_return_map), map_file),
    )
    with closing(result):
        problems = deliver(lambda: print_json(result.summary) if json else _print(result), *files)
    conclude("; ".join([failed, *([way_on(checkpoint)] if stopped else [])]), problems, stopped)


def _print(result: "RunResult") -> None:
    from validation.commands.header import print_header
    from validation.commands.wording import ENDED, events_in_words, exponent_in_words, margins_in_words, statistics_rows
    from validation.door.run import grid_in_words
    from validation.run.stage_table import missing_in_words, stage_rows, stages_in_words

    done, choice = result.done, result.choice
    print_header(done.solver.scene)
    if choice is not None:  # the default grid tried no others
        print(f"{'grid chosen for the tolerance' if choice.tried else 'default grid'}: {grid_in_words(choice)}")
    for note in result.notes:
        print(f"note: {note}")
    march = f" ({done.solver.settings['time']} in time)" if "time" in done.solver.settings else ""
    words = f": {stages_in_words(result.stages)}" if done.kind == "protocol" else ""
    judged = f"{events_in_words(done.starts, done.verdict, result.needed)}{words}"
    print(f"model {done.solver.model}{march}, {done.until:g} transits: {judged}")
    for line in result.reasons:
        print(line)
    if done.ended in ENDED:
        print(ENDED[done.ended])
    if done.verdict and done.verdict.repeats:
        print()
        print_table(*statistics_rows(done.statistics, done.solver.scene))
        for line in margins_in_words(done.statistics, done.solver.scene):
            print(line)
    if result.exponent is not None:
        print(exponent_in_words(result.exponent))
    if result.stages:
        print()
        print_table(*stage_rows(result.stages, done.solver.scene))
        for line in missing_in_words(result.stages):
            print(line)
    if done.final:
        state = {"ln v": done.final.ln_v, "psi": done.final.psi, "mu": done.final.mu}
        print("\nat the end: " + ", ".join(f"{name} = {figures(value, 12)}" for name, value in state.items()))
    if result.energy:
        print("energy: " + ", ".join(f"{name} {figures(value, 6)}" for name, value in result.energy.items()))
    if done.solver.failures:
        print(f"interface solves that did not converge: {done.solver.failures}")
    print(f"wall time {done.wall_s:.3g} s")
