"""`slipwave orbit`: the periodic orbit of a scene with its errors and its stability."""

from typing import TYPE_CHECKING, Annotated

import typer

from validation.commands.options import Cells, Json, Model, SceneName, Settings, read_scene

if TYPE_CHECKING:
    from validation.registry.orbits import OrbitFound

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
    import slipwave
    from validation.output import print_json, printed

    result = slipwave.orbit(read_scene(source, settings), model, tol=tol, cells=cells)
    printed(lambda: print_json(result.summary) if json else _print(result.found))


def _print(done: "OrbitFound") -> None:
    from validation.commands.header import header
    from validation.commands.wording import orbit_rows
    from validation.output import figures, print_table

    multipliers, scene = done.found.multipliers, done.scene
    for line in header(scene):
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
