"""`slipwave compare`: several models on one scene, in one figure and one table."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from validation.commands.options import (
    Cells,
    Cfl,
    Json,
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
    from validation.measure.cycle import Cycle
    from validation.run.simulate import Run


def compare(
    source: SceneName,
    models: Annotated[
        str, typer.Option(metavar="M1,M2,...", help="the models; the reference is delay if it is among them, else the first")
    ],
    until: Until = None,
    settings: Settings = None,
    cells: Cells = None,
    cfl: Cfl = None,
    time: TimeMarch = None,
    tol: Tolerance = None,
    out: Annotated[Path, typer.Option(metavar="FILE.png", help="the overlay figure")] = Path("compare.png"),
    yes: Yes = False,
    json: Json = False,
) -> None:
    """Draw one cycle of each model in one figure; print periods and stress drops with their errors."""
    from slipwave.observe.foresight import require_time
    from validation.measure.cycle import CycleObserver
    from validation.output import attempt, conclude, print_json, printed, require_writable
    from validation.registry.build import build_all
    from validation.run.simulate import RunInterrupted, second_half, simulate

    scene = read_scene(source, settings, until)
    require_writable(out, (".png", ".pdf", ".svg"))
    solvers = build_all(models, scene, cells=cells, cfl=cfl, tolerance=tol, time=time)
    for solver in solvers:
        require_time(solver, scene.until, most_seconds(yes))
    runs, cycles, stopped = [], [], ""
    for solver in solvers:
        observer = CycleObserver(solver)
        try:
            runs.append(simulate(solver, scene.until, [observer], most_seconds=most_seconds(yes)))
        except RunInterrupted as stop:
            runs.append(stop.run)
            stopped = f"model {solver.model}"
        cycles.append(observer.cycle(second_half(solver, scene.until)))
        if stopped:
            break
    reference = next((run for run in runs if run.solver.model == "delay"), runs[0])
    rows = [_row(run, reference) for run in runs]
    name = reference.solver.model
    result = {"scene": scene.name, "until": scene.until, "reference": name, "figure": str(out), "models": rows}
    problems = attempt(
        lambda: printed(lambda: print_json(result) if json else _print(rows, name, out)), lambda: _draw(out, runs, cycles)
    )
    conclude("; ".join(run.failed for run in runs if run.failed), problems, stopped)


def _row(run: "Run", reference: "Run") -> dict[str, Any]:
    """One model's answer and its relative errors against the reference's."""
    from dataclasses import asdict

    ours = run.statistics
    row = {
        "model": run.solver.model,
        "events": run.starts,
        "verdict": run.kind,
        **{name: asdict(getattr(ours, name)) for name in ("period", "stress_drop", "elastic_stress_drop")},
        "v_max": ours.v_max,
        "v_min": ours.v_min,
        "error": run.errors(reference),
        "failures": run.solver.failures,
        "wall_s": run.wall_s,
    }
    return row | ({"failed": run.failed} if run.failed else {})


def _print(rows: list[dict[str, Any]], reference: str, out: Path) -> None:
    from validation.commands.wording import without_errors
    from validation.output import figures, print_table

    heading = ["model", "period", "std", "stress drop", "elastic drop", "v_max", "v_min", "error T", "error drop", "wall s"]
    table = [
        [
            row["model"],
            figures(row["period"]["mean"]),
            figures(row["period"]["std"], 2),
            figures(row["stress_drop"]["mean"], 7),
            figures(row["elastic_stress_drop"]["mean"], 7),
            figures(row["v_max"], 7),
            figures(row["v_min"], 7),
            figures(row["error"]["period"], 3),
            figures(row["error"]["stress_drop"], 3),
            figures(row["wall_s"], 3),
        ]
        for row in rows
    ]
    print_table(heading, table)
    print(f"\nperiods in transits, relative errors against {reference}; figure: {out}")
    for line in without_errors(rows):
        print(line)
    for row in rows:
        if "failed" in row:
            print(f"failed: {row['failed']}")


def _draw(out: Path, runs: "list[Run]", cycles: "list[Cycle | None]") -> None:
    """Stress and slip rate over one cycle, aligned on the date of the slip event, one pen per model; a transient has no cycle
    and appears in the legend only."""
    from matplotlib.figure import Figure

    from slipwave.files import whole_or_absent

    sheet = Figure(figsize=(9.0, 6.0), layout="constrained")
    above, below = sheet.subplots(2, 1, sharex=True)
    below.set_yscale("log")
    for run, cycle in zip(runs, cycles, strict=True):
        kind = run.kind or "events not watched"
        if cycle is not None and run.verdict and run.verdict.repeats:
            label = f"{run.solver.model}: {kind}, T = {cycle.period:.6g}"
            above.plot(cycle.time, cycle.stress, linewidth=1.0, label=label)
            below.plot(cycle.time, cycle.slip_rate, linewidth=1.0, label=label)
        else:
            above.plot([], [], linewidth=1.0, label=f"{run.solver.model}: {kind}, no cycle")
            below.plot([], [])
    above.set_title("The last complete cycle of each run; T: its length in transits", fontsize="medium")
    above.set_ylabel("friction stress / normal stress")
    below.set(ylabel="slip rate / V*", xlabel="transits since v passed half its largest value in the slip event")
    above.legend(fontsize="small")
    with whole_or_absent(out) as temporary:
        sheet.savefig(temporary, dpi=150)
