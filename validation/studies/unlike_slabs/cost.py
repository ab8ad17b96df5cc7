"""Processor time per transit of unlike slabs beside alike ones, in one run, on orbits of the same kind."""

import math
from typing import Any

from validation.study import SELF, Cell, Outcome, Table, Verdict, judge, table
from validation.timing import UNLIKE_R, March, Setting, alike_and_unlike, in_turn, warm_up

_MODELS: dict[str, tuple[float, dict[str, Any]]] = {
    "delay": (600.0, {"tolerance": 1e-9}),
    "delay, loose": (600.0, {"tolerance": 1e-6}),
    "dg:7": (200.0, {"cells": 4, "time": "explicit"}),
    "dg:7, finer": (60.0, {"cells": 8, "time": "explicit"}),
    "fd": (200.0, {"cells": 128, "cfl": 0.5}),
}
"""Row -> transits timed and options."""
_CELLS_RATIO = 3.0
"""Cells of the 2 : 1 pair over those of one alike slab: the longer round trip takes twice as many of the same size."""
_LIMITS = {
    "delay": {"commensurate": 3.0, "irrational": 10.0},
    "dg:7": {"commensurate": 1.1 * _CELLS_RATIO},
    "dg:7, finer": {"commensurate": 1.1 * _CELLS_RATIO},
    "fd": {"commensurate": 1.1 * _CELLS_RATIO},
}

Costs = dict[str, dict[str, float]]
"""model -> pair -> microseconds a transit."""


def costs(repeats: int) -> Costs:
    """Least of `repeats` runs of every model on every pair; the pairs alternate."""
    scene = alike_and_unlike()
    found: Costs = {}
    for row, (until, options) in _MODELS.items():
        setting = Setting(row.partition(",")[0], **options)
        runs = {name: March(setting, pair, until) for name, pair in scene.items()}
        for pair in scene.values():
            warm_up(setting, pair)
        rounds = in_turn(runs, repeats)
        found[row] = {name: 1e6 * min(times[name] for times in rounds) / until for name in scene}
    return found


def cost_table(found: Costs) -> Table:
    """Microseconds a transit and ratios."""
    rows: list[tuple[Cell, ...]] = []
    for model, each in found.items():
        alike = each["alike"]
        others = [cell for name in ("commensurate", "irrational") for cell in (each[name], each[name] / alike)]
        rows.append((model.partition(",")[0], _words(model), alike, *others))
    heading = "model | setting | alike [μs] .1f | 2 : 1 [μs] .1f | ratio .2f | √2 : 1 [μs] .1f | ratio .2f"
    caption = (
        "Processor time of one transit of the upper slab, march and event detection, fastest of several alternating runs. r is "
        f"10^{{−2.68}} for the alike pair, {UNLIKE_R[0]:g} and {UNLIKE_R[1]:g} for the unlike ones, so that the slip events of "
        f"all three reach about the same rate (3300 to 3600 V* in {_MODELS['delay'][0]:g} transits): faster events need smaller "
        "steps, alike slabs or not."
    )
    return table("cost", caption, heading, rows)


def _words(model: str) -> str:
    options = _MODELS[model][1]
    if "tolerance" in options:
        return f"tolerance 10^{{{math.log10(options['tolerance']):.0f}}}"
    return f"{options['cells']:.0f} cells a slab"


def cost_verdicts(found: Costs) -> list[Verdict]:
    """Ratios against what is promised."""
    return [
        _cost_verdict(model, pair, found[model][pair] / found[model]["alike"], limit)
        for model, limits in _LIMITS.items()
        for pair, limit in limits.items()
    ]


def _cost_verdict(model: str, pair: str, ratio: float, limit: float) -> Verdict:
    if model == "delay":
        name, expected, why = "delay system", f"{limit:g} times at most", ""
    else:
        name, expected = "full wave", f"{_CELLS_RATIO:g} times, the ratio of the cells, within a tenth"
        why = "; two slabs are marched instead of one, and the longer one has twice the cells"
    title, outcome = f"Cost of unlike slabs over alike ones: {name}", judge(ratio <= limit, Outcome.FINDING)
    remark = f"`{model.partition(',')[0]}`, {_words(model)}, {pair} round trips{why}"
    return Verdict(title, SELF, expected, f"{ratio:.1f} times", outcome, remark)
