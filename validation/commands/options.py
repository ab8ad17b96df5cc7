"""Arguments and options that several commands share."""

from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

from validation.registry.families import FAMILIES, GRIDS

if TYPE_CHECKING:
    from slipwave.scene import Scene

SceneName: TypeAlias = Annotated[
    str, typer.Argument(metavar="SCENE", help="a gallery name (see `slipwave scenes`) or a TOML file")
]
Model: TypeAlias = Annotated[
    str,
    typer.Option(
        help=f"{', '.join(family.pattern for family in FAMILIES)} (without P, it is chosen by --tol), or auto: the cheapest that "
        "is exact for the scene"
    ),
]
Until: TypeAlias = Annotated[float | None, typer.Option(metavar="TRANSITS", help="length of the run (default: the scene's)")]
Settings: TypeAlias = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE ...", help="change one key of the scene, as in slab.log10_r=-2.3; may be repeated"),
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
        help="full wave: propagate the slabs exactly in time, in steps that resolve friction, or by explicit steps (default)",
    ),
]
Tolerance: TypeAlias = Annotated[
    float | None,
    typer.Option(
        "--tol",
        help="requested relative error; a full wave chooses cells and step for it and estimates the error that it reached",
    ),
]
Yes: TypeAlias = Annotated[bool, typer.Option("--yes", help="run it even if it is expected to take more than a day")]


def most_seconds(yes: bool) -> float:
    """Longest expected run time that is accepted, in seconds."""
    import math

    from slipwave.observe.foresight import DAY

    return math.inf if yes else DAY


def read_scene(name: str, settings: list[str] | None, until: float | None = None) -> "Scene":
    """The scene of the command line: its file or gallery name, `--set` changes, `--until`."""
    import slipwave

    overrides = list(settings or ())
    if until is not None:
        overrides.append(f"run.until={until}")
    return slipwave.read(name, overrides)
