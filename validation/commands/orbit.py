"""`slipwave orbit`: the periodic orbit of a scene with its errors and its stability."""

from typing import TYPE_CHECKING, Annotated, Any

import typer

from validation.commands.options import Cells, Json, Model, SceneName, Settings, read_scene

if TYPE_CHECKING:
    from slipwave.scene import Scene
    from validation.registry.orbits import OrbitFound

SCHEMA = 1
"""Version of the keys of the JSON."""

_SHOWN = 6  # multipliers in the table
_ROUNDING = 1e-12  # those below are noise

OrbitTolerance = Annotated[float, typer.Option("--tol", help="requested relative error of period, drops and slip rates")]


def orbit(
    source: SceneName,
    model: Model = "auto",
    tol: OrbitTolerance = 1e-8,
    settings: Settings = None,
    cells: Cells = None,
    json: Json = False,
) -> None:
    """The periodic orbit that a run of the scene leads to, stable or not: figures with errors, and Floquet multipliers.

    A full wave marches exactly in time; its orbit is that of its grid.
    """
    from validation.output import print_json, printed
    from validation.registry.flows import moving
    from validation.registry.orbits import find_orbit, require_tolerance

    require_tolerance(tol)
    chosen = moving(model, read_scene(source, settings), tol, cells)
    if chosen.why:
        typer.echo(f"model auto: {chosen.solver.model} ({chosen.why})", err=True)
    found = find_orbit(chosen, tol)
    printed(lambda: print_json(result_of(found)) if json else _print(found))


def result_of(done: "OrbitFound") -> dict[str, Any]:
    """The JSON of the command (users rely on its keys); `si` is there only for scenes in SI."""
    orbit, multipliers, scene = done.found.orbit, done.found.multipliers, done.scene
    result = {
        "schema": SCHEMA,
        "scene": scene.name,
        "model": done.flow.model,
        "clock": "transit",
        **orbit.values(),
        "period_time": orbit.period.value * scene.transit,
        "stable": multipliers.stable,
        "multipliers": [[value.real, value.imag] for value in multipliers.values.tolist()],
        "trivial_defect": multipliers.trivial_defect,
        "residual": done.found.closed.residual,
        "error_estimate": {name: getattr(orbit, name).error for name in ("period", "stress_drop")},
        "essential_radius": multipliers.essential_radius,
        "wall_s": done.wall_s,
        "notes": done.notes,
    }
    return result | ({"si": _in_si(orbit.values(), scene)} if scene.units else {})


def _in_si(values: dict[str, float], scene: "Scene") -> dict[str, float]:
    units = scene.units
    assert units is not None
    transit = scene.transit * units.time
    return {
        "period_s": values["period"] * transit,
        **{f"{name}_Pa": values[name] * units.normal_stress for name in ("stress_drop", "elastic_stress_drop")},
        **{f"{name}_m_per_s": values[name] * units.reference_velocity for name in ("v_max", "v_min")},
        "transit_s": transit,
    }


def _print(done: "OrbitFound") -> None:
    from validation.commands.wording import describe, orbit_rows
    from validation.output import figures, print_table

    multipliers, scene = done.found.multipliers, done.scene
    for line in describe(scene):
        print(line)
    for note in done.notes:
        print(f"note: {note}")
    verdict = {True: "stable", False: "unstable", None: "its stability is not decided"}[multipliers.stable]
    print(f"model {done.flow.model}: periodic orbit, {verdict}; it closes to {figures(done.found.closed.residual, 2)}")
    print()
    print_table(*orbit_rows(done.found.orbit, scene))
    print()
    shown = [value for value in multipliers.values.tolist() if value.imag >= 0.0 and abs(value) > _ROUNDING]
    rows = [
        [figures(value.real, 8) + (f" +- {value.imag:.8g} i" if value.imag else ""), figures(abs(value), 8)]
        for value in shown[:_SHOWN]
    ]
    print_table(["largest multipliers", "modulus"], rows)
    more = f"; {len(shown) - _SHOWN} more" if len(shown) > _SHOWN else ""
    radius = f"; essential radius {figures(multipliers.essential_radius, 4)}" if multipliers.essential_radius else ""
    print(f"the trivial one is 1 within {figures(multipliers.trivial_defect, 2)}{radius}{more}")
    print(f"wall time {done.wall_s:.3g} s")
