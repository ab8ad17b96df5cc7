"""The energy balance of the full wave: whether any of the drive's work is lost, and at which order."""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TypeAlias

import numpy as np

import slipwave as sw
from validation.chart import Chart, Look, Panel, Scale, Trace
from validation.chart.looks import style_of
from validation.measure.order_fit import Fit, fit_order
from validation.report import EXACT, Budget, Cell, Figure, StudyResult, claim, plain, stated, table
from validation.report.known import of_order, rounding

NAME = "energy"
QUESTION = "Where does the work of the drive go, and is any of it lost on the way?"
SCENES = ("paper", "grip", "viscous")
SECONDS = (5.0, 5.0)

LADDERS = {
    "fd": (6, 12, 24, 48, 96),
    "sbp:2": (24, 32, 48, 64, 96),
    "fem:1": (24, 32, 48, 64, 96),
    "fem:2": (4, 6, 8, 12, 16, 24),
    "dg:1": (8, 12, 16, 24, 32, 48),
    "dg:2": (4, 6, 8, 12, 16),
}
"""Model -> cells per slab of the grids on which the residual is measured."""

ORDERS = {"sbp:2": 4.0, "fem:1": 4.0, "fem:2": 4.0, "dg:1": 3.0, "dg:2": 5.0}
"""The order at which the balance of a model that does not conserve energy closes: that of the square of the jumps at its upwind
interfaces. Continuous fields jump at the slabs' ends only, by the error of the fields: order 2 in `sbp:2` and `fem:1`, and in
`fem:2` too (order P for even P). `dg:P` jumps by h^(P + 1) at each of 1/h faces: order 2 P + 1."""

HIGH = {"sbp:4": 64, "sbp:6": 48, "fem:4": 8, "dg:4": 8, "dg:7": 4}
"""Models of high degree and their cells."""

CONSERVES = "The leapfrog’s ledger closes to rounding on every grid"
SQUARED = "Energy losses of the other families have the order of their squared jumps"
CLOSES = "Ledgers of high degree close to rounding"
_UNTIL = 200.0  # transits
_ABOVE_ROUNDING = 10.0  # times 100 machine epsilons


def run(budget: Budget) -> StudyResult:
    """Measure the residual of every model's balance."""
    ladders = {model: [_balance(model, n) for n in LADDERS[model]] for model in budget.each(LADDERS, end=0.5)}
    pairs = [(model, scene) for model in HIGH for scene in SCENES]
    high = {pair: _balance(pair[0], HIGH[pair[0]], pair[1]) for pair in budget.each(pairs, 1.0, 0.5)}
    residuals = {model: np.array([abs(entries["residual"]) for entries, _ in budgets]) for model, budgets in ladders.items()}
    orders = {model: fit_order(np.array(LADDERS[model]), residuals[model], _ABOVE_ROUNDING) for model in ORDERS}
    ledgers = {scene: high["dg:7", scene][0] for scene in SCENES}
    shares = {scene: [ledger.get(name, 0.0) / ledger["input"] for name in _SINKS] for scene, ledger in ledgers.items()}
    rows: list[list[Cell]] = [[scene, *(100.0 * share for share in by_model)] for scene, by_model in shares.items()]
    return StudyResult(
        answers={
            answer(residuals["fd"], orders, shares): (CONSERVES, SQUARED, CLOSES),
        },
        figures=(Figure("closure", _CLOSURE, lambda: _closure(residuals)),),
        tables=(table("shares", _SHARES, " | ".join(["scene", *(f"{name} [% of input] .4g" for name in _SINKS)]), rows),),
        verdicts=(
            claim(CONSERVES, EXACT, max(residuals["fd"].tolist()), ladders["fd"][0][1], "the worst of all grids"),
            *(of_order(SQUARED, EXACT, fit, ORDERS[model], f"`{model}`") for model, fit in orders.items()),
            *(
                claim(CLOSES, EXACT, abs(entries["residual"]), allowed, f"`{model}`, scene {scene}")
                for (model, scene), (entries, allowed) in high.items()
            ),
        ),
        numbers={f"order of {model}": stated(fit.order, fit.half_width) for model, fit in orders.items()},
    )


def answer(fd: np.ndarray, orders: Mapping[str, Fit], shares: Mapping[str, Sequence[float]]) -> str:
    """Text on shares of the work, and on the closure of the balances."""
    slopes = [fit.order for fit in orders.values()]
    return (
        f"The drive’s work becomes heat of friction, but for {100.0 * shares['grip'][1]:.2g} % that grips and "
        f"{100.0 * shares['viscous'][2]:.2g} % that viscosity absorbs. The leapfrog loses {plain(fd.max(), '.0e')} of it; "
        f"the losses of the others fall at orders {min(slopes):.1f} to {max(slopes):.1f} in the cell."
    )


Balance: TypeAlias = tuple[Mapping[str, float], float]
"""Entries of the ledger, and how far the rounding errors of its steps may leave it open."""


def _balance(model: str, cells: int, scene: str = "paper") -> Balance:
    """The ledger after `_UNTIL` transits of explicit steps."""
    done = sw.run(scene, model, cells=cells, time=None if model == "fd" else "explicit", until=_UNTIL)
    return done.energy or {}, rounding(_UNTIL / done.step)


_SINKS = ("friction", "radiated", "viscous", "stored")


_SHARES = f"Where the work of the drive goes in the first {_UNTIL:.0f} transits, by `dg:7`."
_CLOSURE = (
    f"Residual of the ledger after {_UNTIL:.0f} transits of the paper’s scene, relative to the largest entry. The leapfrog "
    "conserves a discrete energy and stays at rounding; upwind interfaces lose the square of their jumps."
)


_DASHES = ("-", (0, (5, 1.5)), (0, (1.2, 1.2)))


def _closure(residuals: Mapping[str, np.ndarray]) -> Chart:
    """Residuals over cells per slab, a line for each model: colour and marker of its family, dashes by its members."""
    lines, seen = [], Counter[str]()
    for model, values in residuals.items():
        family, style = model.partition(":")[0], style_of(model)
        lines.append(Trace(model, LADDERS[model], values, Look(style.color, _DASHES[seen[family]], style.marker)))
        seen[family] += 1
    axes = Scale("cells per slab", "log"), Scale("residual", "log", floor=1e-16)
    return Chart([Panel("", *axes, lines, grid=True)], 3.6, legend="outside right center")
