"""Computes benchmark.csv, pairs.csv and mistakes.csv anew: each value by two programs.    python docs/benchmark/values.py

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

SCENES = {
    "unlike": ("unlike", {}),
    "unlike-irrational": ("unlike-irrational", {}),
    "layered": ("layered", {}),
    "reflection-0.5": ("reflection", {"slab.face.coefficient": 0.5}),
    "reflection-0.9": ("reflection", {"slab.face.coefficient": 0.9}),
    "slip": ("slip-law", {}),
    "cutoff": ("paper", {"interface.law": "ageing-cutoff", "interface.cutoff_velocity": 2000.0}),
}
"""Name of a scene here -> scene of the gallery and changes; psi is given after the smooth start."""
SCENES_AT = (8.0, 20.0, 40.0, 100.0)

MISTAKES = {
    "the load were halved": {"drive.velocity": [[0.0, 100.0], [0.0, 50.0]]},
    "the load were doubled": {"drive.velocity": [[0.0, 100.0], [0.0, 200.0]]},
    "the slabs had half of their impedance (radiation damping)": {"slab.epsilon": 1.4e-5},
    "the slabs had twice their impedance (radiation damping)": {"slab.epsilon": 5.6e-5},
    "friction were the asinh form with a_* = 0.369, not 0.769": {
        "interface.law": "ageing-regularised",
        "interface.a_star": 0.369,
    },
}
"""A mistake in words -> changes of the paper's scene that make it; psi is given after the smooth start."""
MISTAKES_AT = (6.0, 8.0, 12.0, 20.0, 40.0)

PAIRS = {
    "one-pair": (10.0, 1.0, 1.0, 73.5),
    "pair-2": (3.0, 2.0, 1.0, 75.5),
    "pair-root2": (10.0, math.sqrt(2.0), 1.0, 74.3),
    **{f"leaking-{R:g}": (10.0, 2.0, R, 64.05) for R in (0.9995, 0.999, 0.9985, 0.998, 0.9975)},
}
"""Name of a pair -> ratios of impedances q and of round trips p, lower over upper slab; the share R that each outer face returns;
near which period (transits) its orbit is. Impedance and stiffness of the interface are those of the paper's slabs."""

FIGURES = ("stress_drop", "v_max", "v_min")
_FACTOR, _ROUNDING = 3.0, 1e-12
"""A bar is this factor times the difference of the two programs, but at least this share of the value."""
_SAMPLES, _SMALL = 2**14, 1e-8  # of an orbit of slipwave; what keeps modes finite that both slabs have alone
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


def psi_in(scene: str, second: bool) -> Iterator[tuple[str, float]]:
    """(name, psi) in one of SCENES by the delay system; by the `second` program behind faces that reflect, which it knows, and
    elsewhere by full waves (discontinuous Galerkin, explicit in time)."""
    name, changes = SCENES[scene]
    if second and name == "reflection":
        mesh = other.Mesh(8, 16, (other.Line(share=changes["slab.face.coefficient"]),))
        found = other.psi_at(mesh, 10.0**-2.68, list(SCENES_AT), nudge=0.5)
        yield from ((f"{scene}.psi.{time:g}", psi) for time, psi in zip(SCENES_AT, found, strict=True))
        return
    options: dict[str, Any] = {"model": "dg:8", "cells": 8, "time": "explicit"} if second else {"model": "delay", "tol": 1e-12}
    for time in SCENES_AT:
        yield f"{scene}.psi.{time:g}", sw.run(sw.read(name, changes), until=time, **options).final.psi


def mistaken() -> Iterator[tuple[str, float, str]]:
    """(name, psi, mistake) after the smooth start."""
    for words, changes in MISTAKES.items():
        for time in MISTAKES_AT:
            psi = sw.run(sw.read("paper", changes), model="delay", tol=1e-12, until=time).final.psi
            yield f"smooth.psi.{time:g}", round(float(psi), 12), words


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
    for scene in SCENES:
        yield from psi_in(scene, second=False)


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
    for scene in SCENES:
        yield from psi_in(scene, second=True)


def lines_of(pair: str) -> tuple[other.Line, other.Line]:
    """Upper and lower slab of one of PAIRS."""
    q, p, share, _ = PAIRS[pair]
    upper = 0.5 * other.EPSILON * (1.0 + q) / q
    return other.Line(upper, 1.0, share), other.Line(q * upper, p, share)


def upper_r(pair: str) -> float:
    """r of the upper slab where alike slabs of this stiffness would have log10 r = -2.68."""
    q, p, *_ = PAIRS[pair]
    return 10.0**-2.68 * (1.0 + q) / (q + p)


def as_scene(pair: str) -> sw.Scene:
    """One of PAIRS, with the smooth start."""
    keys: dict[str, Any] = {"start.size": 0.5}
    for slab, line in zip(("upper", "lower"), lines_of(pair), strict=True):
        keys |= {f"{slab}.epsilon": line.impedance, f"{slab}.r": upper_r(pair) * line.delay}
        keys |= {f"{slab}.face.kind": "reflection", f"{slab}.face.coefficient": line.share} if line.share < 1.0 else {}
    return sw.read("paper", keys)


def orbit_of(pair: str) -> Any:
    """The orbit on the pair's branch that is nearest to its period."""
    return sw.orbit(as_scene(pair), model="delay", tol=1e-11, near_period=PAIRS[pair][3])


def points_of(pair: str) -> dict[str, Any]:
    """Onset and first fold of the pair's branch, and its first torus point behind leaking faces, by name."""
    kind, near = "NS" if PAIRS[pair][2] < 1.0 else "LP", math.log10(upper_r(pair))
    branch = sw.branch(as_scene(pair), {"log10_r": (near - 0.03, near + 0.02)}, model="delay", stop_at=kind, tol=1e-9)
    names = {"HB": "onset", "LP": "fold", "NS": "torus"}
    return {names[kind]: next(one for one in branch.special if one.type == kind) for kind in dict.fromkeys(("HB", "LP", kind))}


def pair_by_slipwave(pair: str, orbit: Any, points: dict[str, Any]) -> Iterator[tuple[str, float]]:
    """Orbit and special points of one of PAIRS."""
    yield from _figures_of(pair, orbit.period, {name: getattr(orbit, name) for name in FIGURES})
    for name, point in points.items():
        yield from ((f"{pair}.{name}.log10_r", point.log10_r), (f"{pair}.{name}.period", point.period))


def pair_by_second(pair: str, orbit: Any, points: dict[str, Any]) -> Iterator[tuple[str, float]]:
    """The same by the second program."""
    mesh = other.Mesh(_MESH.panels, _MESH.degree, lines_of(pair))
    found = other.closed(mesh, upper_r(pair), orbit.period, as_start(orbit, mesh))
    yield from _figures_of(pair, found.period, other.figures(mesh, found))
    for name, point in points.items():
        if name == "onset":
            place = other.hopf(mesh.lines, point.log10_r, point.period)
        else:
            place = other.special(mesh, name, 10.0**point.log10_r, point.period, as_start(sw.orbit(point), mesh))
        yield from zip((f"{pair}.{name}.log10_r", f"{pair}.{name}.period"), place, strict=True)


def _figures_of(group: str, period: float, figures: dict[str, float]) -> Iterator[tuple[str, float]]:
    yield f"{group}.period", float(period)
    yield from ((f"{group}.{name}", float(figures[name])) for name in FIGURES)


def _of_orbit(period: float, figures: dict[str, float], multipliers: Iterable[complex]) -> Iterator[tuple[str, float]]:
    yield from _figures_of("orbit", period, figures)
    away = [one for one in multipliers if abs(one - 1.0) > 1e-3 and one.imag > -1e-12]
    for k, one in enumerate(away[:2], 1):
        yield from ((f"multiplier.{k}.real", float(one.real)), (f"multiplier.{k}.imag", float(one.imag)))


def as_start(orbit: Any, mesh: other.Mesh = _MESH) -> other.State:
    """An orbit of slipwave as start of the second program, where psi falls through PASSED: psi, and g of each line of the `mesh`
    from the stress, whose Fourier series is -z (1 + R e^(-i omega d)) times that of g."""
    data = orbit.dataset
    time, psi, mu = (data[name].values for name in ("time", "interface_psi", "interface_stress"))
    k = int(np.flatnonzero((psi[:-1] > other.PASSED) & (psi[1:] <= other.PASSED))[0])
    at = time[k] + (psi[k] - other.PASSED) / (psi[k] - psi[k + 1]) * (time[k + 1] - time[k])
    samples = at + orbit.period * np.arange(_SAMPLES) / _SAMPLES
    stress = np.fft.rfft(other.STEADY_MU - np.interp(samples, time, mu, period=orbit.period))
    times = at + (np.arange(-mesh.memory, 0)[:, None] + mesh.points) / mesh.panels
    lines = []
    for one in mesh.lines:
        back = 1.0 + one.share * np.exp(-2j * np.pi * np.arange(stress.size) * one.delay / orbit.period)
        g = np.fft.irfft(stress * back.conj() / (one.impedance * (np.abs(back) ** 2 + _SMALL)))
        lines.append(np.interp(times, samples, g, period=orbit.period))
    return other.State(np.stack(lines, axis=2), other.PASSED)


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
    "unlike": "unlike slabs, round trips 2 : 1: psi after the smooth start",
    "unlike-irrational": "unlike slabs, round trips sqrt(2) : 1: psi after the smooth start",
    "layered": "slabs of two layers: psi after the smooth start",
    "reflection-0.5": "faces that reflect 0.5: psi after the smooth start",
    "reflection-0.9": "faces that reflect 0.9: psi after the smooth start",
    "slip": "slip law: psi after the smooth start",
    "cutoff": "cut-off law: psi after the smooth start",
}
_WORDS |= {
    pair: f"slabs of impedances 1 : {q:g} and round trips 1 : {p:.5g}"
    + (f", faces that reflect {share:g}" if share < 1.0 else "")
    for pair, (q, p, share, _) in PAIRS.items()
}
_PROGRAMS = "slipwave's delay system (Radau steps); second_program.py (Chebyshev panels, numpy alone)"
_WAVES = "slipwave's delay system; slipwave's full waves (dg:8, explicit in time)"
_ONSET = "slipwave's root search on the characteristic equation; the closed forms (20) and (39)"
_HOPF = "slipwave's branch; second_program.py (Newton's method on the characteristic equation)"


_BY = {"onset": _ONSET} | {name: _WAVES for name, (scene, _) in SCENES.items() if scene != "reflection"}


def rows_of(one: dict[str, float], other: dict[str, float]) -> list[Value]:
    """Both programs' values as rows: their mean, rounded to two digits of the bar. Raises KeyError where one lacks a value."""
    rows = []
    for name, first in one.items():
        group = next(one for one in _WORDS if name.startswith(f"{one}."))
        what = name.removeprefix(f"{group}.")
        value = 0.5 * (first + other[name])
        bar = float(f"{max(_FACTOR * abs(first - other[name]), _ROUNDING * abs(value)):.1e}")
        shown = round(value, 1 - math.floor(math.log10(bar)))
        unit = _UNITS.get(what.split(".")[-1], "1")
        by = _HOPF if group in PAIRS and "onset" in what else _BY.get(group, _PROGRAMS)
        rows.append(Value(name, shown, bar, unit, f"{_WORDS[group]}: {what}", by))
    return rows


def pair_rows(pair: str) -> list[Value]:
    """Rows of one of PAIRS."""
    found = orbit_of(pair), points_of(pair)
    return rows_of(dict(pair_by_slipwave(pair, *found)), dict(pair_by_second(pair, *found)))


def write(name: str, rows: list[Value]) -> None:
    """Write a table of values, and print it."""
    with FILE.with_name(name).open("w", encoding="utf-8", newline="") as stream:
        csv.writer(stream, lineterminator="\n").writerows([Value._fields, *rows])
    for row in rows:
        print(f"{row.id:26} {row.value!r:>22} +- {row.bar:.1e}")


if __name__ == "__main__":
    found = sw.orbit("paper", model="delay", tol=1e-11), special_points()
    write(FILE.name, rows_of(dict(by_slipwave(*found)), dict(by_second(*found))))
    write("pairs.csv", [row for pair in PAIRS for row in pair_rows(pair)])
    with FILE.with_name("mistakes.csv").open("w", encoding="utf-8", newline="") as stream:
        csv.writer(stream, lineterminator="\n").writerows([("id", "value", "mistake"), *mistaken()])
