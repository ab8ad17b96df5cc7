"""Convergence of the leapfrog to the delay system, from a smooth start and from a jump."""

from collections.abc import Iterator, Mapping
from typing import TypeAlias

import numpy as np

import slipwave
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from slipwave.solve import follow
from validation.compute.build import build
from validation.compute.settle import settle
from validation.measure.cycle import SYMBOLS
from validation.measure.order_fit import Fit, fit_order, richardson, shortfall
from validation.study import SELF, WITNESS, Budget, Evidence, Figure, StudyResult, Table, Verdict, claim, stated, table
from validation.study.drawing import Axes, Drawing, subplots
from validation.study.known import ERRORS, of_order
from validation.study.text import plain

NAME = "leapfrog-convergence"
QUESTION = "Does the full wave converge to the delay system, and how fast?"
SCENES = ("paper", "yardstick")
SECONDS = (4.0, 20.0)

CFLS = (0.5, 0.9, 1.0)
_QUICK, _FULL = (48, 96, 192, 384), (48, 96, 192, 384, 768)
_FINAL = 400.0
_SMOOTH, _JUMP = (f"ψ({_FINAL:g}), {start} start" for start in ("smooth", "jump"))
_SETTLED = 5e-13  # relative change of settled periods from run to run

Errors: TypeAlias = dict[str, dict[float, Array]]
"""Signed error (relative for the orbit, absolute for psi) by quantity and CFL, one entry per cell count."""
Fits: TypeAlias = Mapping[str, Mapping[float, Fit]]


def run(budget: Budget) -> StudyResult:
    """Measure every error, fit every order."""
    cells = _QUICK if budget.quick else _FULL
    errors = _measure(cells, budget)
    fits = {name: {cfl: fit_order(np.array(cells), np.abs(errors[name][cfl])) for cfl in CFLS} for name in errors}
    return StudyResult(
        answer=_answer(fits),
        figures=(Figure("ladders", _CAPTION, lambda: ladders(np.array(cells), errors, fits)),),
        tables=(_orders(fits),),
        verdicts=(*_verdicts(fits), *(_extrapolated(errors["period"][cfl], cfl) for cfl in CFLS)),
        notes=(
            "At CFL 1 the leapfrog carries waves without error and *is* the delay system under the midpoint rule: its "
            "agreement is no independent evidence. Below CFL 1 it is a different discretisation of the wave equation.",
        ),
        numbers={
            f"T error, CFL {cfl}, 96 cells": stated(float(errors["period"][cfl][cells.index(96)]), _SETTLED, known=0.0)
            for cfl in CFLS
        },
    )


def _answer(fits: Fits) -> str:
    smooth = [fits[name][cfl].order for name in fits if name != _JUMP for cfl in CFLS]
    jump = [fits[_JUMP][cfl].order for cfl in CFLS]
    return (
        f"{'Yes' if min(smooth + jump) > 0.5 else 'No'}: from the smooth start at orders {min(smooth):.2f} to {max(smooth):.2f} "
        "in every quantity of the orbit and in the final state; from a jump, which returns every transit, at orders "
        f"{min(jump):.2f} to {max(jump):.2f}."
    )


def _measure(cells: tuple[int, ...], budget: Budget) -> Errors:
    smooth, jump = slipwave.read("paper"), slipwave.read("yardstick")
    exact = settle(build("delay", smooth, tolerance=1e-11), tolerance=1e-10).orbit.values()
    finals = {_SMOOTH: (smooth, _psi("delay", smooth)), _JUMP: (jump, _psi("delay", jump))}
    errors: Errors = {name: {} for name in (*SYMBOLS, *finals)}
    for cfl in budget.each(CFLS):
        orbits = [settle(build("fd", smooth, cells=n, cfl=cfl), tolerance=1e-10).orbit.values() for n in cells]
        for name in SYMBOLS:
            errors[name][cfl] = np.array([orbit[name] / exact[name] - 1.0 for orbit in orbits])
        for name, (start, known) in finals.items():
            errors[name][cfl] = np.array([_psi("fd", start, n, cfl) - known for n in cells])
    return errors


def _psi(model: str, start: Scene, cells: int = 0, cfl: float = 0.0) -> float:
    solver = build(model, start, cells=cells, cfl=cfl) if model == "fd" else build(model, start, tolerance=1e-11)
    return follow(solver, _FINAL).psi


def _orders(fits: Fits) -> Table:
    rows = (
        [
            SYMBOLS.get(name, name),
            *(cell for one in some.values() for cell in (f"{one.order:.4f} ± {one.half_width:.4f}", one.finest)),
        ]
        for name, some in fits.items()
    )
    heading = " | ".join(["error in", *(f"order [CFL {cfl}] | finest two .3f" for cfl in CFLS)])
    caption = (
        "Fitted order with its 95 % confidence interval, and the order of the two finest grids alone. T, Δμ, Δy, v_{max}, "
        f"v_{{min}}: the settled orbit at log_{{10}} r = −2.68; ψ({_FINAL:g}): the friction state ln φ after {_FINAL:g} "
        "transits. Coarse grids that do not follow the power law yet are left out by rule."
    )
    return table("orders", caption, heading, rows)


def _verdicts(fits: Fits) -> Iterator[Verdict]:
    smooth = [some for name, some in fits.items() if name != _JUMP]
    for title, outputs, declared in (
        ("Leapfrog: order 2 from the smooth start, in every output", smooth, 2.0),
        ("Leapfrog: order 1 from a jump", [fits[_JUMP]], 1.0),
    ):
        for cfl in CFLS:
            worst = max((some[cfl] for some in outputs), key=lambda fit: (shortfall(fit, declared), abs(fit.order - declared)))
            yield of_order(title, _evidence(cfl), worst, declared, f"CFL {cfl}; shown: the worst output of {len(outputs)}")


def _evidence(cfl: float) -> Evidence:
    """At CFL 1 the leapfrog is the delay system itself."""
    return SELF if cfl == 1.0 else WITNESS


def _extrapolated(errors: Array, cfl: float) -> Verdict:
    """Of the signed `errors` of the period on finer and finer grids: what extrapolation leaves is of order 4, a fifteenth of what
    the last two extrapolations differ by."""
    coarse, middle, fine = map(float, errors[-3:])
    found = richardson(coarse, middle, fine, 2.0)
    title = "Extrapolated to zero cell size, the period of the full wave is that of the delay system"
    remark = f"at CFL {cfl}; without extrapolation, on the finest grid: {plain(abs(fine), '.0e')}"
    return claim(title, _evidence(cfl), found.value, ERRORS / 15.0 * found.error + _SETTLED, remark)


_CAPTION = (
    "Errors of the leapfrog against the delay system, by cells per slab, at three Courant numbers. First five: relative error of "
    f"quantities of the settled orbit; last two: error of the state ψ = ln φ after {_FINAL:g} transits. Thin lines: fits. "
    "Triangles: slope 2, slope 1 for the jump."
)

_TITLES = {
    "period": "period $T$",
    "stress_drop": r"stress drop $\Delta\mu$",
    "elastic_stress_drop": r"elastic drop $\Delta y$",
    "v_max": r"$v_{\max}$",
    "v_min": r"$v_{\min}$",
    _SMOOTH: rf"$\psi({_FINAL:g})$, smooth start",
    _JUMP: rf"$\psi({_FINAL:g})$, jump start",
}
_LOOKS = {0.5: ("#d55e00", "s", "white"), 0.9: ("#0072b2", "D", "#0072b2"), 1.0: ("#111111", "o", "#111111")}


def ladders(cells: Array, errors: Mapping[str, Mapping[float, Array]], fits: Fits) -> Drawing:
    """Log-log panels of error over cells per slab: one per figure of merit, a line per Courant number, the fits and a slope."""
    figure, grid = subplots(4.6, 2, 4, "cells per slab", "error", sharex=True)
    for axes, name in zip(grid.flat, _TITLES, strict=False):
        _panel(axes, cells, errors[name], fits[name])
        axes.set_title(_TITLES[name], fontsize=11)
        _triangle(axes, 1.0 if "jump" in name else 2.0)
    grid[0, 3].tick_params(labelbottom=True)
    grid[0, 0].set_ylabel("relative error")
    lines = grid[0, 0].get_lines()[1::2]
    grid[1, 3].set_axis_off()
    grid[1, 3].legend(lines, [f"CFL {cfl}" for cfl in errors["period"]], loc="center")
    return figure


def _panel(axes: Axes, cells: Array, errors: Mapping[float, Array], fits: Mapping[float, Fit]) -> None:
    for cfl, values in errors.items():
        color, marker, fill = _LOOKS[cfl]
        fitted = fits[cfl]
        used = cells[fitted.used]
        axes.loglog(used, fitted.constant * used**-fitted.order, color=color, linewidth=0.9)
        axes.loglog(cells, np.abs(values), linestyle="none", marker=marker, color=color, markerfacecolor=fill)
    axes.margins(0.12)
    axes.set_xticks(cells, [str(n) for n in cells])
    axes.minorticks_off()


def _triangle(axes: Axes, slope: float) -> None:
    """A right triangle of the given slope in the lower left corner, its hypotenuse parallel to a line of that order."""
    (x0, x1), (y0, y1) = np.log10(axes.get_xlim()), np.log10(axes.get_ylim())
    left, right = x0 + 0.08 * (x1 - x0), x0 + 0.08 * (x1 - x0) + 0.3
    bottom = y0 + 0.08 * (y1 - y0)
    top = bottom + slope * 0.3
    x, y = 10.0 ** np.array([left, right, left, left]), 10.0 ** np.array([top, bottom, bottom, top])
    axes.plot(x, y, color="#777777", linewidth=0.9)
    axes.annotate(
        f"{slope:.0f}", (10**left, 10 ** (0.5 * (top + bottom))), (3, 0), textcoords="offset points", va="center", fontsize=9
    )
