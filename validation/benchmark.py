"""`make bench`: ratios of run times. A busy or a slow machine hardly changes them.

python -m validation.benchmark reports/bench       # measures, writes reports/bench/DATE.json, prints a table against the last one

The two runs of a ratio alternate. A ratio is the median over the rounds, with its quartiles. Nothing is judged.
"""

import json
import math
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import Any

import slipwave
from slipwave.files import whole_or_absent
from slipwave.observe import EventObserver, HistoryObserver
from slipwave.scene import Scene
from slipwave.scene.slab import GripFace, KelvinVoigtViscosity, ReflectingFace, StandardLinearViscosity
from slipwave.solve import follow
from validation.compute.models import explicit_time
from validation.references.lsoda import plain_kelvin_voigt
from validation.report.provenance import machine_facts
from validation.results.result import aligned
from validation.timing import March, Race, Setting, Work, alike_and_unlike, solver_of, whole

ROUNDS = 9
GRIDS = {"fd": 128, "sbp:4": 64, "fem:4": 16, "dg:7": 8}
"""Cells at which a transit takes about 0.1 ms (leapfrog) or 0.3 ms (method of lines)."""

REDUCTIONS = ("block12", "block8", "kelvin-voigt", "modal:1", "modal:2", "modal:4", "modal:8")
"""The reductions whose costs are listed in README.md."""

_GRANITE = {
    "interface": {
        "law": "ageing", "a_star": 0.6, "a": 0.01, "b": 0.015,
        "normal_stress": 5e6, "memory_length": 1e-5, "reference_velocity": 1e-6,
    },
    "slab": {"thickness": 10.0, "density": 2700.0, "shear_modulus": 30e9},
    "drive": {"velocity": 1.0},
}  # fmt: skip
_DELAY = Setting("delay", tolerance=1e-9)
_LARGE = Setting("dg:7", cells=31, time="explicit")
_FINE = Setting("dg:8", cells=4, time="exact")
_FINER = Setting("dg:16", cells=2, time="exact")


def ratios() -> Iterator[Race]:
    """All ratios: of sizes, of slabs and faces, of models, of orbits, and against a plain program."""
    paper, run = slipwave.read("paper"), partial(March, begin=1.0)
    unlike = replace(paper, lower=replace(paper.lower, epsilon=1.001 * paper.lower.epsilon))
    grip, reflection = _both(paper, face=GripFace(100.0, 10.0)), _both(paper, face=ReflectingFace(0.999))
    for model, cells in GRIDS.items():
        base = Setting(model, cells=cells, time=explicit_time(model))
        once = run(base, paper, 20.0)
        yield Race(f"{model}: twice the transits", run(base, paper, 40.0), once)
        yield Race(f"{model}: four times the cells", run(replace(base, cells=4 * cells), paper, 20.0), once)
        yield Race(f"{model}: unlike slabs over alike", run(base, unlike, 20.0), once)
        yield Race(f"{model}: grip over rigid face", run(base, grip, 20.0), once)
        yield Race(f"{model}: reflection over rigid face", run(base, reflection, 20.0), once)
        yield Race(f"{model}: time of the delay system", once, run(_DELAY, paper, 20.0))
        if model != "fd":
            yield Race(f"{model}: explicit over exact march", once, run(replace(base, time="exact"), paper, 20.0))
    once = run(_FINE, paper, 200.0)
    yield Race("exact march, dg:8: time of the delay system", once, run(_DELAY, paper, 200.0))
    yield Race("exact march, dg:8: unlike slabs over alike", run(_FINE, unlike, 200.0), once)
    yield Race("exact march, dg:8: grip over rigid face", run(_FINE, grip, 200.0), once)
    time = 0.05 * paper.upper.round_trip
    viscous = {"Kelvin-Voigt": KelvinVoigtViscosity(time), "standard linear": StandardLinearViscosity(time, 0.5)}
    for name, viscosity in viscous.items():
        yield Race(f"exact march, dg:8: {name} over elastic", run(_FINE, _both(paper, viscosity=viscosity), 200.0), once)
    gentle = slipwave.read("paper", ["slab.log10_r=-2.6"])  # errors of psi(600): 5e-10 and 1e-11
    yield Race("exact march: psi(600) to 1e-11 over 1e-9", run(_FINER, gentle, 599.0), run(_FINE, gentle, 599.0))
    set_up = whole(lambda: solver_of(replace(_LARGE, time="exact"), paper).advance(1e-6))  # and the tables of its first step
    yield Race("exact march: set-up of 500 unknowns over a transit of their explicit march", set_up, run(_LARGE, paper, 1.0))
    pair = alike_and_unlike()
    for name in ("commensurate", "irrational"):
        yield Race(f"delay: {name} round trips over alike", run(_DELAY, pair[name], 200.0), run(_DELAY, pair["alike"], 200.0))
    for model in REDUCTIONS:
        reduced = run(Setting(model, tolerance=1e-9), paper, 1000.0)
        yield Race(f"{model}: time of the delay system", reduced, run(_DELAY, paper, 1000.0))
    yield Race("delay: every transit of two cycles of granite over leaps", partial(_granite, True), partial(_granite, False))
    plain = whole(plain_kelvin_voigt, paper, 300.0, 1e-8)
    yield Race("scipy's LSODA over kelvin-voigt", plain, run(Setting("kelvin-voigt", tolerance=1e-8), paper, 300.0))
    for model in ("delay", "kelvin-voigt"):
        orbit, coarse = (whole(slipwave.orbit, paper, model, tol=tol) for tol in (1e-10, 1e-6))
        branch = whole(slipwave.branch, paper, "log10_r=-2.72:-2.3", model, most_points=10)
        yield Race(f"{model}: orbit to 1e-10 over a run of 1000 transits", orbit, run(Setting(model), paper, 1000.0))
        yield Race(f"{model}: orbit to 1e-10 over 1e-6", orbit, coarse)
        yield Race(f"{model}: branch of ten points over an orbit", branch, coarse)
    yield Race("slipwave --help over bare Python", _process("-m", "validation.cli", "--help"), _process("-c", ""))


def _both(scene: Scene, **changes: Any) -> Scene:
    slab = replace(scene.upper, **changes)
    return replace(scene, upper=slab, lower=slab)


def _process(*words: str) -> Work:
    """The work of a separate Python process, from start to end."""
    return whole(subprocess.run, [sys.executable, *words], check=True, capture_output=True)


def _granite(every: bool) -> Callable[[], object]:
    """Two cycles of granite slabs of 10 m at 1 um/s, 1.6e5 transits; `every` one of them marched, or with leaps over the
    sticks."""
    scene = slipwave.read(_GRANITE)
    solver = solver_of(Setting("delay", tolerance=1e-6), scene)
    follow(solver, 1.0)
    needs_all = [HistoryObserver(scene.law, solver.nodes, start=math.inf)] if every else []
    return partial(follow, solver, 1.6e5, [EventObserver(scene, solver.nodes), *needs_all])


def last(folder: Path) -> dict[str, Any]:
    """The newest readable record in `folder`; empty if there is none."""
    for path in sorted(folder.glob("*.json"), reverse=True):
        with suppress(OSError, ValueError, TypeError, KeyError):
            record = json.loads(path.read_text(encoding="utf-8"))
            {float(ratio["median"]) for ratio in record["ratios"].values()}
            return dict(record)
    return {}


def main(folder: Path) -> None:
    """Measure all ratios, write the record, print the table."""
    before = last(folder)
    now = datetime.now(UTC)
    measured = {ratio.name: ratio.measure(ROUNDS) for ratio in ratios()}
    record = {"date": now.strftime("%Y-%m-%d %H:%M UTC"), "machine": machine_facts(), "ratios": measured}
    folder.mkdir(parents=True, exist_ok=True)
    with whole_or_absent(folder / now.strftime("%Y%m%d-%H%M%S.json")) as path:
        path.write_text(json.dumps(record, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    earlier = before.get("ratios", {})
    rows = [_row(name, ratio, earlier.get(name)) for name, ratio in measured.items()]
    print("\n".join(aligned(["ratio", "median", "quartiles", "last", "change"], rows)))
    print(f"last: {before['date']}, commit {before['machine']['commit']}" if before else "no earlier measurement to compare with")


def _row(name: str, now: dict[str, float], before: dict[str, float] | None) -> list[str]:
    spread = f"{now['low']:.2f} to {now['high']:.2f}"
    known = [f"{before['median']:.2f}", f"{now['median'] / before['median'] - 1.0:+.0%}"] if before else ["-", "-"]
    return [name, f"{now['median']:.2f}", spread, *known]


if __name__ == "__main__":
    main(Path(sys.argv[1]))
