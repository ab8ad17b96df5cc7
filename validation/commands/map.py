"""`slipwave map`: Draw a sweep: regimes with the boundaries that theory gives, figures, differences between two models."""

import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from slipwave.errors import SceneError
from slipwave.extras import require
from slipwave.files import FIGURES
from slipwave.input.assemble import SceneSource
from validation.chart import Chart
from validation.commands.options import SceneOptions, command, option
from validation.commands.result import Output, Result, aligned, rounded
from validation.data.datasets import Dataset, flag_numbers, load_dataset, words_of_flags
from validation.models.own import require_files
from validation.sweep.gather import dataset_of, filled_arrays
from validation.sweep.map_figures import SIZES, Line, chart_of_sweep, in_print, lines_of_curve, onset_lines
from validation.sweep.measures import REGIME_OF, decided_regimes
from validation.sweep.store import Store
from validation.sweep.sweep import stored_plan

_COMPARED = ("period", "stress_drop")


class _MapOptions(SceneOptions):
    """Options of `slipwave.map`."""

    EXAMPLES: ClassVar = (
        "slipwave map map --plot map.png",
        "slipwave map map/sweep.nc --show period --plot period.svg",
        "slipwave map map --size single --title 'Regimes of a block of granite' --plot figure-1.pdf",
        "slipwave map both --against kelvin-voigt --plot difference.png",
    )
    SOURCE: ClassVar = "the folder of a sweep, or the netCDF file gathered from it"

    show: str | None = option("the column to be drawn (default: regime, period and stress drop)", metavar="COLUMN")
    model: str | None = option("one of the models (default: all)", positional=True)
    against: str | None = option("draw where this model has another regime, and by how much its period and stress drop differ")
    curve: Iterable[str | Path] = option("netCDF files of `slipwave curve` to be drawn over the map", (), metavar="FILE.nc ...")
    title: str = option("a title above the figure", "")
    size: str | None = option("size for print: single (8.5 cm wide) or double (17 cm) column", metavar="single|double")
    plain: bool = option("without the boundary on which steady sliding loses its stability", False)


class MapResult(Result):
    """A gathered sweep `data`, `differences` of its models from one of them, and the `boundaries` over it; `notes` on what is not
    drawn; `title` and `size` of the figure."""

    OUTPUTS: ClassVar = (Output("--plot", FIGURES, "save_plot", "draw it: .png, .pdf or .svg", default="map.png", key="figure"),)

    data: Dataset
    differences: Dataset | None
    boundaries: tuple[Line, ...]
    shown: str | None
    notes: list[str]
    title: str
    size: str | None

    @property
    def dataset(self) -> Dataset:
        """The drawn data: the sweep, or the differences."""
        return self.data if self.differences is None else self.differences

    def regimes(self, model: str) -> Any:
        """The regimes of one `model` of a sweep of verdicts at its points: 0 for steady sliding and the return to it,
        another number for each other regime, -1 where there is no verdict that lasts. Raises SceneError without verdicts of this
        model."""
        models = self.data["model"].values.ravel().tolist() if "verdict" in self.data else []
        if model not in models:
            raise SceneError(f"model = {model}: the sweep has verdicts of {', '.join(models) or 'no model'}")
        verdicts = self.data["verdict"]
        return decided_regimes(flag_numbers(verdicts.sel(model=model) if "model" in verdicts.dims else verdicts))

    @property
    def facts(self) -> dict[str, Any]:
        """The axes; of a difference the share of the area with another regime, in per cent, and the
        largest relative differences where both motions are periodic."""
        data = self.dataset
        facts: dict[str, Any] = {"scene": data.attrs["scene"], "axes": [str(name) for name in data.dims]}
        if self.differences is not None:
            facts["differences"] = _difference_rows(self.differences)
        return facts | {"boundaries": [line.name for line in self.boundaries], "notes": self.notes}

    def lines(self, summary: Mapping[str, Any]) -> Iterator[str]:
        """A line on the figure, and the differences as a table."""
        yield f"scene {summary['scene']} over {', '.join(summary['axes'])}"
        yield from (f"boundary: {line.name}" for line in self.boundaries)
        yield from (f"note: {note}" for note in self.notes)
        rows = [
            [row["model"], *(rounded(row[name], 4) for name in ("other_regime_percent", "period", "stress_drop"))]
            for row in summary.get("differences", [])
        ]
        if rows:
            yield ""
            yield from aligned(["model", "other regime [%]", "largest error of T", "of the stress drop"], rows)

    def chart(self) -> Chart:
        """The map, in its size for print if one is given."""
        chart = replace(chart_of_sweep(self.dataset, self.shown, self.boundaries), title=self.title)
        return chart if self.size is None else in_print(chart, self.size)


@command
def map(source: "SceneSource | Result", options: _MapOptions) -> MapResult:
    """Figures of a sweep over one or two axes: of a folder, a file, or a result of `slipwave.sweep`.

    Raises SceneError for a file or folder without a sweep."""
    options.require_unset((), "a map draws a sweep as it was computed")
    data = _gathered(source)
    if options.size is not None and options.size not in SIZES:
        raise SceneError(f"--size = {options.size!r}: must be {' or '.join(SIZES)}")
    differences = None if options.against is None else _difference(data, options.against)
    shown = data if differences is None else differences
    if options.model is not None and "model" in shown.dims:
        names = [str(name) for name in shown["model"].values]
        if options.model not in names:
            which = "one of the sweep's" if differences is None else f"a model to compare with {options.against}"
            raise SceneError(f"model = {options.model!r}: must be {which}, {', '.join(names)}")
        shown = shown.sel(model=[options.model] if differences is not None else options.model)
    boundaries, notes = ((), []) if options.plain or differences is not None else onset_lines(shown)
    lines = (*boundaries, *lines_of_curve(options.curve, shown))
    data, differences = (shown, None) if differences is None else (data, shown)
    return MapResult(data, differences, lines, options.show, notes, options.title, options.size)


def _gathered(source: "SceneSource | Result") -> Dataset:
    """The dataset of a sweep's folder or file, or of its result. Raises SceneError if there is none."""
    if isinstance(source, Result):
        if "manifest" not in source.dataset.attrs:
            raise SceneError(f"SCENE = {type(source).__name__}: must be the result of slipwave.sweep")
        return source.dataset
    path = Path(source) if isinstance(source, str | Path) else Path()
    if path.is_dir():
        plan = stored_plan(path)
        return dataset_of(plan, filled_arrays(plan, Store(path)))
    require("files", "a map")
    data = load_dataset(path, f"SCENE = {str(source)!r}: neither a folder nor a netCDF file")
    if "manifest" not in data.attrs:
        raise SceneError(f"SCENE = {str(source)!r}: holds no sweep; slipwave sweep DIR --gather writes one")
    require_files(f"SCENE = {str(source)!r}", json.loads(data.attrs["manifest"]).get("files", {}))
    return words_of_flags(data, ("verdict", "stable"))


def _difference(data: Dataset, reference: str) -> Dataset:
    """`other_regime` (1 where it differs from the `reference`, 0 where not, NaN where one of both is not decided), and relative
    differences of period and stress drop where both are periodic, for every other model of a sweep of verdicts.

    Raises SceneError for a sweep of one model, without that model, or of another measure."""
    names = [str(name) for name in np.atleast_1d(data["model"].values)]
    if reference not in names or len(names) < 2:
        raise SceneError(f"--against = {reference!r}: must be one of at least two models of the sweep, {', '.join(names)}")
    if "verdict" not in data:
        raise SceneError("--against: needs a sweep with verdicts (--measure verdict, run or lyapunov)")
    ours, others = data.sel(model=reference), data.sel(model=[name for name in names if name != reference])
    here, there = (decided_regimes(flag_numbers(dataset["verdict"])) for dataset in (ours, others))
    decided = (here >= 0) & (there >= 0)
    differences = others[["verdict", "status"]].rename(verdict="other_regime")
    status, own = (
        data["status"].where(flag_numbers(data["verdict"]) < 0, 0) for data in (others, ours)
    )  # of a cell: its verdict's
    differences["status"] = status.where(own == 0, own)
    differences["other_regime"] = others["verdict"].copy(data=np.where(decided, here != there, np.nan))
    differences["other_regime"].attrs = {"long_name": f"regime differs from that of {reference}", "units": "1"}
    both = (here == REGIME_OF["periodic"]) & (there == REGIME_OF["periodic"])
    for name in _COMPARED:
        differences[name] = others[name] / ours[name] - 1.0
        differences[name].values[~both] = np.nan
        differences[name].attrs = {"long_name": f"{name.replace('_', ' ')} / that of {reference} − 1", "units": "1"}
    return differences


def _difference_rows(differences: Dataset) -> list[dict[str, Any]]:
    """The differences that were `differences`, for each model: per cent of the decided area with another regime, per cent that is
    decided, and the largest relative difference of each figure."""
    return [{"model": str(name), **_row_of(differences.sel(model=name))} for name in differences["model"].values]


def _row_of(row: Dataset) -> dict[str, float]:
    other, decided = row["other_regime"].values, np.isfinite(row["other_regime"].values)
    percent = {"other_regime_percent": other[decided].mean() if decided.any() else np.nan, "compared_percent": decided.mean()}
    largest = {name: _largest(row[name].values) for name in _COMPARED}
    return {name: 100.0 * float(share) for name, share in percent.items()} | largest


def _largest(values: Any) -> float:
    """The value of largest modulus, with its sign; NaN if there is none."""
    there = values[np.isfinite(values)]
    return float(there[np.argmax(np.abs(there))]) if there.size else np.nan
