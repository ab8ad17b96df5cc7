"""The energy balance of the full wave: its closure, and the distribution of the drive's work."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

import slipwave
from slipwave.observe.pieces import Array
from slipwave.solve import Energy, FieldSolver, follow
from validation.compute.build import build_full_wave
from validation.compute.models import explicit_time
from validation.measure.cycle import watch
from validation.measure.order_fit import Fit, fit_order
from validation.study import EXACT, Budget, Cell, Figure, StudyResult, Table, Verdict, claim, stated, table
from validation.study.drawing import Drawing, grid_styles, subplots
from validation.study.known import of_order, rounding
from validation.study.text import plain

NAME = "energy"
QUESTION = "Where does the work of the drive go, and is any of it lost on the way?"
SCENES = ("paper", "grip", "viscous")
SECONDS = (8.0, 9.0)

ENTRIES = ("input", "friction", "stored", "radiated", "viscous")
"""Entries of the balance, in display order."""

UNTIL = 200.0
"""Transits after which the residual is taken."""

_ROUNDING = 10.0
"""Residuals below 100 machine epsilons times this are rounding."""

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
"""Families of high degree and their cells."""

BOUNDARIES = {"rigid faces": "paper", "grips": "grip", "viscous": "viscous"}
"""Sink of the energy -> gallery name of the scene."""


@dataclass(frozen=True)
class EnergyRun:
    """Entries of the ledger (sigma L) since the first moment of `time` (transits), over two periods, and how far the rounding of
    all steps so far may put them off, relative to the input."""

    period: float
    time: Array
    entries: dict[str, Array]
    rounding: float

    def total(self, entry: str) -> float:
        """Increase of `entry` over the two cycles."""
        return float(self.entries[entry][-1])

    def share(self, entry: str) -> float:
        """Increase of `entry` as a fraction of the input."""
        return self.total(entry) / self.total("input")


_PENS = {
    "input": ("#111111", "-"),
    "friction": ("#d55e00", (0, (5, 1.5))),
    "stored": ("#0072b2", (0, (1.2, 1.2))),
    "radiated": ("#009e73", "-"),
    "viscous": ("#cc4f8a", (0, (5, 1.5))),
}
_FLOOR = 1e-16


def run(budget: Budget) -> StudyResult:
    """Measure the residual of every family's balance, then follow the entries over two cycles."""
    residuals = {model: np.array([residual_of(model, n) for n in LADDERS[model]]) for model in budget.each(LADDERS, end=0.5)}
    high = {model: {name: residual_of(model, cells, name) for name in BOUNDARIES} for model, cells in HIGH.items()}
    shown = {name: history_of(name, 4 if budget.quick else 8) for name in BOUNDARIES}
    orders = {model: ledger_order(model, residuals[model]) for model in ORDERS}
    return StudyResult(
        answer=answer(shown, residuals["fd"], orders),
        figures=(Figure("entries", _ENTRIES, lambda: histories(shown)), Figure("closure", _CLOSURE, lambda: closure(residuals))),
        tables=(_shares_table(shown), _high_table(high)),
        verdicts=(*ladder_verdicts(residuals["fd"], orders), _balances(shown), *high_verdicts(high)),
        numbers={f"order of {model}": stated(found.order, found.half_width) for model, found in orders.items()},
    )


def answer(shown: Mapping[str, EnergyRun], fd: Array, orders: Mapping[str, Fit]) -> str:
    """Text on shares of the work, and on the closure of the balances."""
    lost = {name: 100.0 * (history.share("radiated") + history.share("viscous")) for name, history in shown.items()}
    friction = 100.0 * min(history.share("friction") for history in shown.values())
    slopes = [found.order for found in orders.values()]
    return (
        f"At least {friction:.0f} % goes into friction: over two cycles grips absorb {lost['grips']:.2g} % of the work and "
        f"viscosity {lost['viscous']:.2g} %. The ledger of the leapfrog closes to {plain(float(fd.max()), '.0e')}; "
        f"the residuals of the other families fall at orders {min(slopes):.1f} to {max(slopes):.1f} in the cell."
    )


def ladder_verdicts(fd: Array, orders: Mapping[str, Fit]) -> Iterator[Verdict]:
    """The leapfrog on every grid; the order of every model that does not conserve, with its 95 % interval."""
    conserves = "The leapfrog’s ledger closes to rounding on every grid"
    yield claim(conserves, EXACT, float(fd.max()), closes_to("fd", LADDERS["fd"][0]))
    title = "Energy losses of the other families have the order of their squared jumps"
    for model, found in orders.items():
        yield of_order(title, EXACT, found, ORDERS[model], f"`{model}`")


def _balances(shown: Mapping[str, EnergyRun]) -> Verdict:
    """The entries of two cycles: the input is the sum of the others."""
    off = {name: abs(1.0 - sum(history.share(entry) for entry in ENTRIES[1:])) for name, history in shown.items()}
    worst = max(off, key=lambda name: off[name] / shown[name].rounding)
    title = "Over two cycles the work of the drive is friction, radiation, viscous heat and what stays in the slabs"
    return claim(title, EXACT, off[worst], shown[worst].rounding, f"relative to the work; {', '.join(off)}; shown: {worst}")


def high_verdicts(high: Mapping[str, Mapping[str, float]]) -> Iterator[Verdict]:
    """Families of high degree on every scene."""
    for name in BOUNDARIES:
        allowed = {model: closes_to(model, HIGH[model], name) for model in high}
        worst = max(high, key=lambda model: high[model][name] / allowed[model])
        remark = f"{name}; worst of {', '.join(high)}: `{worst}`"
        yield claim("Ledgers of high degree close to rounding", EXACT, high[worst][name], allowed[worst], remark)


def _shares_table(shown: Mapping[str, EnergyRun]) -> Table:
    shares = ENTRIES[1:]
    heading = ["scene", "T [transits] .3f", "input [σL] .5g", *(f"{entry} [% of input] .4g" for entry in shares)]
    rows: Iterator[tuple[Cell, ...]] = (
        (name, history.period, history.total("input"), *(100.0 * history.share(entry) for entry in shares))
        for name, history in shown.items()
    )
    caption = (
        "Where the drive’s work of two cycles goes, on the settled orbit, by `dg:7`: the paper’s scene; slabs held by grips that "
        "reflect half of every wave; Kelvin–Voigt slabs. The stored energy returns to its first value, up to the sampling in "
        "time."
    )
    return table("shares", caption, " | ".join(heading), rows)


def _high_table(high: Mapping[str, Mapping[str, float]]) -> Table:
    caption = f"The same residual for families of high degree, each on one grid, {UNTIL:.0f} transits."
    heading = " | ".join(["family", "cells [a slab] .0f", *(f"{name} .0e" for name in BOUNDARIES)])
    return table("high", caption, heading, ((model, HIGH[model], *sizes.values()) for model, sizes in high.items()))


_ENTRIES = (
    "The ledger over two cycles of the settled orbit, counted from an arbitrary moment of the slow phase, in units of σL. Above: "
    "work of the drive, heat of friction and change of the energy stored in the slabs. Below, on another scale: energy radiated "
    "through grips and heat of viscosity. Between events the drive loads the slabs; within two transits an event turns the "
    "stored energy into heat of friction."
)
_CLOSURE = (
    f"Residual of the ledger after {UNTIL:.0f} transits of the paper’s scene, relative to the largest entry, over "
    "cells per slab. The leapfrog conserves a discrete energy and stays at rounding. Upwind interfaces lose the square of their "
    "jumps. Continuous fields jump at the slabs’ ends alone, by the error of the fields (order 2 in `sbp:2` and `fem:1`; order P "
    "for even P in `fem:P`): the residual has twice that order. `dg:P` jumps by h^{P+1} at each of 1/h faces: order 2P + 1."
)


def histories(shown: Mapping[str, EnergyRun]) -> Drawing:
    """A column per scene: large entries above, small ones below."""
    x, y = "time (transits)", r"energy $/\sigma L$"
    figure, grid = subplots(4.8, 2, len(shown), x, y, sharex="col", sharey="row", height_ratios=(2.0, 1.0))
    for column, (name, history) in zip(grid.T, shown.items(), strict=True):
        for axes, entries in zip(column, (ENTRIES[:3], ENTRIES[3:]), strict=True):
            for entry in entries:
                color, dashes = _PENS[entry]
                axes.plot(history.time, history.entries[entry], color=color, linestyle=dashes, label=entry)
        column[0].set_title(name)
    handles = [*grid[0, 0].get_lines(), *grid[1, 0].get_lines()]
    figure.legend(handles, ENTRIES, loc="outside upper left", ncols=5, handlelength=3.0)
    return figure


def closure(residuals: Mapping[str, Array]) -> Drawing:
    """Residuals over cells per slab, a line for each family."""
    figure, axes = subplots(3.6, 1, 1, "cells per slab", "residual")
    for model, look in grid_styles(residuals).items():
        shown = np.maximum(residuals[model], _FLOOR)
        axes.loglog(LADDERS[model], shown, color=look.color, marker=look.marker, linestyle=look.dashes, label=model)
    axes.grid(True)
    figure.legend(loc="outside right center")
    return figure


def residual_of(model: str, cells: int, name: str = "rigid faces") -> float:
    """Modulus of the residual after `UNTIL` transits, relative to the largest entry."""
    solver = _explicit(model, cells, name)
    follow(solver, UNTIL)
    return abs(_ledger(solver).residual)


def closes_to(model: str, cells: int, name: str = "rigid faces") -> float:
    """What the rounding errors of its steps may leave of the same residual."""
    return rounding(UNTIL / _explicit(model, cells, name).step)


def _explicit(model: str, cells: int, name: str) -> FieldSolver:
    return build_full_wave(model, slipwave.read(BOUNDARIES[name]), cells=cells, time=explicit_time(model))


def ledger_order(model: str, residual: Array) -> Fit:
    """The order of the residuals above rounding; ValueError if fewer than four are."""
    return fit_order(np.array(LADDERS[model]), residual, _ROUNDING)


def history_of(name: str, cells: int) -> EnergyRun:
    """The entries over two cycles of the settled orbit, from the end of a run on; linear between ends of steps."""
    solver = build_full_wave("dg:7", slipwave.read(BOUNDARIES[name]), cells=cells, time="exact")
    solver.keep_ledger()
    period = float(watch(solver, 2400.0).events().period[-1])
    begin = solver.time
    moments = np.linspace(begin, begin + 2.0 * period, 1000)
    rows = [_entries(solver)]
    for moment in moments[1:]:
        if moment > solver.time:
            follow(solver, moment)
            rows.append(_entries(solver))
    time, *entries = np.array(rows).T
    found = (np.interp(moments, time, entry - entry[0]) for entry in entries)
    share = solver.time / (2.0 * period)
    return EnergyRun(period, moments - begin, dict(zip(ENTRIES, found, strict=True)), share * rounding(solver.time / solver.step))


def _ledger(solver: FieldSolver) -> Energy:
    energy = solver.energy()
    if energy is None:
        raise ValueError(f"{solver.model}: keeps no ledger")
    return energy


def _entries(solver: FieldSolver) -> tuple[float, ...]:
    energy = _ledger(solver)
    return (solver.time, *(getattr(energy, entry) for entry in ENTRIES))
