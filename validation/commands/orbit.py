"""`slipwave orbit`: the periodic orbit of a scene with its errors and its stability."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import slipwave
from validation.commands.options import Cells, Json, Law, Model, SceneName, Settings
from validation.output import FIGURES, conclude, deliver, figures, print_json, print_table, require_writable

if TYPE_CHECKING:
    from validation.registry.orbits import OrbitFound

_SHOWN = 6  # multipliers in the table
_ROUNDING = 1e-12  # those below are noise

OrbitTolerance = Annotated[
    float | None, typer.Option("--tol", help="requested relative error of period, drops and slip rates (default 1e-8)")
]
NearPeriod = Annotated[
    str | None,
    typer.Option("--near-period", metavar="TIME", help="where orbits coexist: the one with the period nearest to this"),
]
Others = Annotated[
    bool, typer.Option("--others", help="name the orbits that coexist with it, along the branch from the onset on")
]
OutFile = Annotated[Path | None, typer.Option(metavar="FILE.nc", help="write the motion over one period and the multipliers")]
Plot = Annotated[Path | None, typer.Option(metavar="FILE", help="draw the motion over one period: .png, .pdf or .svg")]

EXAMPLES = ("slipwave orbit paper --set slab.log10_r=-2.65 --out orbit.nc",)


def orbit(
    source: SceneName,
    model: Model = "auto",
    tol: OrbitTolerance = None,
    near_period: NearPeriod = None,
    others: Others = False,
    settings: Settings = None,
    law: Law = None,
    cells: Cells = None,
    out: OutFile = None,
    plot: Plot = None,
    json: Json = False,
) -> None:
    """The periodic orbit that a run of the scene leads to, stable or not: figures with errors, and Floquet multipliers.

    Where several orbits coexist, a run leads to one at most: --others names the rest, --near-period finds them. A full wave
    marches exactly in time; its orbit is that of its grid.
    """
    require_writable(out, (".nc",))
    require_writable(plot, FIGURES, "--plot")
    result = slipwave.orbit(
        source, model, tol=tol, near_period=near_period, others=others or None, cells=cells, settings=settings or ()
    )
    files = ((result.to_netcdf, out), (result.save_plot, plot))
    conclude("", deliver(lambda: print_json(result.summary) if json else _print(result.found), *files))


def _print(done: "OrbitFound") -> None:
    from validation.results.header import header
    from validation.results.wording import orbit_rows

    multipliers, scene = done.found.multipliers, done.scene
    print("\n".join(header(scene, done.notes)))
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
    if rows:
        print_table(["largest multipliers", "modulus"], rows)
    else:
        print("no multiplier lies outside the essential radius")
    more = f"; {len(shown) - _SHOWN} more" if len(shown) > _SHOWN else ""
    radius = f"; essential radius {figures(multipliers.essential_radius, 4)}" if multipliers.essential_radius else ""
    print(f"the trivial one is 1 within {figures(multipliers.trivial_defect, 2)}{radius}{more}")
    print(f"wall time {done.wall_s:.3g} s")
