"""The grids' own periodic orbits against the delay system's: on finer and finer grids at one r, and on one grid as r grows."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple, TypeAlias

from slipwave.observe.statistics import Estimate
from slipwave.scene import Scene
from validation.compute.models import grid_of
from validation.measure.correlated import mean_of
from validation.study import WITNESS, Table, Verdict, claim, holding, table
from validation.study.memo import late_cycles, own_orbit
from validation.study.over_r import begun_at, scene_at
from validation.study.text import plain

_AT = -2.68
_TOLERANCE = 1e-11
_FLOOR = {"period": 1e-12, "stress_drop": 5e-12}
"""Relative errors below which an order is no longer read: rounding errors are left."""

_WAVE, _WAVE_CELLS = "dg:7", 6
_UNTIL = 10000.0  # transits
_APART = 5e-10  # 4e-11 was measured
_ERRORS = 4.0  # standard errors

Figures: TypeAlias = tuple[Estimate, Estimate]
"""Period and stress drop."""


class Grids(NamedTuple):
    """Cells per slab, and the errors allowed in period and stress drop on the finest."""

    cells: tuple[int, ...]
    allowed: tuple[float, float]


FAMILIES: dict[bool, dict[str, Grids]] = {
    True: {"dg:7": Grids((2, 3), (1e-11, 1e-7)), "fem:4": Grids((5, 8), (3e-10, 1e-7))},
    False: {
        "dg:7": Grids((2, 3, 4, 5, 6), (1e-12, 1e-11)),
        "fem:4": Grids((5, 8, 12, 16, 24), (2e-12, 5e-11)),
        "sbp:6": Grids((24, 32, 48, 64, 96, 160), (2e-11, 1e-10)),
    },
}
"""By quick or full report and family. In the full one 1e-13 and 9e-13, 2e-13 and 3e-12, 2e-12 and 1e-11 were measured on the
finest grids. The drop of sbp:6 falls on with its grid (2e-10, 4e-11, 1e-11, 4e-12 on 96, 128, 160, 192 cells), while rounding
errors of more and more unknowns leave 2e-12 in T."""

ORBITS_AT: dict[bool, tuple[float, ...]] = {True: (), False: (-2.699, -2.66, -2.65)}
MEANS_AT: dict[bool, tuple[float, ...]] = {True: (), False: (-2.5, -2.3)}
"""By quick or full report: log10 r at which the full wave is compared, from the onset on."""


class GridOrbit(NamedTuple):
    """Relative errors of period and stress drop of a grid's own orbit against the delay system's."""

    model: str
    cells: int
    period: float
    stress_drop: float


class Beside(NamedTuple):
    """Period and stress drop of the full wave and of the delay system at one r: of their orbits or, with so many `cycles`, means
    over runs with standard errors."""

    log10_r: float
    wave: Figures
    delay: Figures
    cycles: int = 0

    @property
    def apart(self) -> float:
        """The largest relative difference; of means, in standard errors."""
        if not self.cycles:
            return max(_errors(self.wave, self.delay))
        pairs = zip(self.wave, self.delay, strict=True)
        return max(abs(one.value - other.value) / math.hypot(one.error, other.error) for one, other in pairs)


def grid_orbits(families: Mapping[str, Grids]) -> list[GridOrbit]:
    """Orbits on every grid, family by family."""
    exact = _orbit("delay", scene_at(_AT))
    grids = [(model, cells) for model, grid in families.items() for cells in grid.cells]
    return [GridOrbit(model, cells, *_errors(_orbit(model, scene_at(_AT), cells), exact)) for model, cells in grids]


def _orbit(model: str, scene: Scene, cells: int | None = None) -> Figures:
    found = own_orbit(model, scene, _TOLERANCE, cells).orbit
    return found.period, found.stress_drop


def _errors(ours: Figures, exact: Figures) -> tuple[float, float]:
    period, drop = (abs(one.value / other.value - 1.0) for one, other in zip(ours, exact, strict=True))
    return period, drop


def as_r_grows(orbits_at: Iterable[float], means_at: Iterable[float]) -> list[Beside]:
    """The full wave beside the delay system: orbits, stable or not, and means where the motion is irregular."""
    started = [(log10_r, begun_at(log10_r)) for log10_r in orbits_at]
    orbits = [Beside(log10_r, _orbit(_WAVE, scene, _WAVE_CELLS), _orbit("delay", scene)) for log10_r, scene in started]
    return [*orbits, *(_means(log10_r) for log10_r in means_at)]


def _means(log10_r: float) -> Beside:
    wave, delay = (
        late_cycles(model, scene_at(log10_r), _UNTIL, cells) for model, cells in ((_WAVE, _WAVE_CELLS), ("delay", None))
    )
    ours, exact = ((mean_of(one.period), mean_of(one.stress_drop)) for one in (wave, delay))
    return Beside(log10_r, ours, exact, min(wave.period.size, delay.period.size))


def finest(orbits: list[GridOrbit]) -> dict[str, float]:
    """By family: the larger error of period and stress drop on the finest grid."""
    return {one.model: max(one.period, one.stress_drop) for one in orbits}


def orbit_order(family: list[GridOrbit], quantity: str) -> float:
    """Mean order from the coarsest grid to the finest one whose error is above the floor."""
    errors = [(one.cells, getattr(one, quantity)) for one in family]
    above = [pair for pair in errors if pair[1] > _FLOOR[quantity]]
    (coarse, first), (fine, last) = errors[0], above[-1] if len(above) > 1 else errors[1]
    return math.log(first / last) / math.log(fine / coarse)


def orbit_verdicts(orbits: Sequence[GridOrbit], families: Mapping[str, Grids]) -> Iterator[Verdict]:
    """By family: the order of the errors, and the errors on the finest grid."""
    approaches = "The grid’s own orbit approaches the delay system’s at the declared order or faster"
    agree = "Discretisations of the wave agree with the delay system on the orbit’s period and stress drop"
    for model, grids in families.items():
        members, number = grid_of(model)
        declared, family = members.order_interface(number), [one for one in orbits if one.model == model]
        period, drop = (orbit_order(family, quantity) for quantity in _FLOOR)
        where = f"`{model}`, {family[0].cells} to {family[-1].cells} cells a slab"
        ours = f"{period:.2g} in T, {drop:.2g} in Δμ"
        found = holding(approaches, WITNESS, f"{declared} or more", ours, min(period, drop) >= declared, where)
        yield found.with_margin(declared / min(period, drop), 1.0)
        where = f"`{model}` with {family[-1].cells} cells a slab, log_{{10}} r = −{-_AT:g}"
        for symbol, size, limit in zip(("T", "Δμ"), family[-1][2:], grids.allowed, strict=True):
            yield claim(agree, WITNESS, size, limit, f"{symbol}, {where}")


def growth_verdicts(beside: list[Beside]) -> Iterator[Verdict]:
    """The full wave as r grows: orbits, and means where the motion is irregular."""
    orbits, means = [one for one in beside if not one.cycles], [one for one in beside if one.cycles]
    if orbits:
        title = "The full wave’s own orbit is the delay system’s as r grows, where it is unstable too"
        yield claim(title, WITNESS, max(one.apart for one in orbits), _APART, f"T and Δμ, {_where(orbits)}")
    if means:
        off = max(one.apart for one in means)
        title = "Where the motion is irregular, means of T and Δμ of the full wave are the delay system’s"
        yield claim(title, WITNESS, off, _ERRORS, _where(means), unit="standard errors")


def _where(some: list[Beside]) -> str:
    places = ", ".join(f"{one.log10_r:g}" for one in some)
    return f"`{_WAVE}` with {_WAVE_CELLS} cells, log_{{10}} r = {places}".replace("-", "−")


def grid_orbit_table(orbits: list[GridOrbit]) -> Table:
    """Errors of every grid's orbit."""
    caption = (
        "Relative errors of the grid’s own periodic orbit against the delay system’s, both by Newton’s method, at log_{10} r = "
        f"−{-_AT:g} of the paper’s material; the grid is marched exactly in time."
    )
    return table("orbits", caption, "family | cells [a slab] .0f | error of T .0e | error of Δμ .0e", orbits)


def growth_table(beside: list[Beside]) -> Table:
    """The full wave beside the delay system as r grows."""
    rows = []
    for one in beside:
        (period, drop), (exact_period, exact_drop) = one.wave, one.delay
        apart = f"{one.apart:.1f} standard errors" if one.cycles else plain(one.apart, ".0e")
        rows.append((one.log10_r, period.value, exact_period.value, drop.value, exact_drop.value, apart, one.cycles or None))
    heading = (
        f"log_{{10}} r .3f | T [{_WAVE}] .8g | T [delay] .8g | Δμ [{_WAVE}] .6f | Δμ [delay] .6f | apart | cycles of a run .0f"
    )
    caption = (
        f"The full wave, `{_WAVE}` with {_WAVE_CELLS} cells a slab, beside the delay system: periodic orbits, relative "
        "difference of T or Δμ; or, where the motion is irregular, means over so many cycles of runs."
    )
    return table("growth", caption, heading, rows)
