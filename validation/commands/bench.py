"""`slipwave bench`: run time against error, every model that can do the scene, at several settings each."""

from typing import TYPE_CHECKING, Any

from validation.commands.options import Json, SceneName, Settings, Until, Yes, most_seconds, read_scene

if TYPE_CHECKING:
    from slipwave.family import Family
    from slipwave.scene import Scene
    from validation.run.simulate import Run

_TOLERANCES = (1e-5, 1e-7, 1e-9)
_REFERENCE_TOLERANCE = 1e-11


def bench(source: SceneName, until: Until = None, settings: Settings = None, yes: Yes = False, json: Json = False) -> None:
    """Time every model against its error in period and stress drop; the reference is the delay system at a tight tolerance.

    A model that cannot do the scene (quasistatic runs away) still has a row in the table. A failed solve or a failed reference is
    reported again at the end.
    """
    from slipwave.errors import SceneError
    from validation.output import conclude, print_json
    from validation.registry.build import honouring
    from validation.run.progress import progress
    from validation.run.simulate import RunInterrupted

    scene = read_scene(source, settings, until)
    trials = [(family, setting) for family in honouring(scene) for setting in _settings(family)]
    if not trials:
        raise SceneError(f"scene = {scene.name!r}: no model of this installation can do it")
    reference = _reference(scene, trials, most_seconds(yes))
    rows: list[dict[str, Any]] = []
    stopped = ""
    with progress("bench", len(trials)) as report:
        for done, (family, setting) in enumerate(trials):
            try:
                rows.append(_row(_timed(scene, family, setting, most_seconds(yes)), setting, reference))
            except RunInterrupted:
                stopped = f"after {done} of {len(trials)} runs"
                break
            report(done + 1)
    name = reference.solver.model
    if json:
        print_json({"scene": scene.name, "until": scene.until, "reference": name, "models": rows})
    else:
        _print(rows, name, scene.until)
    failed = [reference.failed] if reference.failed else [row["failed"] for row in rows if row["failures"]]
    conclude("; ".join(["interrupted"] * bool(stopped) + failed), [], stopped)


def _settings(family: "Family") -> list[dict[str, Any]]:
    if family.grids:
        return [{"cells": cells} for cells in family.grids]
    return [{"tolerance": tolerance} for tolerance in _TOLERANCES]


def _reference(scene: "Scene", trials: "list[tuple[Family, dict[str, Any]]]", most: float) -> "Run":
    """The delay system at a tight tolerance; for scenes it cannot do, the last full-wave family at its finest setting."""
    family = next((family for family, _ in trials if family.name == "delay"), None)
    if family is not None:
        return _timed(scene, family, {"tolerance": _REFERENCE_TOLERANCE}, most)
    return _timed(scene, *trials[-1], most)


def _timed(scene: "Scene", family: "Family", setting: dict[str, Any], most: float) -> "Run":
    from validation.run.simulate import simulate
    from validation.work_precision import Setting, solver_of, warm_up

    chosen = Setting(family.example, **setting)
    warm_up(chosen, scene)
    return simulate(solver_of(chosen, scene), scene.until, most_seconds=most)


def _row(run: "Run", setting: dict[str, Any], reference: "Run") -> dict[str, Any]:
    row = {
        "model": run.solver.model,
        "setting": setting,
        "verdict": run.kind,
        "wall_s": run.wall_s,
        "error": {name: abs(error) for name, error in run.errors(reference).items()},
        "failures": run.solver.failures,
    }
    return row | ({"failed": run.failed} if run.failed else {})


def _print(rows: list[dict[str, Any]], reference: str, until: float) -> None:
    from validation.commands.wording import without_errors
    from validation.output import figures, print_table

    heading = ["model", "setting", "wall s", "error T", "error drop"]
    table = [
        [
            row["model"],
            ", ".join(f"{name} {value:g}" for name, value in row["setting"].items()) or "-",
            figures(row["wall_s"], 3),
            figures(row["error"]["period"], 3),
            figures(row["error"]["stress_drop"], 3),
        ]
        for row in rows
    ]
    print_table(heading, table)
    print(f"\n{until:g} transits; relative errors of the second half's mean against {reference} (tight)")
    for line in without_errors(rows):
        print(line)
    for reason in {row["model"]: row["failed"] for row in rows if "failed" in row}.values():
        print(f"failed: {reason}")
