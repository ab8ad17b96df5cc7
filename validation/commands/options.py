"""Arguments and options that several commands share."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

if TYPE_CHECKING:
    from slipwave.scene import Scene

SceneName: TypeAlias = Annotated[
    str, typer.Argument(metavar="SCENE", help="a gallery name (see `slipwave scenes`) or a TOML file")
]
Model: TypeAlias = Annotated[
    str,
    typer.Option(
        help="delay, quasistatic, quasidynamic, block8, block12, kelvin-voigt, modal:N, fitted:N, fd, sbp:P, fem:P, dg:P "
        "(sbp, fem and dg choose P themselves, by --tol), or auto: the cheapest that is exact for the scene"
    ),
]
Until: TypeAlias = Annotated[float | None, typer.Option(metavar="TRANSITS", help="length of the run (default: the scene's)")]
Settings: TypeAlias = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE ...", help="change one key of the scene, as in slab.log10_r=-2.3; may be repeated"),
]
Json: TypeAlias = Annotated[bool, typer.Option("--json", help="print JSON instead of a table")]
Cells: TypeAlias = Annotated[int | None, typer.Option(help="full wave: cells per slab")]
Cfl: TypeAlias = Annotated[float | None, typer.Option(help="full wave: c dt / dx")]
Tolerance: TypeAlias = Annotated[
    float | None,
    typer.Option(
        "--tol", help="relative error asked for; a full wave chooses cells and step for it and estimates what it reached"
    ),
]
Yes: TypeAlias = Annotated[bool, typer.Option("--yes", help="run it even if it is expected to take more than a day")]
Out: TypeAlias = Annotated[Path | None, typer.Option(help="file to write")]


def most_seconds(yes: bool) -> float:
    """How long a run may be expected to take."""
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
