"""Base class of results: JSON of the command, dataset, figure, table, and output files. The tables of a summary are `Facts`:
nested dictionaries and lists, as in the JSON.
"""

import html
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, TypeVar, dataclass_transform

from slipwave.errors import SceneError
from slipwave.files import whole_or_absent
from slipwave.scene import Scene
from validation.chart import Chart
from validation.chart.draw import Drawing, draw, styled
from validation.data.datasets import Dataset, as_flags
from validation.data.variables import leaves
from validation.models.provenance import SCHEMA

if TYPE_CHECKING:
    from reduced.orbit.closing import Closed
    from validation.models.branch import FollowedBranch

Row = TypeVar("Row")
_PRINTED = 300
"""Points per inch of a picture of exact size, for print."""


class Facts(dict[str, Any]):
    """A table of a summary, whose keys are attributes too."""

    def __getattr__(self, name: str) -> Any:
        if name not in self:
            raise AttributeError(f"no {name!r} here, only {', '.join(self)}")
        return _as_facts(self[name])


class PointOfBranch(Facts):
    """A point of the branch `followed`: a table of its JSON that commands also take as a scene. `closed`: the orbit of a special
    point, if computed in this process; `place`: the number of any other point on the branch."""

    def __init__(
        self,
        facts: Mapping[str, Any],
        scene: Scene,
        followed: "FollowedBranch",
        closed: "Closed | None" = None,
        place: int | None = None,
    ) -> None:
        super().__init__(facts)
        self.scene, self.followed, self.closed, self.place = scene, followed, closed, place


def _as_facts(value: Any) -> Any:
    """A part of a summary with its tables as `Facts`."""
    if isinstance(value, list):
        return [_as_facts(item) for item in value]
    return Facts(value) if isinstance(value, dict) and not isinstance(value, Facts) else value


def finite(value: Any) -> Any:
    """`value` with None for NaN and infinity, which JSON lacks."""
    if isinstance(value, dict):
        return {key: finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def thinned(rows: Sequence[Row], most: int) -> list[Row]:
    """At most `most` of the rows, equally spaced, and the last one."""
    every = max(1, math.ceil(len(rows) / most))
    return [row for n, row in enumerate(rows) if n % every == 0 or n == len(rows) - 1]


def aligned(heading: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterator[str]:
    """Lines of aligned columns: the first to the left, the others to the right."""
    widths = [max(len(row[column]) for row in [heading, *rows]) for column in range(len(heading))]
    for row in [heading, *rows]:
        cells = [row[0].ljust(widths[0]), *(cell.rjust(width) for cell, width in zip(row[1:], widths[1:], strict=True))]
        yield "  ".join(cells).rstrip()


def rounded(value: float | None, digits: int = 9) -> str:
    """A number for a table; a dash where there is none."""
    return "-" if value is None or math.isnan(value) else f"{value:.{digits}g}"


class Output(NamedTuple):
    """A file that a command writes if its `flag` is given: suffixes, the `method` of the result that writes it, and help.
    `default`: path without the flag, unless the command prints JSON; `key`: key of the JSON for the path."""

    flag: str
    suffixes: tuple[str, ...]
    method: str
    help: str
    metavar: str = "FILE"
    default: str | None = None
    key: str = ""

    @property
    def name(self) -> str:
        """The flag as a Python name."""
        return self.flag.removeprefix("--").replace("-", "_")


@dataclass_transform(frozen_default=True, eq_default=False, field_specifiers=(field,))
class Frozen:
    """Makes each class of options, and of results, a frozen dataclass."""

    def __init_subclass__(cls) -> None:
        dataclass(frozen=True, repr=False, eq=False)(cls)


class Result(Frozen, ABC):
    """A result of a command: its JSON as a dictionary and its keys as attributes, an `xarray.Dataset`, a figure, a netCDF file.

    `failed`: what failed, or empty; `stopped`: whether the user stopped the work. The result then holds what was computed
    before."""

    OUTPUTS: ClassVar[tuple[Output, ...]] = ()
    failed: str = field(default="", kw_only=True)
    stopped: bool = field(default=False, kw_only=True)

    @property
    @abstractmethod
    def facts(self) -> dict[str, Any]:
        """All figures by the keys of the command's JSON, on which users rely."""

    @property
    def summary(self) -> dict[str, Any]:
        """The JSON of the command: the `facts`, None where there is no value, and what failed, if anything did."""
        return dict(finite({"schema": SCHEMA} | self.facts | ({"failed": self.failed} if self.failed else {})))

    @property
    def dataset(self) -> Dataset:
        """All arrays with coordinates and units, for a scene in SI also in SI; provenance as attributes. Raises SceneError if
        there is none."""
        raise SceneError(f"{type(self).__name__}: its figures are in .summary; there is no dataset")

    def chart(self) -> Chart:
        """A figure of the result, as data. Raises SceneError if there is none."""
        raise SceneError(f"{type(self).__name__}: its figures are in .summary; there is no figure")

    def plot(self) -> Drawing:
        """The chart, drawn."""
        return draw(self.chart())

    def lines(self, summary: Mapping[str, Any]) -> Iterable[str]:
        """The lines that the command prints; `summary` also names the written files."""
        return ()

    @classmethod
    def wanted_for(cls, files: Mapping[str, Path | None], options: Any) -> dict[str, Any]:
        """The Python options required by files of these names (`Output.name`). Notes which `options` nothing uses."""
        return {}

    @property
    def is_empty(self) -> bool:
        """Whether there is nothing to print or write."""
        return False

    def to_go_on(self, options: Any) -> str:
        """How to continue after an interruption, for a message."""
        return ""

    def to_netcdf(self, path: str | Path) -> None:
        """Write the dataset. Raises SceneError if the file cannot be written."""
        with whole_or_absent(Path(path)) as temporary:
            whole = {name: {"_FillValue": None} for name in self.dataset.coords}  # of a coordinate no value is missing
            as_flags(self.dataset).to_netcdf(temporary, engine="netcdf4", encoding=whole)

    def save_plot(self, path: str | Path) -> None:
        """Write the figure as .png, .pdf or .svg. Raises SceneError if the file cannot be written."""
        save_chart(path, self.chart)

    def close(self) -> None:
        """Remove temporary files."""

    def __getattr__(self, name: str) -> Any:
        """Value of a key of the JSON, tables as `Facts`."""
        known = {} if name.startswith("_") or name == "summary" else self.summary
        if name not in known:
            raise AttributeError(
                f"{type(self).__name__} has no attribute {name!r}" + (f"; it has {', '.join(known)}" if known else "")
            )
        return _as_facts(known[name])

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *self.summary})

    def __repr__(self) -> str:
        shown = (f"{name} = {value}" for name, value in _scalars(self.summary))
        return f"<{type(self).__name__}: {', '.join(shown)}>"

    def _repr_html_(self) -> str:
        rows = (f"<tr><th>{html.escape(name)}</th><td>{html.escape(value)}</td></tr>" for name, value in _scalars(self.summary))
        return f"<table><caption>{type(self).__name__}</caption>{''.join(rows)}</table>"


class Stopped(KeyboardInterrupt):
    """The user stopped the work; `result`: what was computed before."""

    def __init__(self, message: str, result: Any) -> None:
        super().__init__(message)
        self.result = result


def save_chart(path: str | Path, chart: Callable[[], Chart]) -> None:
    """Write a chart as .png, .pdf or .svg. Raises SceneError if the file cannot be written."""
    with whole_or_absent(Path(path)) as temporary:
        made = chart()
        with styled(made.letters):
            figure = draw(made)
            exact: Any = {"bbox_inches": figure.bbox_inches, "dpi": _PRINTED} if made.is_exact else {"dpi": 150}
            figure.savefig(temporary, **exact)


def _scalars(facts: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Every value in `facts` that is not None, as text with its dotted key, numbers to six digits; for lists of tables their
    number, for special points kind and position."""
    for key, value in leaves(facts):
        if value is not None and key != "schema":
            yield key, f"{value:.6g}" if isinstance(value, float) else str(value)
    for key, rows in facts.items():
        if key == "special":
            yield key, "; ".join(f"{row['type']} at {row.get('value', row.get('log10_r')):.7g}" for row in rows) or "none"
        elif isinstance(rows, list) and rows and isinstance(rows[0], Mapping):
            yield key, str(len(rows))
