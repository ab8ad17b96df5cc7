"""Pairs of unlike slabs, marched by one model: its figures, its last cycle, and its processor time beside alike slabs."""

from dataclasses import dataclass
from typing import Any

from slipwave.observe import HistoryObserver
from slipwave.scene import Scene
from slipwave.solve import follow
from validation.measure.cycle import Cycle, cut, watch
from validation.registry.build import build
from validation.registry.families import explicit_time
from validation.timing import March, Setting, alike_and_unlike, in_turn, warm_up

UNTIL = 600.0
TOLERANCE = 1e-11
"""Of the delay system."""
_WATCHED = 140.0  # transits before UNTIL that are kept for the picture
_BEFORE, _AFTER = 3.0, 2.0

MODELS: dict[str, tuple[float, dict[str, Any]]] = {
    "delay": (600.0, {"tolerance": 1e-9}),
    "delay, loose": (600.0, {"tolerance": 1e-6}),
    "dg:7": (200.0, {"cells": 4, "time": "explicit"}),
    "dg:7, finer": (60.0, {"cells": 8, "time": "explicit"}),
    "fd": (200.0, {"cells": 128, "cfl": 0.5}),
}
"""Row -> transits timed and options."""

Costs = dict[str, dict[str, float]]
"""model -> pair -> microseconds a transit."""


@dataclass(frozen=True)
class PairRun:
    """A model's grid; psi at UNTIL, and period, drop and largest rate of the last complete cycle; that cycle and a little on both
    sides."""

    model: str
    cells: int | None
    figures: dict[str, float]
    cycle: Cycle

    def differs(self, exact: "PairRun") -> dict[str, float]:
        """Difference in psi (absolute) and in the cycle's figures (relative)."""
        ours, theirs = self.figures, exact.figures
        return {name: ours[name] - theirs[name] if name == "psi" else ours[name] / theirs[name] - 1.0 for name in ours}


def march_pair(scene: Scene, model: str, cells: int | None = None, cfl: float | None = None) -> PairRun:
    """Run `model` on `scene` to UNTIL."""
    if model == "delay":
        solver = build(model, scene, tolerance=TOLERANCE)
    else:
        solver = build(model, scene, cells=cells, cfl=cfl, time=explicit_time(model))
    observer = watch(solver, UNTIL - _WATCHED)
    history = HistoryObserver(scene.law, solver.nodes)
    final = follow(solver, UNTIL, [observer, history])
    events = observer.events()
    last = {name: float(getattr(events, name)[-1]) for name in ("period", "stress_drop", "v_max")}
    samples = history.samples(per_piece=6 if model == "delay" else 1)
    cycle = cut(scene.law, samples, float(events.time[-1]), last["period"], _BEFORE, _AFTER)
    return PairRun(model, cells, {"psi": final.psi, **last}, cycle)


def costs(repeats: int) -> Costs:
    """Least of `repeats` runs of every model on every pair; the pairs alternate."""
    scene = alike_and_unlike()
    found: Costs = {}
    for row, (until, options) in MODELS.items():
        setting = Setting(row.partition(",")[0], **options)
        runs = {name: March(setting, pair, until) for name, pair in scene.items()}
        for pair in scene.values():
            warm_up(setting, pair)
        rounds = in_turn(runs, repeats)
        found[row] = {name: 1e6 * min(times[name] for times in rounds) / until for name in scene}
    return found
