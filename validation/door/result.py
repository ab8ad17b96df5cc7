"""What the functions of the door have in common: results, and how one that ended early is handed over."""

import html
import logging
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from inspect import signature
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from slipwave.errors import NumericsError, SceneError
from slipwave.extras import require
from slipwave.files import whole_or_absent
from slipwave.input import SceneSource, read, read_scene
from slipwave.input.wording import nearest, shorten
from slipwave.scene import Scene
from slipwave.scene.doubts import doubts
from validation.run.quantities import column_notes
from validation.study.drawing import Drawing, styled

if TYPE_CHECKING:
    from xarray import Dataset as Dataset

    from reduced.orbit.closing import Closed
else:  # xarray is loaded only when a dataset is made
    Dataset = Any

log = logging.getLogger("slipwave")
"""What is chosen for the user and how far long work has come, at level INFO; the command line prints it on stderr."""


class Facts(dict[str, Any]):
    """A table of a summary, whose keys are attributes too."""

    def __getattr__(self, name: str) -> Any:
        if name not in self:
            raise AttributeError(f"no {name!r} here, only {', '.join(self)}")
        return facts_of(self[name])


class Place(Facts):
    """A point of a branch: a table of its JSON that is also a source of the `scene` there, for `slipwave.orbit` and others.
    `model` and `tolerance` are those of the branch, `closed` is the orbit of a special point that was computed just now."""

    scene: Scene
    model: str
    closed: "Closed | None"
    tolerance: float

    def __init__(self, facts: Mapping[str, Any], scene: Scene, model: str, closed: "Closed | None", tolerance: float) -> None:
        super().__init__(facts)
        self.scene, self.model, self.closed, self.tolerance = scene, model, closed, tolerance


def facts_of(value: Any) -> Any:
    """A part of a summary with its tables as `Facts`."""
    if isinstance(value, list):
        return [facts_of(item) for item in value]
    return Facts(value) if isinstance(value, dict) and not isinstance(value, Facts) else value


class Result(ABC):
    """A result of the door: the JSON of its command as a dictionary and its keys as attributes, an `xarray.Dataset`, a figure, a
    netCDF file."""

    @property
    @abstractmethod
    def summary(self) -> dict[str, Any]:
        """All figures by the keys of the command's JSON; None where there is no value."""

    @property
    @abstractmethod
    def dataset(self) -> Dataset:
        """All arrays with coordinates and units; for a scene in SI also in SI. The attributes say where it comes from."""

    @abstractmethod
    def plot(self) -> Drawing:
        """A figure of it, in the house style."""

    def to_netcdf(self, path: str | Path) -> None:
        """Write the dataset. Raises SceneError if the file cannot be written."""
        with whole_or_absent(Path(path)) as temporary:
            whole = {name: {"_FillValue": None} for name in self.dataset.coords}  # of a coordinate no value is missing
            self.dataset.to_netcdf(temporary, engine="netcdf4", encoding=whole)

    def save_plot(self, path: str | Path) -> None:
        """Write the figure as .png, .pdf or .svg. Raises SceneError if the file cannot be written."""
        save_drawing(path, self.plot)

    def __getattr__(self, name: str) -> Any:
        """What the JSON says by its key, tables as `Facts`."""
        known = {} if name.startswith("_") or name == "summary" else self.summary
        if name not in known:
            raise AttributeError(
                f"{type(self).__name__} has no attribute {name!r}" + (f"; it has {', '.join(known)}" if known else "")
            )
        return facts_of(known[name])

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *self.summary})

    def __repr__(self) -> str:
        shown = (f"{name} = {value}" for name, value in _scalars(self.summary))
        return f"<{type(self).__name__}: {', '.join(shown)}>"

    def _repr_html_(self) -> str:
        rows = (f"<tr><th>{html.escape(name)}</th><td>{html.escape(value)}</td></tr>" for name, value in _scalars(self.summary))
        return f"<table><caption>{type(self).__name__}</caption>{''.join(rows)}</table>"


Delivered = TypeVar("Delivered", bound=Result)


class Stopped(KeyboardInterrupt):
    """The user stopped the work; `result` is what was known by then."""

    def __init__(self, message: str, result: Any) -> None:
        super().__init__(message)
        self.result = result


def save_drawing(path: str | Path, draw: Callable[[], Drawing]) -> None:
    """Write the figure that `draw` makes as .png, .pdf or .svg. Raises SceneError if the file cannot be written."""
    with styled(), whole_or_absent(Path(path)) as temporary:
        draw().savefig(temporary, dpi=150)


def as_path(path: str | Path | None) -> Path | None:
    """A path of the user's as a `Path`."""
    return None if path is None else Path(path)


def _options() -> list[str]:
    """What the functions of the door take besides the tables of a scene."""
    import slipwave

    door = [found for name in slipwave.__all__ if (found := getattr(slipwave, name)).__module__.startswith("validation.door.")]
    return sorted({name for function in door for name in signature(function).parameters} - {"changes"})


def _require_known(changes: Mapping[str, Any], tables: Mapping[str, Any]) -> None:
    """Raises SceneError for a keyword that is neither an option nor a key of a scene with these `tables`; it names the
    nearest."""
    from slipwave.input.overrides import endings
    from slipwave.input.schema import SceneTable

    for key in changes:
        if not endings(key.split("."), tables):
            guess = nearest(key, [*_options(), *SceneTable.model_fields])
            hint = f"; did you mean {guess}?" if guess else ""
            raise SceneError(f"{shorten(key)[1:-1]} = {shorten(changes[key])}: neither an option nor a key of a scene{hint}")


def _as_list(settings: Iterable[str]) -> Iterable[str]:
    return [settings] if isinstance(settings, str) else settings


def scene_of(source: SceneSource, settings: Iterable[str], changes: Mapping[str, Any], until: float | str | None = None) -> Scene:
    """The scene of a call: `source` with `settings` ("key=value"), `changes` and, if given, another length (transits, or a text
    with a unit of time). Tells what is doubtful about it."""
    length = [] if until is None else [f"run.until={until}"]
    given = read(source.scene if isinstance(source, Place) else source, [*_as_list(settings), *length])
    _require_known(changes, given.tables or {})
    scene = read_scene(given, **changes)
    for line in doubts(scene):
        log.warning("note: %s", line)
    return scene


def announced(model: str, why: str) -> str:
    """`model`; the log says why `auto` chose it, if it did."""
    if why:
        log.info("model auto: %s (%s)", model, why)
    return model


def deliver(result: Delivered, failed: str, stopped: bool = False) -> Delivered:
    """`result`. Raises NumericsError if `failed` says what failed, Stopped if the user stopped it; both hold the result."""
    if stopped:
        raise Stopped(failed, result)
    if failed:
        raise NumericsError(failed, result)
    return result


def delivered(work: Callable[[], Delivered]) -> tuple[Delivered, str, bool]:
    """The inverse of `deliver`: the result of `work`, what failed, and whether the user stopped it. An error without a result is
    raised again."""
    try:
        return work(), "", False
    except (NumericsError, Stopped) as error:
        if error.result is None:
            raise
        return error.result, str(error), isinstance(error, Stopped)


def finite(value: Any) -> Any:
    """`value` with None in place of NaN and infinity, which JSON does not know."""
    if isinstance(value, dict):
        return {key: finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _scalars(facts: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Every single value among `facts` that there is, as text with its dotted key, numbers to six digits; of lists of tables
    their number, of special points what each is and where."""
    for key, value in _leaves(facts):
        if value is not None and key != "schema":
            yield key, f"{value:.6g}" if isinstance(value, float) else str(value)
    for key, rows in facts.items():
        if key == "special":
            yield key, "; ".join(f"{row['type']} at {row.get('value', row.get('log10_r')):.7g}" for row in rows) or "none"
        elif isinstance(rows, list) and rows and isinstance(rows[0], Mapping):
            yield key, str(len(rows))


def table_of(rows: Sequence[Mapping[str, Any]], dimension: str, scene: Scene) -> Dataset:
    """The rows of a summary on `scene` as variables over `dimension`: numbers and words by their dotted keys, NaN where there is
    none."""
    require("files", "a dataset")
    import xarray

    flat = [dict(_leaves(row)) for row in rows]
    names = dict.fromkeys(name for row in flat for name in row)
    columns = {name: _column([row.get(name) for row in flat]) for name in names}
    notes = {name: column_notes(name, scene, column.dtype == float) for name, column in columns.items()}
    found = xarray.Dataset({name.replace(".", "_"): (dimension, columns[name], notes[name]) for name in names})
    return found.set_coords("model") if "model" in found else found


def parameter_column(name: str) -> str:
    """The name of a parameter of a branch in datasets: slab_thickness for slab.thickness."""
    return name.replace(".", "_")


def along(data: Dataset, parameter: str) -> Dataset:
    """`data` of points of a branch with their values of the `parameter` as an index."""
    from validation.branches.along import AlongBranch

    name = parameter_column(parameter)
    return data.set_coords(name).set_xindex(name, AlongBranch)


def _column(values: Sequence[Any]) -> "np.ndarray[Any, Any]":
    words = any(isinstance(value, str) for value in values)
    empty = "" if words else math.nan
    return np.array([empty if value is None else value for value in values], dtype=object if words else float)


def _leaves(facts: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, Any]]:
    """Every single value among `facts` with its dotted key."""
    for key, value in facts.items():
        if isinstance(value, Mapping):
            yield from _leaves(value, f"{above}{key}.")
        elif not isinstance(value, list):
            yield f"{above}{key}", value
