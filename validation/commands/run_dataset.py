"""A run as an `xarray.Dataset` and as a netCDF file: cycles if events were watched, the stages of a protocol, the interface's
history if it was kept, its provenance, and the fields of a full-wave run's last transits as the group "fields".
"""

import csv
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from slipwave.errors import SceneError
from slipwave.files import TIME, whole_or_absent
from slipwave.observe import Events
from slipwave.observe.protocol import StageFigures
from slipwave.scene import Scene
from validation.data.datasets import Dataset, new_dataset
from validation.data.variables import (
    EVENTS,
    INTERFACE,
    MARGINS,
    STAGE_QUANTITIES,
    attributes,
    shown_in,
    stored_name,
    twins_in_si,
    variables,
)
from validation.models.history_file import HistoryFile
from validation.models.run import Run

if TYPE_CHECKING:
    import netCDF4

    from fullwave.fields.record import Field


def run_dataset(
    done: Run, facts: Mapping[str, Any], stages: Sequence[StageFigures] = (), history: HistoryFile | None = None
) -> Dataset:
    """The run with the attributes `facts`: cycles by `event`, stages by `stage`, the history by `time`; all in memory."""
    data = _figures(done, facts, stages)
    if history is None:
        return data
    scene, parts = done.solver.scene, [_renamed(part) for part in history.parts()]
    columns = {name: np.concatenate([np.empty(0), *(part[name] for part in parts)]) for name in INTERFACE}
    time, values = {TIME: columns.pop(TIME)}, variables(TIME, columns, INTERFACE, scene, twins=False)
    return data.merge(new_dataset(values, variables(TIME, time, INTERFACE, scene)))


def write_run(
    path: Path,
    done: Run,
    facts: Mapping[str, Any],
    stages: Sequence[StageFigures],
    history: HistoryFile | None,
    field: "Field | None" = None,
) -> None:
    """Write the run to `path`, which is whole or absent; the history is copied in blocks. Raises SceneError if the file, or the
    history during the run, could not be written.
    """
    if history is not None and history.problem:
        raise SceneError(history.problem)
    with whole_or_absent(path) as temporary:
        _figures(done, facts, stages).to_netcdf(temporary, engine="netcdf4")
        if history is not None:
            _append_history(temporary, history, done.solver.scene)
        if field is not None:
            field.dataset().to_netcdf(temporary, mode="a", group="fields", engine="netcdf4")


def _figures(done: Run, facts: Mapping[str, Any], stages: Sequence[StageFigures]) -> Dataset:
    """Cycles, margins of their means and stages, as far as there are any."""
    scene, data = done.solver.scene, _cycles(done, facts)
    if done.verdict and done.verdict.wanders:
        margins = {f"{name}_margin": value for name, value in done.statistics.margins.items()}
        data = data.assign(variables((), margins, MARGINS, scene))
    if stages:
        rows = [asdict(stage) for stage in stages]
        columns = {name: np.array([row[name] for row in rows], dtype=float) for name in STAGE_QUANTITIES}  # None becomes NaN
        named = variables("stage", columns, STAGE_QUANTITIES, scene)
        data = data.assign({f"stage_{name}": variable for name, variable in named.items()})
        kinds = np.array([row["kind"] for row in rows], dtype=object)
        data["stage_kind"] = ("stage", kinds, {"long_name": "kind of the stage"})
        stick_slips = [int(row["stick_slips"]) for row in rows]
        data["stage_stick_slips"] = ("stage", stick_slips, {"long_name": "1 if the stage stick-slips", "units": "1"})
    return data


def _cycles(done: Run, facts: Mapping[str, Any]) -> Dataset:
    """The cycles of a run, if events were recorded, with figures of its events as attributes. `multiplicity` exists only if the
    run is periodic, `rotation_number` only on a torus: a netCDF attribute cannot be empty.
    """
    ended: dict[str, Any] = {"until_transits": done.until, "failures": done.solver.failures}
    ended |= {"complete": 0 if done.failed else 1, "failed": done.failed}
    if done.verdict is None:
        return new_dataset(attrs={**facts, **ended, "events": "not watched", "verdict": "not watched"})
    columns = {_of_events(name): values for name, values in done.events._asdict().items()}
    data = new_dataset(variables("event", columns, EVENTS, done.solver.scene))
    judged = {"multiplicity": done.verdict.multiplicity, "rotation_number": done.verdict.rotation}
    known = {name: value for name, value in judged.items() if value is not None}
    data = data.assign_attrs({**facts, **ended, "events": done.event_count, "verdict": done.verdict.kind, **known})
    return data.set_coords([name for name in data if str(name).startswith("event_time")])


def _append_history(path: Path, history: HistoryFile, scene: Scene) -> None:
    import netCDF4

    with netCDF4.Dataset(path, "a") as file:
        file.createDimension(TIME, len(history))
        for name, quantity in INTERFACE.items():
            _column(file, name, attributes(quantity, scene))
        twin = {name: notes for name, (_, notes) in twins_in_si(TIME, 0.0, INTERFACE[TIME], scene).items()}
        for name, notes in twin.items():
            _column(file, name, notes)
        for name in INTERFACE.keys() - {TIME} if twin else ():
            file[name].setncattr("coordinates", " ".join(twin))
        first = 0
        for part in history.parts():
            columns = _renamed(part)
            columns |= {name: values for name, (values, _) in twins_in_si(TIME, part["time"], INTERFACE[TIME], scene).items()}
            for name, values in columns.items():
                file[name][first : first + values.size] = values
            first += part["time"].size


def _column(file: "netCDF4.Dataset", name: str, notes: Mapping[str, Any]) -> None:
    """A variable over time; no value of a coordinate may be missing."""
    missing = None if name.startswith(TIME) else math.nan
    file.createVariable(name, "f8", (TIME,), fill_value=missing).setncatts(notes)


def write_events(path: Path, events: Events, scene: Scene) -> None:
    """Write one line for each complete cycle, with 17 digits, to `path`, which is whole or absent; the heading names the units.

    In SI: s, Pa and m/s; otherwise transits, units of the normal stress and V*.
    """
    named = {name: _of_events(name) for name in events._fields}
    shown = {name: shown_in(EVENTS[stored].unit, scene) for name, stored in named.items()}
    columns = [(values * shown[name][0]).tolist() for name, values in zip(events._fields, events, strict=True)]
    with whole_or_absent(path) as temporary, open(temporary, "w", newline="", encoding="utf-8") as stream:
        table = csv.writer(stream)
        table.writerow([f"{name} [{unit}]" for name, (_, unit) in shown.items()])
        table.writerows([f"{value:.17g}" for value in row] for row in zip(*columns, strict=True))


def _of_events(name: str) -> str:
    """The name of a column of events in files."""
    return "event_time" if name == "time" else name


def _renamed(part: Mapping[str, Any]) -> dict[str, Any]:
    return {stored_name(name): values for name, values in part.items()}
