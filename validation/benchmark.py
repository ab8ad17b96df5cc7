"""`make bench`: ratios of run times. A busy or a slow machine hardly changes them.

python -m validation.benchmark reports/bench       # measures, writes reports/bench/DATE.json, prints a table against the last one

The two runs of a ratio alternate. A ratio is the median over the rounds, with its quartiles. Nothing is judged.
"""

import dataclasses
import json
import math
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import slipwave
from slipwave.files import whole_or_absent
from slipwave.observe import EventObserver, HistoryObserver
from slipwave.scene import Scene
from slipwave.scene.slab import Face, GripFace, KelvinVoigtViscosity, ReflectingFace, StandardLinearViscosity, Viscosity
from slipwave.solve import follow
from validation.output import print_table
from validation.references.lsoda import plain_kelvin_voigt
from validation.registry.families import explicit_time
from validation.report.provenance import provenance
from validation.run.timing import in_turn
from validation.studies.unlike_slabs.cost import pairs
from validation.work_precision import Setting, march_of, solver_of

ROUNDS = 9
GRIDS = {"fd": 128, "sbp:4": 64, "fem:4": 16, "dg:7": 8}
"""Cells at which a transit takes about 0.1 ms (leapfrog) or 0.3 ms (method of lines)."""

REDUCTIONS = ("block12", "block8", "kelvin-voigt", "modal:1", "modal:2", "modal:4", "modal:8")
"""The reductions in the table of README.md, which takes their costs from here."""

_ROCK = {
    "law": "ageing", "a_star": 0.6, "a": 0.01, "b": 0.015,
    "normal_stress": 5e6, "memory_length": 1e-5, "reference_velocity": 1e-6,
}  # fmt: skip

_LARGE = Setting("dg:7", cells=31, time="explicit")

Work = Callable[[], Callable[[], object]]


class Race(NamedTuple):
    """Two pieces of work (see `in_turn`) and the name of the ratio of their times, first over second."""

    name: str
    first: Work
    second: Work


def _run(setting: Setting, scene: Scene, transits: float) -> Work:
    """A march that is timed from one transit after its start, when the compiled code is loaded."""
    return partial(march_of, setting, scene, transits, 1.0)


def _started(*words: str) -> Work:
    """A separate Python process, from start to end."""
    return lambda: partial(subprocess.run, [sys.executable, *words], check=True, capture_output=True)


def races() -> Iterator[Race]:
    """All ratios: of sizes, of slabs and faces, of models, and against a plain program."""
    paper = slipwave.read("paper")
    unlike = dataclasses.replace(paper, lower=dataclasses.replace(paper.lower, epsilon=1.001 * paper.lower.epsilon))
    for model, cells in GRIDS.items():
        base = Setting(model, cells=cells, time=explicit_time(model))
        once = _run(base, paper, 20.0)
        yield Race(f"{model}: twice the transits", _run(base, paper, 40.0), once)
        yield Race(f"{model}: four times the cells", _run(dataclasses.replace(base, cells=4 * cells), paper, 20.0), once)
        yield Race(f"{model}: unlike slabs over alike", _run(base, unlike, 20.0), once)
        yield Race(f"{model}: grip over rigid face", _run(base, _faced(paper, GripFace(100.0, 10.0)), 20.0), once)
        yield Race(f"{model}: reflection over rigid face", _run(base, _faced(paper, ReflectingFace(0.999)), 20.0), once)
        yield Race(f"{model}: time of the delay system", once, _run(Setting("delay", tolerance=1e-9), paper, 20.0))
        if model != "fd":
            yield Race(f"{model}: explicit over exact march", once, _run(dataclasses.replace(base, time="exact"), paper, 20.0))
    yield from _exact_races(paper, unlike)
    delay, pair = Setting("delay", tolerance=1e-9), pairs()
    for name in ("commensurate", "irrational"):
        yield Race(f"delay: {name} round trips over alike", _run(delay, pair[name], 200.0), _run(delay, pair["alike"], 200.0))
    for model in REDUCTIONS:
        reduced = Setting(model, tolerance=1e-9)
        yield Race(f"{model}: time of the delay system", _run(reduced, paper, 1000.0), _run(delay, paper, 1000.0))
    yield Race("delay: every transit of two cycles of granite over leaps", partial(_granite, True), partial(_granite, False))
    ours = Setting("kelvin-voigt", tolerance=1e-8)
    yield Race(
        "scipy's LSODA over kelvin-voigt", lambda: partial(plain_kelvin_voigt, paper, 300.0, 1e-8), _run(ours, paper, 300.0)
    )
    yield Race("slipwave --help over bare Python", _started("-m", "validation.cli", "--help"), _started("-c", ""))


def _exact_races(paper: Scene, unlike: Scene) -> Iterator[Race]:
    """The exact march on a grid with errors of 1e-9, against the delay system and with what a scene may add."""
    fine, delay = Setting("dg:8", cells=4, time="exact"), Setting("delay", tolerance=1e-9)
    once = _run(fine, paper, 200.0)
    yield Race("exact march, dg:8: time of the delay system", once, _run(delay, paper, 200.0))
    yield Race("exact march, dg:8: unlike slabs over alike", _run(fine, unlike, 200.0), once)
    yield Race("exact march, dg:8: grip over rigid face", _run(fine, _faced(paper, GripFace(100.0, 10.0)), 200.0), once)
    time = 0.05 * paper.upper.round_trip
    viscosities: dict[str, Viscosity] = {
        "Kelvin-Voigt": KelvinVoigtViscosity(time),
        "standard linear": StandardLinearViscosity(time, 0.5),
    }
    for name, viscosity in viscosities.items():
        slab = dataclasses.replace(paper.upper, viscosity=viscosity)
        viscous = dataclasses.replace(paper, upper=slab, lower=slab)
        yield Race(f"exact march, dg:8: {name} over elastic", _run(fine, viscous, 200.0), once)
    gentle = slipwave.read("paper", ["slab.log10_r=-2.6"])  # errors of psi(600): 5e-10 and 1e-11
    finer = Setting("dg:16", cells=2, time="exact")
    yield Race("exact march: psi(600) to 1e-11 over 1e-9", _run(finer, gentle, 599.0), _run(fine, gentle, 599.0))
    yield Race("exact march: set-up of 500 unknowns over a transit of their explicit march", _set_up, _run(_LARGE, paper, 1.0))


def _set_up() -> Callable[[], object]:
    """Making the solver and the tables of its first step; compiled code is loaded."""
    paper = slipwave.read("paper")
    solver_of(dataclasses.replace(_LARGE, time="exact"), paper).advance(1e-6)
    return lambda: solver_of(dataclasses.replace(_LARGE, time="exact"), paper).advance(1e-6)


def _granite(every: bool) -> Callable[[], object]:
    """Two cycles of granite slabs of 10 m at 1 um/s, 1.6e5 transits; `every` one of them, or with leaps over the sticks."""
    scene = slipwave.read(
        {"interface": _ROCK, "slab": {"thickness": 10.0, "density": 2700.0, "shear_modulus": 30e9}, "drive": {"velocity": 1.0}}
    )
    solver = solver_of(Setting("delay", tolerance=1e-6), scene)
    follow(solver, 1.0)
    needs_all = [HistoryObserver(scene.law, solver.nodes, start=math.inf)] if every else []
    return partial(follow, solver, 1.6e5, [EventObserver(scene, solver.nodes), *needs_all])


def _faced(scene: Scene, face: Face) -> Scene:
    slab = dataclasses.replace(scene.upper, face=face)
    return dataclasses.replace(scene, upper=slab, lower=slab)


def measure(race: Race, rounds: int = ROUNDS) -> dict[str, float]:
    """Median and quartiles of the ratio over `rounds`, after one warm-up round."""
    times = in_turn({"first": race.first, "second": race.second}, rounds + 1)[1:]
    low, median, high = np.quantile([pair["first"] / pair["second"] for pair in times], (0.25, 0.5, 0.75))
    return {"median": float(median), "low": float(low), "high": float(high)}


def last(folder: Path) -> dict[str, Any]:
    """The newest readable record in `folder`; empty if there is none."""
    for path in sorted(folder.glob("*.json"), reverse=True):
        with suppress(OSError, ValueError, TypeError, KeyError):
            record = json.loads(path.read_text(encoding="utf-8"))
            {float(ratio["median"]) for ratio in record["ratios"].values()}
            return dict(record)
    return {}


def main(folder: Path) -> None:
    """Measure all, write the record, print the table."""
    before = last(folder)
    now = datetime.now(UTC)
    ratios = {race.name: measure(race) for race in races()}
    record = {"date": now.strftime("%Y-%m-%d %H:%M UTC"), "machine": provenance(), "ratios": ratios}
    folder.mkdir(parents=True, exist_ok=True)
    with whole_or_absent(folder / now.strftime("%Y%m%d-%H%M%S.json")) as path:
        path.write_text(json.dumps(record, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    print_table(["ratio", "median", "quartiles", "last", "change"], [*_rows(ratios, before.get("ratios", {}))])
    print(f"last: {before['date']}, commit {before['machine']['commit']}" if before else "no earlier measurement to compare with")


def _rows(now: dict[str, dict[str, float]], before: dict[str, dict[str, float]]) -> Iterator[list[str]]:
    for name, ratio in now.items():
        old = float(before[name]["median"]) if name in before else math.nan
        change = "-" if math.isnan(old) else f"{ratio['median'] / old - 1.0:+.0%}"
        spread = f"{ratio['low']:.2f} to {ratio['high']:.2f}"
        yield [name, f"{ratio['median']:.2f}", spread, "-" if math.isnan(old) else f"{old:.2f}", change]


if __name__ == "__main__":
    main(Path(sys.argv[1]))
