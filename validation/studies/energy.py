"""The energy ledger of the full wave: work of the drive = friction + radiated + viscous + stored."""

from dataclasses import dataclass
from typing import Any, cast

import numpy as np

import scene
from scene.observe import EventObserver, follow
from scene.observe.pieces import Array
from validation.models import build
from validation.report.text import plain
from validation.studies.energy_figures import ENTRIES, History, closure, histories
from validation.study import Budget, Cell, Column, Evidence, Figure, Number, StudyResult, Table, Verdict, judge

NAME = "energy"
QUESTION = "Where does the work of the drive go, and is any of it lost on the way?"
SCENES = ("paper", "grip", "viscous")
SECONDS = (8.0, 9.0)

_UNTIL = 200.0
_ROUNDING = 3e-13
_CLOSED = 1e-12
_ALLOWANCE = 0.2


@dataclass(frozen=True)
class Ladder:
    """A family, the order it declares (None: it conserves) and its grids."""

    model: str
    declared: float | None
    cells: tuple[int, ...]


LADDERS = (
    Ladder("fd", None, (6, 12, 24, 48, 96)),
    Ladder("sbp:2", 2.0, (6, 12, 24, 48, 96)),
    Ladder("sbp:4", 4.0, (12, 24, 48, 96)),
    Ladder("fem:1", 2.0, (6, 12, 24, 48, 96)),
    Ladder("fem:2", 3.0, (4, 8, 16, 32)),
    Ladder("dg:1", 2.0, (4, 8, 16, 32, 64)),
    Ladder("dg:2", 3.0, (3, 6, 12, 24)),
)
_HIGH = {"sbp:6": 48, "fem:4": 8, "dg:4": 8, "dg:7": 4}
_SCENES: dict[str, tuple[str, tuple[str, ...]]] = {
    "rigid faces": ("paper", ()),
    "grips": ("grip", ()),
    "viscous": ("viscous", ()),
}


def run(budget: Budget) -> StudyResult:
    """Close the books of every family, then follow the entries over two cycles."""
    residuals = {}
    for count, ladder in enumerate(LADDERS):
        residuals[ladder.model] = np.array([_residual(ladder.model, cells, "rigid faces") for cells in ladder.cells])
        budget.report(0.5 * (count + 1) / len(LADDERS))
    high = {(model, name): _residual(model, cells, name) for model, cells in _HIGH.items() for name in _SCENES}
    shown = {name: _history(name, 4 if budget.quick else 8) for name in _SCENES}
    orders = {ladder.model: _order(ladder.cells, residuals[ladder.model]) for ladder in LADDERS if ladder.declared}
    curves = {ladder.model: (np.array(ladder.cells), np.abs(residuals[ladder.model])) for ladder in LADDERS}
    return StudyResult(
        answer=_answer(shown, residuals["fd"]),
        figures=(
            Figure("entries", _ENTRIES, lambda: histories(shown)),
            Figure("closure", _CLOSURE, lambda: closure(curves)),
        ),
        tables=(_shares(shown), _residual_table(residuals, orders), _high_table(high)),
        verdicts=(
            _conserves(residuals["fd"]),
            *(_order_verdict(ladder, orders[ladder.model]) for ladder in LADDERS if ladder.declared),
            *(_closes(name, {model: high[model, name] for model in _HIGH}) for name in _SCENES),
        ),
        numbers={f"order of {model}": Number(order, 2e-2) for model, order in orders.items()},
    )


def _solver(model: str, cells: int, name: str) -> Any:
    gallery, changes = _SCENES[name]
    return build(model, scene.read(gallery, list(changes)), cells=cells)


def _residual(model: str, cells: int, name: str) -> float:
    """What does not close after `_UNTIL` transits, relative to the largest entry."""
    solver = _solver(model, cells, name)
    follow(solver, _UNTIL)
    return float(cast(Any, solver.energy()).residual)


def _order(cells: tuple[int, ...], residual: Array) -> float:
    """Mean order over the grids above rounding."""
    above = np.abs(residual) > _ROUNDING
    return -float(np.polyfit(np.log(np.array(cells)[above]), np.log(np.abs(residual)[above]), 1)[0])


def _history(name: str, cells: int) -> History:
    """The ledger's entries over two cycles of the settled orbit, from the start of an event."""
    solver = _solver("dg:7", cells, name)
    observer = EventObserver(solver.scene, solver.nodes)
    follow(solver, 2400.0, [observer])
    period = float(observer.events.period[-1])
    moments = solver.time + np.linspace(0.0, 2.0 * period, 1000)
    rows = []
    for moment in moments[1:]:
        if moment > solver.time:
            follow(solver, moment)
        energy = solver.energy()
        rows.append((solver.time, *(getattr(energy, entry) for entry in ENTRIES)))
    table = np.array(rows)
    return History(
        period, table[:, 0] - table[0, 0], {entry: table[:, k + 1] - table[0, k + 1] for k, entry in enumerate(ENTRIES)}
    )


def _answer(shown: dict[str, History], fd: Array) -> str:
    lost = {name: 100.0 * (one.share("radiated") + one.share("viscous")) for name, one in shown.items()}
    return (
        f"All but a little goes into friction: over two cycles grips swallow {lost['grips']:.2g} % of the work and viscosity "
        f"{lost['viscous']:.2g} %. The books of the leapfrog close to {plain(float(np.abs(fd).max()), '.0e')}, those of "
        "the other families at their order or faster."
    )


def _conserves(residual: Array) -> Verdict:
    worst = float(np.abs(residual).max())
    return Verdict(
        "The leapfrog’s ledger closes to rounding on every grid", Evidence.EXACT, "0", plain(worst, ".0e"), judge(worst < _CLOSED)
    )


def _order_verdict(ladder: Ladder, order: float) -> Verdict:
    assert ladder.declared is not None
    return Verdict(
        "Ledgers of the other families close at their order or faster",
        Evidence.EXACT,
        f"{ladder.declared:g} or more",
        f"{order:.2f}",
        judge(order >= ladder.declared - _ALLOWANCE),
        f"`{ladder.model}`",
    )


def _closes(name: str, residuals: dict[str, float]) -> Verdict:
    worst = max(residuals, key=lambda model: abs(residuals[model]))
    off = abs(residuals[worst])
    return Verdict(
        "Ledgers of high degree close to rounding",
        Evidence.EXACT,
        "0",
        plain(off, ".0e"),
        judge(off < _CLOSED),
        f"{name}; worst of {', '.join(residuals)}: `{worst}`",
    )


def _shares(shown: dict[str, History]) -> Table:
    rows: list[tuple[Cell, ...]] = [
        (name, one.period, one.total("input"), *(100.0 * one.share(entry) for entry in ENTRIES[1:]))
        for name, one in shown.items()
    ]
    columns = (
        Column("scene"),
        Column("T", "transits", ".3f"),
        Column("input", "σL", ".5g"),
        *(Column(entry, "% of input", ".4g") for entry in ENTRIES[1:]),
    )
    caption = (
        "Where the drive’s work of two cycles goes, on the settled orbit, by `dg:7`: the paper’s scene; slabs held by grips that "
        "reflect half of every wave; Kelvin–Voigt slabs. What is stored comes back to where it was, up to the sampling of time."
    )
    return Table("shares", caption, columns, tuple(rows))


def _residual_table(residuals: dict[str, Array], orders: dict[str, float]) -> Table:
    rows: list[tuple[Cell, ...]] = []
    for ladder in LADDERS:
        some = [plain(float(value), ".0e") for value in np.abs(residuals[ladder.model])]
        grids = ", ".join(map(str, ladder.cells))
        rows.append((ladder.model, grids, ", ".join(some), ladder.declared, orders.get(ladder.model)))
    columns = (Column("family"), Column("cells"), Column("residual"), Column("declared", "", ".2g"), Column("order", "", ".2f"))
    caption = (
        f"What does not close after {_UNTIL:.0f} transits of the paper’s scene, relative to the largest entry, on each grid, and "
        "its mean order above rounding. Upwind interfaces and faces lose the square of their jumps, so that books close faster "
        "than the solution converges."
    )
    return Table("residuals", caption, columns, tuple(rows))


def _high_table(high: dict[tuple[str, str], float]) -> Table:
    columns = (Column("family"), Column("cells", "a slab", ".0f"), *(Column(name, "", ".0e") for name in _SCENES))
    rows: list[tuple[Cell, ...]] = [
        (model, cells, *(abs(high[model, name]) for name in _SCENES)) for model, cells in _HIGH.items()
    ]
    return Table("high", f"The same for families of high degree, each on one grid, {_UNTIL:.0f} transits.", columns, tuple(rows))


_ENTRIES = (
    "The ledger over two cycles of the settled orbit, counted from an arbitrary moment of the slow phase, in units of σL: above, "
    "work of the drive, heat of friction and the change of what the slabs store; below, what grips radiate and viscosity turns "
    "into heat, on their own scale. Between events the drive loads the slabs; an event spends the store on friction within two "
    "transits."
)
_CLOSURE = (
    f"What does not close in the ledger after {_UNTIL:.0f} transits of the paper’s scene, relative to the largest entry, over "
    "cells per slab. The leapfrog conserves a discrete energy and stays at rounding."
)
