"""The values of the frozen benchmark, each computed by two programs, and their file.

`python -m validation.frozen.values` computes them again (one to two minutes) and writes both copies of the file.
"""

import csv
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import slipwave
from reduced.orbit.closing import Closed
from reduced.orbit.figures import figures_of
from reduced.orbit.multipliers import floquet
from slipwave.errors import SceneError
from slipwave.files import whole_or_absent
from slipwave.observe.history import values_at
from slipwave.observe.pieces import lagrange_basis
from slipwave.packages import run_file
from slipwave.solve import follow
from slipwave.sources import ROOT
from validation.compute.build import build
from validation.study.memo import own_orbit
from validation.study.over_r import branch_of, scene_at

FILE = Path(__file__).with_name("benchmark.csv")
PAGE, SECOND = ROOT / "docs" / "benchmark" / "benchmark.csv", ROOT / "docs" / "benchmark" / "second_program.py"
_KINDS = (("fold", "LP", 5), ("torus", "NS", 4), ("doubling", "PD", 2))
POINTS = {f"{name}.{k + 1}": (kind, k) for name, kind, count in _KINDS for k in range(count)}
"""Name of a special point -> its kind, and its number among these along the branch. With the onset they are twelve."""

STARTS: dict[str, tuple[tuple[str, ...], tuple[float, ...]]] = {
    "smooth": ((), (6.0, 8.0, 12.0, 20.0, 40.0, 100.0, 400.0)),
    "jump": (("start.kind=jump", "start.size=0.05"), (20.0, 100.0, 400.0)),
    "irregular": (("slab.log10_r=-2.3",), (20.0, 100.0, 400.0)),
}
"""Name of a start -> changes of the paper's scene, and the times (transits) at which psi is given."""

_LONGEST, _TOLERANCE, _TIGHT = 87.95, 1e-9, 1e-12
_FACTOR, _ROUNDING = 3.0, 1e-12
"""A bar is this factor times the difference of the two programs, but at least this share of the value."""
_MESHES = ((6, 14), (8, 16))  # panels in a transit and degree of the second program: for orbits, for starts
_COLUMNS = ("id", "value", "bar", "unit", "quantity", "computed_by")


class FrozenValue(NamedTuple):
    """One value of the benchmark, certified to +- `bar`."""

    id: str
    value: float
    bar: float
    unit: str
    quantity: str
    computed_by: str

    @property
    def digits(self) -> int:
        """Number of significant digits certified by the bar."""
        return max(0, math.floor(-math.log10(self.bar / abs(self.value))))


def frozen() -> dict[str, FrozenValue]:
    """The values of the file, by name."""
    with FILE.open(encoding="utf-8", newline="") as stream:
        _, *rows = csv.reader(stream)
    return {name: FrozenValue(name, float(value), float(bar), *words) for name, value, bar, *words in rows}


def second_program() -> Any:
    """The program of docs/benchmark, which shares no code with this one. Raises SceneError outside a checkout."""
    if not SECOND.is_file():
        raise SceneError(f"{SECOND}: not there; the benchmark is computed again in a checkout only")
    return run_file(SECOND, "second_program", "the second program")


def psi_of(start: str) -> Iterator[tuple[str, float]]:
    """(name, psi) of our delay system after a start."""
    changes, times = STARTS[start]
    solver = build("delay", slipwave.read("paper", changes), tolerance=_TIGHT)
    for time in times:
        yield f"{start}.psi.{time:g}", follow(solver, time).psi


def psi_of_second(start: str) -> Iterator[tuple[str, float]]:
    """The same by the second program."""
    other, (_, times) = second_program(), STARTS[start]
    settings = {"jump": {"jump": 0.05}}.get(start, {"nudge": 0.5})
    r = 10.0 ** (-2.3 if start == "irregular" else -2.68)
    found = other.psi_at(other.Mesh(*_MESHES[1]), r, list(times), **settings)
    yield from ((f"{start}.psi.{time:g}", psi) for time, psi in zip(times, found, strict=True))


def _of_orbit(period: float, figures: dict[str, float], multipliers: Any) -> Iterator[tuple[str, float]]:
    yield "orbit.period", float(period)
    yield from ((f"orbit.{name}", float(figures[name])) for name in ("stress_drop", "v_max", "v_min"))
    away = [one for one in multipliers if abs(one - 1.0) > 1e-3 and one.imag > -1e-12]
    for k, one in enumerate(away[:2], 1):
        yield from ((f"multiplier.{k}.real", float(one.real)), (f"multiplier.{k}.imag", float(one.imag)))


def ours() -> Iterator[tuple[str, float]]:
    """All values by slipwave's delay system: orbit, special points of the branch, psi."""
    closed = own_orbit("delay", scene_at(-2.68), 1e-11).closed
    yield from _of_orbit(closed.cycle.period, figures_of(closed), floquet(closed.monodromy)[0])
    branch = branch_of("delay", -2.3, _LONGEST, _TOLERANCE)
    yield from (("onset.log10_r", branch.onset.parameter), ("onset.period", branch.onset.period))
    for name, (kind, k) in POINTS.items():
        point = branch.of_kind(kind)[k].point
        yield from ((f"{name}.log10_r", point.parameter), (f"{name}.period", point.closed.cycle.period))
    for start in STARTS:
        yield from psi_of(start)


def seconds() -> Iterator[tuple[str, float]]:
    """The same by the second program. Newton's method starts from our orbits, which select the orbit but not its values."""
    other = second_program()
    mesh = other.Mesh(*_MESHES[0])
    near = own_orbit("delay", scene_at(-2.68), 1e-11).closed
    orbit = other.closed(mesh, 10.0**-2.68, near.cycle.period, _as_start(other, mesh, near))
    yield from _of_orbit(orbit.period, other.figures(mesh, orbit), orbit.multipliers)
    yield from zip(("onset.log10_r", "onset.period"), other.onset(), strict=True)
    branch = branch_of("delay", -2.3, _LONGEST, _TOLERANCE)
    for name, (kind, k) in POINTS.items():
        point = branch.of_kind(kind)[k].point
        near, start = point.closed, _as_start(other, mesh, point.closed)
        found = other.special(mesh, name.partition(".")[0], 10.0**point.parameter, near.cycle.period, start)
        yield from zip((f"{name}.log10_r", f"{name}.period"), found, strict=True)
    for start_name in STARTS:
        yield from psi_of_second(start_name)


def _as_start(other: Any, mesh: Any, closed: Closed) -> Any:
    """One of our orbits as start of the second program, where psi falls through its initial value: g of the transit before, and
    psi."""
    cycle, basis = closed.cycle, lagrange_basis(closed.flow.nodes)
    law, scene = closed.flow.scene.law, closed.flow.scene
    fine = np.linspace(0.0, cycle.period, 20001)[1:]
    psi = values_at(cycle.pieces, basis, fine)[1]
    k = int(np.flatnonzero((psi[:-1] > other.PASSED) & (psi[1:] <= other.PASSED))[0])
    at = fine[k] + (psi[k] - other.PASSED) / (psi[k] - psi[k + 1]) * (fine[k + 1] - fine[k])
    times = at - 1.0 + (np.arange(mesh.panels)[:, None] + mesh.points).ravel() / mesh.panels
    z, _, mu, _ = values_at(cycle.pieces, basis, np.mod(times, cycle.period))
    steady = law.a_star + (law.a - law.b) * math.log(scene.velocity)
    g = 0.5 * ((steady - mu) / scene.upper.epsilon + 0.5 * (np.exp(z) - scene.velocity))
    return other.State(g.reshape(mesh.panels, -1), other.PASSED)


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


def rows_of(one: dict[str, float], other: dict[str, float]) -> list[FrozenValue]:
    """Both programs' values as rows: their mean, rounded to two digits of the bar. Raises KeyError where one lacks a value."""
    rows = []
    for name, first in one.items():
        group, _, what = name.partition(".")
        value = 0.5 * (first + other[name])
        bar = float(f"{max(_FACTOR * abs(first - other[name]), _ROUNDING * abs(value)):.1e}")
        shown = round(value, 1 - math.floor(math.log10(bar)))
        unit = _UNITS.get(what.split(".")[-1], "1")
        rows.append(FrozenValue(name, shown, bar, unit, f"{_WORDS[group]}: {what}", _ONSET if group == "onset" else _PROGRAMS))
    return rows


def write(path: Path, rows: list[FrozenValue]) -> None:
    """Write the file. Raises SceneError if it cannot be written."""
    with whole_or_absent(path) as temporary, Path(temporary).open("w", encoding="utf-8", newline="") as stream:
        table = csv.writer(stream, lineterminator="\n")
        table.writerows([_COLUMNS, *rows])


def main() -> None:
    """Compute all values again and write both copies."""
    rows = rows_of(dict(ours()), dict(seconds()))
    for path in (FILE, PAGE):
        write(path, rows)
    for row in rows:
        print(f"{row.id:22} {row.value!r:>22} +- {row.bar:.1e}")


if __name__ == "__main__":
    main()
