"""What does leaving the waves out do to the a, b and L that are fitted?

Records of the exact delay system, a velocity step by ten and stick-slip, are fitted by models without waves, which know the
slabs' impedance; free are a, b, L and the stiffness. What counts is the `swing`: the period of the slowest free swing of sample
and machine (without a machine two transits) over the time of slip by L at the faster velocity, which is one second here.

    python examples/bias/bias.py            # computes errors.csv beside this file anew
"""

import csv
import math
import tempfile
from collections.abc import Iterable, Iterator
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq

import slipwave as sw

RECORD = Path(__file__).with_name("errors.csv")
MODELS = ("quasistatic", "quasidynamic", "block12")
SWINGS = tuple(round(10.0**power, 6) for power in np.linspace(-2.5, 0.0, 9))
MACHINES = (0.0, 10.0)
"""Masses over that of the slab; 0: no machine."""
STEPPED, SLIPPING = (1.2, 5.0, 32.0), (0.5, 0.8)
"""Stiffness over the critical one: stable, and stick-slip."""
TRUTH = {"interface.a": 0.01, "interface.b": 0.015, "interface.memory_length": 1e-5}
STIFFNESS = "slab.shear_modulus"

_STRESS, _THICKNESS, _SLOW, _FAST = 5e6, 0.05, "1 um/s", "10 um/s"  # Pa, m
_NOISE = 1e-5
_ALLOWED = 0.01


class Point(NamedTuple):
    """A sample: swing, stiffness `kappa` over the critical one (b - a) sigma/L, and mass of the machine over that of the slab."""

    swing: float
    kappa: float
    mass: float


def points() -> Iterator[Point]:
    """All points, those of stick-slip last."""
    yield from (Point(swing, kappa, mass) for mass, kappa, swing in product(MACHINES, STEPPED, SWINGS))
    yield from (Point(swing, kappa, mass) for mass, kappa, swing in product(MACHINES, SLIPPING, SWINGS[4:8]))


def scenes(point: Point) -> tuple[Any, Any]:
    """The sample with its machine, which has half of the compliance; slabs of the same impedance and stiffness without one."""
    a, b, length = TRUTH.values()
    modulus = 2.0 * _THICKNESS * point.kappa * (b - a) * _STRESS / length
    if not point.mass:
        alone = _scene(point, modulus, modulus * (point.swing / (4.0 * _THICKNESS)) ** 2, {"kind": "rigid"})
        return alone, alone
    swung = brentq(lambda x: (1.0 - point.mass * x * x) * math.cos(x) - x * math.sin(x), 0.0, math.pi / 2.0)
    density = 2.0 * modulus * (point.swing * swung / math.pi / (2.0 * _THICKNESS)) ** 2
    machine = {"kind": "machine", "stiffness": 2.0 * modulus / _THICKNESS, "impedance": 0.0}
    held = _scene(point, 2.0 * modulus, density, machine | {"mass": point.mass * density * _THICKNESS})
    return held, _scene(point, modulus, 2.0 * density, {"kind": "rigid"})


def _scene(point: Point, modulus: float, density: float, face: dict[str, Any]) -> Any:
    a, b, length = TRUTH.values()
    interface = {"law": "ageing", "a_star": 0.6, "a": a, "b": b, "normal_stress": _STRESS, "memory_length": length}
    slab = {"density": density, "shear_modulus": modulus, "thickness": _THICKNESS, "face": face}
    velocity = [["0 s", _SLOW], ["0.5 s", _SLOW], ["0.5 s", _FAST]] if point.kappa > 1.0 else _FAST
    return sw.read(
        {"interface": interface | {"reference_velocity": _SLOW}, "slab": slab, "drive": {"velocity": velocity}, "name": "sample"}
    )


def record(point: Point, file: Path) -> None:
    """Write what a laboratory would see: friction at 200 times of a step, or means over a recorder's filter of stick-slip."""
    steps, scene = point.kappa > 1.0, scenes(point)[0]
    end = 5.0 if steps else 300.0 / point.kappa
    every = max(1, round(0.1 / point.swing if steps else 0.04 / point.kappa / (point.swing / 128.0)))
    start = {"start.size": 0.0 if steps else 1e-3}
    sw.run(scene, model="delay", until=f"{end} s", interface=True, every=every, tol=1e-8, **start).write_series(file)
    time, friction = np.loadtxt(file, delimiter=",", skiprows=1, usecols=(0, 5)).T
    times = np.linspace(0.4, end, 200) if steps else np.arange(0.5 * end, end, 0.2 / point.kappa)
    if steps:
        seen = np.interp(times, time, friction)
    else:
        count, edges = np.histogram(time, times)
        seen = np.histogram(time, times, weights=friction)[0] / count
        times = 0.5 * (edges[1:] + edges[:-1]) - times[0]
    noise = np.random.default_rng(1).standard_normal(seen.size)
    np.savetxt(file, np.column_stack([times, seen + _NOISE * noise]), delimiter=",", header="time [s],friction", comments="")


def errors(point: Point, file: Path, model: str) -> list[float]:
    """Relative errors of a, b, L and stiffness of a fit to this record, and half widths of its 95 % intervals; nothing where the
    fit came to no end."""
    known = scenes(point)[1]
    truth = TRUTH | {STIFFNESS: known.tables["slab"]["shear_modulus"]}
    try:
        found = sw.fit(known, data=[str(file)], free=[*truth], model=model, tol=1e-8)
    except sw.NumericsError as error:
        found = getattr(error, "result", None)
    rows = {key: found.parameters[key] for key in truth} if found else {}
    if not all(row["determined"] for row in rows.values()):
        return []
    off = [row["value"] / truth[key] - 1.0 for key, row in rows.items()]
    return off + [0.5 * math.log(row["high"] / row["low"]) for row in rows.values()]


def rows_of(chosen: Iterable[Point]) -> Iterator[list[Any]]:
    """Yield the rows of `errors.csv` at these points."""
    with tempfile.TemporaryDirectory() as folder:
        for point in chosen:
            record(point, file := Path(folder) / "record.csv")
            for model in MODELS:
                if found := errors(point, file, model):
                    yield [model, *point, *(float(f"{one:.3g}") for one in found)]


def recorded() -> list[dict[str, Any]]:
    """The rows of `errors.csv`."""
    with RECORD.open(encoding="utf-8", newline="") as file:
        return [{key: value if key == "model" else float(value) for key, value in row.items()} for row in csv.DictReader(file)]


def limit(rows: Iterable[dict[str, Any]], model: str) -> float:
    """Largest swing up to which no error of a, b and L of a velocity step exceeds 1 %, interpolated in logarithms."""
    mine = [row for row in rows if row["model"] == model and row["kappa"] > 1.0]
    worst = [max(abs(row[f"error {q}"]) for q in "abL" for row in mine if row["swing"] == swing) for swing in SWINGS]
    k = next(k for k, error in enumerate(worst) if error >= _ALLOWED)
    share = math.log(_ALLOWED / worst[k - 1]) / math.log(worst[k] / worst[k - 1])
    return SWINGS[k - 1] * (SWINGS[k] / SWINGS[k - 1]) ** share


def main() -> None:
    """Write the record."""
    kinds = [f"{kind} {name}" for kind in ("error", "half") for name in "abLk"]
    with RECORD.open("w", encoding="utf-8", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["model", *Point._fields, *kinds])
        for row in rows_of(points()):
            table.writerow(row)
            file.flush()


if __name__ == "__main__":
    main()
