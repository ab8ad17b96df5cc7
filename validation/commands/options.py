"""Arguments and options that several commands share."""

from pathlib import Path
from typing import Annotated, TypeAlias

import typer

from validation.registry.families import FAMILIES, GRIDS


def _gallery() -> list[str]:
    """Names for the shell's completion."""
    from slipwave.input.source import gallery_names

    return gallery_names()


def _models() -> list[str]:
    return ["auto", *(family.example for family in FAMILIES)]


SceneName: TypeAlias = Annotated[
    str,
    typer.Argument(
        metavar="SCENE",
        help="a gallery name (see `slipwave scenes`), a TOML file, or a netCDF file of results",
        autocompletion=_gallery,
    ),
]
Model: TypeAlias = Annotated[
    str,
    typer.Option(
        help=f"{', '.join(family.pattern for family in FAMILIES)} (without P, it is chosen by --tol), or auto: the cheapest that "
        "is exact for the scene",
        autocompletion=_models,
    ),
]
Until: TypeAlias = Annotated[
    str | None,
    typer.Option(
        metavar="TRANSITS|TIME",
        help="length of the run, in transits or, in scenes with SI units, as 60s (default: the scene's, else until the motion is "
        "settled)",
    ),
]
Settings: TypeAlias = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE ...", help="change one key of the scene, as in slab.log10_r=-2.3; may be repeated"),
]


def _load_law(path: Path | None) -> Path | None:
    if path is not None:
        from slipwave.friction.own import load_laws

        load_laws(path)
    return path


Law: TypeAlias = Annotated[
    Path | None,
    typer.Option("--law", metavar="FILE.py", help="run this Python file, which registers a friction law", callback=_load_law),
]
Json: TypeAlias = Annotated[bool, typer.Option("--json", help="print JSON instead of a table")]
Cells: TypeAlias = Annotated[int | None, typer.Option(help="full wave: cells per slab")]
_STEPS = dict.fromkeys(
    f"{family.step} ({', '.join(other.name for other in GRIDS if other.step == family.step)})" for family in GRIDS
)
Cfl: TypeAlias = Annotated[
    float | None, typer.Option(help=f"full wave: time step, above 0 to 1, in units of {' or '.join(_STEPS)}")
]
TimeMarch: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--time",
        metavar="exact|explicit",
        help="full wave: propagate the slabs exactly in time, in steps that resolve friction, or by explicit steps; by default "
        "exactly, but explicitly with --cfl, after a jump and on large grids",
    ),
]
Tolerance: TypeAlias = Annotated[
    float | None,
    typer.Option(
        "--tol",
        help="requested relative error; a full wave chooses cells and steps for it and estimates the error that it reached; with "
        "--cells it is for the steps of the exact march only",
    ),
]
Yes: TypeAlias = Annotated[bool, typer.Option("--yes", help="run it even if it is expected to take more than a day")]


def most_seconds(yes: bool) -> float:
    """Longest expected run time that is accepted, in seconds."""
    import math

    from slipwave.solve.foresight import DAY

    return math.inf if yes else DAY
