"""The grids' own periodic orbits against the delay system's: on finer grids at one r, and on one grid as r grows."""

import math
from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

import slipwave as sw
from validation.report import WITNESS, Verdict, at_least, claim
from validation.report.known import declared_order, error_after

APPROACHES = "The grid’s own orbit approaches the delay system’s at the declared order or faster"
AGREES = "Discretisations of the wave agree with the delay system on the orbit’s period and stress drop"
MEANS = "Where the motion is irregular, means of T and Δμ of the full wave are the delay system’s"
QUANTITIES = {"period": ("T", 1e-12), "stress_drop": ("Δμ", 5e-12)}
"""The figures, their symbols, and relative errors, at the level of rounding, below which no order is fitted."""

_AT, _TOLERANCE = -2.68, 1e-11
_WAVE, _CELLS = "dg:7", 6
_UNTIL, _ERRORS = 10000.0, 4.0  # transits; standard errors
_NEAR_ONSET = {"start.size": 2.0}  # a small nudge grows for thousands of transits


class GridOrbit(NamedTuple):
    """Relative errors of the figures of a grid's own orbit against the delay system's."""

    model: str
    log10_r: float
    cells: int
    errors: dict[str, float]


def grid_orbits(model: str, ladder: Iterable[int], log10_r: float = _AT) -> list[GridOrbit]:
    """Orbits on every grid."""
    exact, *others = (_figures(name, log10_r, cells) for name, cells in (("delay", None), *((model, cells) for cells in ladder)))
    errors = ({name: abs(one[name] / exact[name] - 1.0) for name in QUANTITIES} for one in others)
    return [GridOrbit(model, log10_r, cells, off) for cells, off in zip(ladder, errors, strict=True)]


def _figures(model: str, log10_r: float, cells: int | None) -> dict[str, Any]:
    near = _NEAR_ONSET if log10_r < -2.697 else {}
    return sw.orbit("paper", model, cells=cells, tol=_TOLERANCE, **{"slab.log10_r": log10_r}, **near).summary


def orbit_order(orbits: list[GridOrbit], quantity: str) -> float:
    """Mean order from the coarsest grid to the finest one whose error is above the floor."""
    errors = [(one.cells, one.errors[quantity]) for one in orbits]
    above = [pair for pair in errors if pair[1] > QUANTITIES[quantity][1]]
    (coarse, first), (fine, last) = errors[0], above[-1] if len(above) > 1 else errors[1]
    return math.log(first / last) / math.log(fine / coarse)


def orbit_verdict(orbits: list[GridOrbit]) -> Verdict:
    """The order of the errors on finer and finer grids."""
    least = min(orbit_order(orbits, quantity) for quantity in QUANTITIES)
    where = f"`{orbits[0].model}`, {orbits[0].cells} to {orbits[-1].cells} cells a slab; the lower of T and Δμ"
    return at_least(APPROACHES, WITNESS, least, declared_order(orbits[0].model), where)


def agreement_verdicts(orbits: list[GridOrbit]) -> Iterator[Verdict]:
    """The errors on the finest grid, below twice what the declared order leaves of those on the one before."""
    before, last = orbits[-2:]
    where = f"`{last.model}` with {last.cells} cells, log_{{10}} r = {last.log10_r:g}".replace("-", "−")
    for name, (symbol, _) in QUANTITIES.items():
        limit = error_after(last.model, before.errors[name], before.cells, last.cells) + _TOLERANCE
        yield claim(AGREES, WITNESS, last.errors[name], limit, f"{symbol}, {where}")


def as_r_grows(log10_r: float) -> list[GridOrbit]:
    """Orbits of the full wave, stable or not, at another r."""
    return grid_orbits(_WAVE, (_CELLS - 1, _CELLS), log10_r)


def means_verdict(log10_r: float) -> Verdict:
    """Means of the full wave and of the delay system over the cycles of a run, by their standard errors."""
    (wave, known), (delay, others) = (means_of(model, log10_r) for model in (_WAVE, "delay"))
    off = max(2.0 * abs(wave[name] - delay[name]) / math.hypot(known[name], others[name]) for name in QUANTITIES)
    return claim(MEANS, WITNESS, off, _ERRORS, f"log_{{10}} r = −{-log10_r:g}; the larger of both", unit="standard errors")


def means_of(model: str, log10_r: float) -> tuple[dict[str, float], dict[str, float]]:
    """Means of the figures over the cycles of a long run, and their margins (95 %)."""
    options: dict[str, Any] = {"cells": _CELLS} if model == _WAVE else {"tol": 1e-7}
    found = sw.run("paper", model, until=_UNTIL, **options, **{"slab.log10_r": log10_r}).summary
    return {name: found[name]["mean"] for name in QUANTITIES}, {name: found["margins"][name] for name in QUANTITIES}
