"""The slip events of a run as a table of comma-separated values, in SI where the scene has units."""

import csv
from pathlib import Path

from slipwave.files import whole_or_absent
from slipwave.observe import Events
from slipwave.scene import Scene

_STRESSES = ("stress_drop", "elastic_stress_drop")
_TIMES = ("time", "period")


def write_events(path: Path, events: Events, scene: Scene) -> None:
    """Write one line for each complete cycle, with 17 digits, to `path`, which is whole or absent; the heading names the units.

    In SI: s, Pa and m/s; otherwise transits, units of the normal stress and V*.
    """
    units = scene.units
    names, columns = [], []
    for name, values in zip(events._fields, events, strict=True):
        if name in _TIMES:
            size, unit = (scene.transit * units.time, "s") if units else (1.0, "transits")
        elif name in _STRESSES:
            size, unit = (units.normal_stress, "Pa") if units else (1.0, "normal stress")
        else:
            size, unit = (units.reference_velocity, "m/s") if units else (1.0, "V*")
        names.append(f"{name} [{unit}]")
        columns.append((values * size).tolist())
    with whole_or_absent(path) as temporary, open(temporary, "w", newline="", encoding="utf-8") as stream:
        table = csv.writer(stream)
        table.writerow(names)
        table.writerows([f"{value:.17g}" for value in row] for row in zip(*columns, strict=True))
