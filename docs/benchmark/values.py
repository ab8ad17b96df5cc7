"""Computes benchmark.csv anew: each value by slipwave and by second_program.py.    python docs/benchmark/values.py

Newton's method of the second program begins at orbits of the first, which decide what it finds, not where that lies.
"""

import csv
import math
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import second_program as other

import slipwave as sw

FILE = Path(__file__).with_name("benchmark.csv")
KINDS = {"LP": ("fold", 5), "NS": ("torus", 4), "PD": ("doubling", 2)}
"""Kind of a special point -> its name here, and how many of them there are. With the onset they are twelve."""

STARTS = {
    "smooth": ({}, {"nudge": 0.5}, (6.0, 8.0, 12.0, 20.0, 40.0, 100.0, 400.0)),
    "jump": ({"start": {"kind": "jump", "size": 0.05}}, {"jump": 0.05}, (20.0, 100.0, 400.0)),
    "irregular": ({"log10_r": -2.3}, {"nudge": 0.5}, (20.0, 100.0, 400.0)),
}
"""Name of a start -> changes of the paper's scene, what the second program calls it, and the times at which psi is given."""

FIGURES = ("stress_drop", "v_max", "v_min")
_FACTOR, _ROUNDING = 3.0, 1e-12
"""A bar is this factor times the difference of the two programs, but at least this share of the value."""
_MESH, _FINE = other.Mesh(6, 14), other.Mesh(8, 16)
"""Meshes of the second program, for orbits and for starts."""


class Value(NamedTuple):
    """One value of the benchmark, in which two programs agree to +- `bar`."""

    id: str
    value: float
    bar: float
    unit: str
    quantity: str
    computed_by: str


def psi_of(start: str) -> Iterator[tuple[str, float]]:
    """(name, psi) after a start."""
    changes, _, times = STARTS[start]
    for time in times:
        yield f"{start}.psi.{time:g}", sw.run("paper", model="delay", tol=1e-12, until=time, **changes).final.psi


def psi_of_second(start: str) -> Iterator[tuple[str, float]]:
    """The same by the second program."""
    changes, settings, times = STARTS[start]
    found = other.psi_at(_FINE, 10.0 ** changes.get("log10_r", -2.68), list(times), **settings)
    yield from ((f"{start}.psi.{time:g}", psi) for time, psi in zip(times, found, strict=True))


def special_points() -> dict[str, Any]:
    """The twelve points of the branch, by name."""
    branch = sw.branch("paper", model="delay", over=("log10_r", -2.72, -2.3), tol=1e-9, longest_period=87.95)
    found = {"onset": next(point for point in branch.special if point.type == "HB")}
    for kind, (name, count) in KINDS.items():
        points = [point for point in branch.special if point.type == kind]
        found |= {f"{name}.{k}": point for k, point in enumerate(points[:count], 1)}
    return found


def by_slipwave(orbit: Any, points: dict[str, Any]) -> Iterator[tuple[str, float]]:
    """All values by slipwave's delay system: orbit, special points of the branch, psi."""
    yield from _of_orbit(orbit.period, {name: getattr(orbit, name) for name in FIGURES}, orbit.multipliers)
    for name, point in points.items():
        yield from ((f"{name}.log10_r", point.log10_r), (f"{name}.period", point.period))
    for start in STARTS:
        yield from psi_of(start)


def by_second(orbit: Any, points: dict[str, Any]) -> Iterator[tuple[str, float]]:
    """The same by the second program."""
    found = other.closed(_MESH, 10.0**-2.68, orbit.period, as_start(orbit))
    yield from _of_orbit(found.period, other.figures(_MESH, found), found.multipliers)
    yield from zip(("onset.log10_r", "onset.period"), other.onset(), strict=True)
    for name, point in list(points.items())[1:]:
        place = other.special(_MESH, name.partition(".")[0], 10.0**point.log10_r, point.period, as_start(sw.orbit(point)))
        yield from zip((f"{name}.log10_r", f"{name}.period"), place, strict=True)
    for start in STARTS:
        yield from psi_of_second(start)


def _of_orbit(period: float, figures: dict[str, float], multipliers: Iterable[complex]) -> Iterator[tuple[str, float]]:
    yield "orbit.period", float(period)
    yield from ((f"orbit.{name}", float(figures[name])) for name in FIGURES)
    away = [one for one in multipliers if abs(one - 1.0) > 1e-3 and one.imag > -1e-12]
    for k, one in enumerate(away[:2], 1):
        yield from ((f"multiplier.{k}.real", float(one.real)), (f"multiplier.{k}.imag", float(one.imag)))


def as_start(orbit: Any) -> other.State:
    """An orbit of slipwave as start of the second program, where psi falls through PASSED: g of the transit before, and psi."""
    data = orbit.dataset
    time, v, psi, mu = (data[name].values for name in ("time", *(f"interface_{n}" for n in ("slip_rate", "psi", "stress"))))
    k = int(np.flatnonzero((psi[:-1] > other.PASSED) & (psi[1:] <= other.PASSED))[0])
    at = time[k] + (psi[k] - other.PASSED) / (psi[k] - psi[k + 1]) * (time[k + 1] - time[k])
    times = at - 1.0 + (np.arange(_MESH.panels)[:, None] + _MESH.points) / _MESH.panels
    v, mu = (np.interp(times, time, values, period=orbit.period) for values in (v, mu))
    return other.State(0.5 * ((other.STEADY_MU - mu) / other.EPSILON + 0.5 * (v - other.V)), other.PASSED)


_UNITS = {"period": "h/c", "log10_r": "1", "v_max": "V*", "v_min": "V*", "stress_drop": "sigma"}
_WORDS = {
    "orbit": "periodic orbit at log10 r = -2.68",
    "multiplier": "Floquet multiplier of that orbit",
    "onset": "Hopf point of steady sliding",
    "fold": "fold of the branch of orbits",
    "torus": "torus (Neimark-Sacker) point of the branch of orbits",
    "doubling": "period doubling of the branch of orbits",
    "smooth": "psi after the smooth start at log10 r = -2.68",
    "jump": "psi after the jump at log10 r = -2.68",
    "irregular": "psi after the smooth start at log10 r = -2.3",
}
_PROGRAMS = "slipwave's delay system (Radau steps); second_program.py (Chebyshev panels, numpy alone)"
_ONSET = "slipwave's root search on the characteristic equation; the closed forms (20) and (39)"


def rows_of(one: dict[str, float], other: dict[str, float]) -> list[Value]:
    """Both programs' values as rows: their mean, rounded to two digits of the bar. Raises KeyError where one lacks a value."""
    rows = []
    for name, first in one.items():
        group, _, what = name.partition(".")
        value = 0.5 * (first + other[name])
        bar = float(f"{max(_FACTOR * abs(first - other[name]), _ROUNDING * abs(value)):.1e}")
        shown = round(value, 1 - math.floor(math.log10(bar)))
        unit = _UNITS.get(what.split(".")[-1], "1")
        rows.append(Value(name, shown, bar, unit, f"{_WORDS[group]}: {what}", _ONSET if group == "onset" else _PROGRAMS))
    return rows


if __name__ == "__main__":
    found = sw.orbit("paper", model="delay", tol=1e-11), special_points()
    rows = rows_of(dict(by_slipwave(*found)), dict(by_second(*found)))
    with FILE.open("w", encoding="utf-8", newline="") as stream:
        csv.writer(stream, lineterminator="\n").writerows([Value._fields, *rows])
    for row in rows:
        print(f"{row.id:22} {row.value!r:>22} +- {row.bar:.1e}")
