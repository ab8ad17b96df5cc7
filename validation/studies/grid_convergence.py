"""Every full-wave family against the delay system: order in every output, and run time against error."""

import math
import time
from dataclasses import dataclass

import numpy as np

import scene
from scene.observe import EventObserver, follow
from scene.observe.pieces import Array
from scene.scene import Scene
from validation.models import build
from validation.report.text import plain
from validation.studies.grid_convergence_figures import convergence_and_cost
from validation.study import Budget, Cell, Column, Evidence, Figure, Number, StudyResult, Table, Verdict, judge

NAME = "grid-convergence"
QUESTION = "Do four independent discretisations of the wave agree with the delay system, and at what cost?"
SCENES = ("paper-2.6",)
SECONDS = (8.0, 20.0)

UNTIL = 200.0
"""Transits of each run: the smooth start and the first cycles, the last complete one of which is compared."""

_OUTPUTS = {"psi": "ψ", "period": "T", "stress_drop": "Δμ", "elastic_stress_drop": "Δy", "v_max": "v_{max}"}
_ROUNDING = 2e-11  # errors below are the reference's own
_ALLOWANCE = 0.2


@dataclass(frozen=True)
class Ladder:
    """A family, the order it declares in every output (more is welcome; None where rounding comes before an order can be read),
    its grids, and what it promises in T and the drop."""

    model: str
    declared: float | None
    cells: tuple[int, ...]
    cfl: float | None = None
    promised: float | None = None


LADDERS = (
    Ladder("fd", 2.0, (96, 192, 384, 768), cfl=0.5),
    Ladder("sbp:2", 2.0, (96, 192, 384, 768)),
    Ladder("sbp:4", 4.0, (32, 64, 128, 256)),
    Ladder("sbp:6", 5.0, (24, 36, 54, 81, 162), promised=1e-6),
    Ladder("fem:1", 2.0, (96, 192, 384, 768)),
    Ladder("fem:2", 3.0, (16, 32, 64, 128)),
    Ladder("fem:4", 5.0, (4, 6, 9, 13, 18), promised=1e-8),
    Ladder("dg:3", 4.0, (12, 24, 48, 96)),
    Ladder("dg:5", 6.0, (2, 3, 4, 6, 8)),
    Ladder("dg:7", None, (2, 3, 4, 5, 6), promised=1e-9),
)


@dataclass(frozen=True)
class Measured:
    """A family's errors by output (absolute for psi, relative otherwise) and wall seconds, one entry per grid."""

    ladder: Ladder
    errors: dict[str, Array]
    seconds: Array

    def order(self, output: str) -> float:
        """Mean order over the grids whose error is above rounding, by least squares; NaN if there are fewer than three."""
        error = np.abs(self.errors[output])
        above = error > _ROUNDING
        if above.sum() < 3:
            return math.nan
        return -float(np.polyfit(np.log(np.array(self.ladder.cells)[above]), np.log(error[above]), 1)[0])


def run(budget: Budget) -> StudyResult:
    """March every family on every grid and fit its orders."""
    what = scene.read("paper-2.6")
    exact, _ = _outputs("delay", what, tolerance=1e-11)
    measured = []
    for count, ladder in enumerate(LADDERS):
        measured.append(_measure(ladder, what, exact, 1 if budget.quick else 3))
        budget.report((count + 1) / len(LADDERS))
    return StudyResult(
        answer=_answer(measured),
        figures=(Figure("families", _CAPTION, lambda: convergence_and_cost(_curves(measured))),),
        tables=(_orders(measured), _finest(measured)),
        verdicts=(
            *(_order_verdict(one) for one in measured if one.ladder.declared),
            *(_promise(one) for one in measured if one.ladder.promised),
        ),
        notes=(
            "The families share the interface condition and the event detector, and nothing else: neither grids nor difference "
            "operators nor time stepping. The delay system has no grid at all. Leapfrog runs here at CFL 0.5, where it is no "
            "rewriting of the delay system.",
            "Elements and Galerkin schemes converge faster at the interface than they declare; the declared order is a lower "
            "bound. High degrees fall to rounding over a few coarse grids, with changes of sign on the way, so that their mean "
            "orders are rough.",
        ),
        numbers={f"{one.ladder.model} order in ψ": Number(one.order("psi"), 5e-2) for one in measured},
    )


def _outputs(model: str, what: Scene, **options: float | None) -> tuple[dict[str, float], float]:
    """The run's outputs and its wall seconds."""
    began = time.perf_counter()
    solver = build(model, what, **options)  # type: ignore[arg-type]
    observer = EventObserver(what, solver.nodes)
    final = follow(solver, UNTIL, [observer])
    seconds = time.perf_counter() - began
    last = {name: float(getattr(observer.events, name)[-1]) for name in _OUTPUTS if name != "psi"}
    return {"psi": final.psi, **last}, seconds


def _measure(ladder: Ladder, what: Scene, exact: dict[str, float], repeats: int) -> Measured:
    follow(build(ladder.model, what, cells=ladder.cells[0], cfl=ladder.cfl), 2.0)
    runs = [[_outputs(ladder.model, what, cells=n, cfl=ladder.cfl) for _ in range(repeats)] for n in ladder.cells]
    errors = {name: np.array([_error(name, some[0][0], exact) for some in runs]) for name in _OUTPUTS}
    return Measured(ladder, errors, np.array([min(seconds for _, seconds in some) for some in runs]))


def _error(name: str, ours: dict[str, float], exact: dict[str, float]) -> float:
    return ours[name] - exact[name] if name == "psi" else ours[name] / exact[name] - 1.0


def _answer(measured: list[Measured]) -> str:
    best = {one.ladder.model: float(np.min(np.abs(one.errors["period"]))) for one in measured}
    told = ", ".join(f"{name} to {plain(best[model], '.0e')}" for name, model in _NAMED.items())
    return f"They do: {told} in the period. Time for the same error falls steeply with the order."


_NAMED = {"leapfrog": "fd", "summation by parts": "sbp:6", "finite elements": "fem:4", "discontinuous Galerkin": "dg:7"}


def _order_verdict(one: Measured) -> Verdict:
    assert one.ladder.declared is not None
    orders = {symbol: order for name, symbol in _OUTPUTS.items() if not math.isnan(order := one.order(name))}
    short = [symbol for symbol, order in orders.items() if order < one.ladder.declared - _ALLOWANCE]
    return Verdict(
        "Every full-wave family reaches its order in every output",
        Evidence.WITNESS,
        f"{one.ladder.declared:g} or more",
        f"{min(orders.values()):.2f} to {max(orders.values()):.2f}",
        judge(not short),
        f"`{one.ladder.model}`" + (f": short in {', '.join(short)}" if short else ""),
    )


def _promise(one: Measured) -> Verdict:
    off = max(abs(float(one.errors[name][-1])) for name in ("period", "stress_drop"))
    assert one.ladder.promised is not None
    return Verdict(
        "Independent discretisations agree with the delay system on period and stress drop",
        Evidence.WITNESS,
        plain(one.ladder.promised, ".0e"),
        plain(off, ".0e"),
        judge(off < one.ladder.promised),
        f"`{one.ladder.model}` with {one.ladder.cells[-1]} cells a slab",
    )


def _orders(measured: list[Measured]) -> Table:
    rows: list[tuple[Cell, ...]] = []
    for one in measured:
        grids = f"{one.ladder.cells[0]} to {one.ladder.cells[-1]}"
        rows.append((one.ladder.model, grids, one.ladder.declared, *(one.order(name) for name in _OUTPUTS)))
    orders = (Column(f"order in {symbol}", "", ".2f") for symbol in _OUTPUTS.values())
    columns = (Column("family"), Column("cells"), Column("declared", "", ".2g"), *orders)
    caption = (
        f"Mean orders over the grids. ψ: friction state ln φ at {UNTIL:.0f} transits; T, Δμ, Δy, v_{{max}}: period, stress drop, "
        "elastic drop and largest rate of the last complete cycle before, smooth start at log_{10} r = −2.6. Grids at rounding "
        "are left out; a dash where fewer than three remain."
    )
    return Table("orders", caption, columns, tuple(rows))


def _finest(measured: list[Measured]) -> Table:
    rows: list[tuple[Cell, ...]] = []
    for one in measured:
        errors = (float(one.errors[name][-1]) for name in _OUTPUTS)
        rows.append((one.ladder.model, float(one.ladder.cells[-1]), 1e3 * float(one.seconds[-1]), *errors))
    columns = (
        Column("family"),
        Column("cells", "a slab", ".0f"),
        Column("run", "ms", ".0f"),
        *(Column(f"error of {symbol}", "absolute" if name == "psi" else "relative", ".0e") for name, symbol in _OUTPUTS.items()),
    )
    return Table("finest", f"Errors on each family’s finest grid, and the time of {UNTIL:.0f} transits.", columns, tuple(rows))


def _curves(measured: list[Measured]) -> dict[str, tuple[Array, Array, Array]]:
    """By family: degrees of freedom per slab, seconds, error of psi."""
    return {
        one.ladder.model: (
            np.array(one.ladder.cells) * _points_per_cell(one.ladder.model),
            one.seconds,
            np.abs(one.errors["psi"]),
        )
        for one in measured
    }


def _points_per_cell(model: str) -> int:
    name, _, number = model.partition(":")
    return {"fem": int(number or 1), "dg": int(number or 0) + 1}.get(name, 1)


_CAPTION = (
    f"Error of the friction state ψ after {UNTIL:.0f} transits at log_{{10}} r = −2.6, smooth start, against the delay system: "
    "left over points per slab, right over run time. Numbers after a family’s name are its order (summation by parts) or "
    "polynomial degree (finite elements, discontinuous Galerkin)."
)
