"""A run as a record in the format that `read_series` reads: CSV with units in the heading."""

import csv
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

import numpy as np

from slipwave.files import whole_or_absent
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from validation.data.quantities import MEASURED, unit_sizes

MOST_LINES = 100_000
"""Lines of a record, 15 MB, unless samples are chosen."""


def _as_record(parts: Iterable[Mapping[str, Array]], scene: Scene) -> Iterator[dict[str, Array]]:
    """The interface's history in its own units (`slipwave.observe.history.named_columns`, a part at a time) as columns of
    MEASURED, in SI if the scene is. Load-point displacement and slip are counted from the first sample on; slip is the load
    point's displacement minus the elastic one, from y' = stiffness (V - v)."""
    sizes, begin = unit_sizes(scene), None
    for part in parts:
        load = scene.transit * scene.drive.travel(part["time"])
        slip = load - scene.transit * part["elastic_stress"] / scene.stiffness
        if begin is None:
            begin = load[0], slip[0]
        columns = {"time": part["time"], "load_point_displacement": load - begin[0], "slip": slip - begin[1]}
        columns |= {"slip_rate": part["slip_rate"], "shear_stress": part["stress"], "friction": part["stress"]}
        columns |= {"state": np.exp(part["psi"])}
        yield {name: values * sizes[MEASURED[name].own] for name, values in columns.items()}


def write_series(path: Path, parts: Iterable[Mapping[str, Array]], scene: Scene, every: int = 1) -> None:
    """Write one in `every` samples of the interface's history to `path`, which is whole or absent, with 17 digits. Raises
    SceneError if it cannot be written."""
    seen = 0
    with whole_or_absent(path) as temporary, open(temporary, "w", newline="", encoding="utf-8") as stream:
        table = csv.writer(stream)
        for number, columns in enumerate(_as_record(parts, scene)):
            if number == 0:
                units = {name: MEASURED[name].own if scene.units is None else MEASURED[name].unit for name in columns}
                table.writerow(f"{name} [{unit}]" if unit else name for name, unit in units.items())
            kept = [values[-seen % every :: every].tolist() for values in columns.values()]
            table.writerows([f"{value:.17g}" for value in row] for row in zip(*kept, strict=True))
            seen += columns["time"].size
