"""The grids' own periodic orbits against the delay system's: on finer grids at one r, and on one grid as r grows."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple, TypeAlias

from slipwave.observe.statistics import Estimate, mean_of
from slipwave.scene import Scene
from validation.compute.models import grid_of
from validation.study import WITNESS, Table, Verdict, claim, holding, table
from validation.study.known import error_after
from validation.study.memo import late_cycles, own_orbit
from validation.study.over_r import begun_at, scene_at
from validation.study.text import plain

_AT = -2.68
_TOLERANCE = 1e-11
_FLOOR = {"period": 1e-12, "stress_drop": 5e-12}
"""Relative errors, at the level of rounding, below which no order is fitted."""

_WAVE, _WAVE_CELLS = "dg:7", 6
_UNTIL = 10000.0  # transits
_ERRORS = 4.0  # standard errors

Figures: TypeAlias = tuple[Estimate, Estimate]
"""Period and stress drop."""


FAMILIES: dict[bool, dict[str, tuple[int, ...]]] = {
    True: {"dg:7": (2, 3), "fem:4": (5, 8)},
    False: {"dg:7": (2, 3, 4, 5, 6), "fem:4": (5, 8, 12, 16, 24), "sbp:6": (24, 32, 48, 64, 96, 160)},
}
"""By quick or full report and family: cells per slab."""

ORBITS_AT: dict[bool, tuple[float, ...]] = {True: (), False: (-2.699, -2.66, -2.65)}
MEANS_AT: dict[bool, tuple[float, ...]] = {True: (), False: (-2.5, -2.3)}
"""By quick or full report: log10 r at which the full wave is compared, from the onset on."""


class GridOrbit(NamedTuple):
    """Relative errors of period and stress drop of a grid's own orbit against the delay system's."""

    model: str
    cells: int
    period: float
    stress_drop: float


class OnBoth(NamedTuple):
    """Period and stress drop of the full wave and of the delay system at one r: of their orbits, which may be `allowed` so much
    apart, or, with so many `cycles`, means over runs with standard errors."""

    log10_r: float
    wave: Figures
    delay: Figures
    cycles: int = 0
    allowed: float = _ERRORS

    @property
    def apart(self) -> float:
        """The largest relative difference; of means, in standard errors."""
        if not self.cycles:
            return max(_errors(self.wave, self.delay))
        pairs = zip(self.wave, self.delay, strict=True)
        return max(abs(one.value - other.value) / math.hypot(one.error, other.error) for one, other in pairs)


def grid_orbits(families: Mapping[str, tuple[int, ...]]) -> list[GridOrbit]:
    """Orbits on every grid, family by family."""
    exact = _orbit("delay", scene_at(_AT))
    grids = [(model, cells) for model, ladder in families.items() for cells in ladder]
    return [GridOrbit(model, cells, *_errors(_orbit(model, scene_at(_AT), cells), exact)) for model, cells in grids]


def _orbit(model: str, scene: Scene, cells: int | None = None) -> Figures:
    found = own_orbit(model, scene, _TOLERANCE, cells).orbit
    return found.period, found.stress_drop


def _errors(ours: Figures, exact: Figures) -> tuple[float, float]:
    period, drop = (abs(one.value / other.value - 1.0) for one, other in zip(ours, exact, strict=True))
    return period, drop


def as_r_grows(orbits_at: Iterable[float], means_at: Iterable[float]) -> list[OnBoth]:
    """The full wave and the delay system: orbits, stable or not, and means where the motion is irregular."""
    started = [(log10_r, begun_at(log10_r)) for log10_r in orbits_at]
    return [*(_beside(log10_r, scene) for log10_r, scene in started), *(_means(log10_r) for log10_r in means_at)]


def _beside(log10_r: float, scene: Scene) -> OnBoth:
    coarse, wave = (_orbit(_WAVE, scene, cells) for cells in (_WAVE_CELLS - 1, _WAVE_CELLS))
    exact = _orbit("delay", scene)
    left = error_after(_WAVE, max(_errors(coarse, exact)), _WAVE_CELLS - 1, _WAVE_CELLS)
    return OnBoth(log10_r, wave, exact, allowed=left + _TOLERANCE)


def _means(log10_r: float) -> OnBoth:
    wave, delay = (
        late_cycles(model, scene_at(log10_r), _UNTIL, cells) for model, cells in ((_WAVE, _WAVE_CELLS), ("delay", None))
    )
    ours, exact = ((mean_of(one.period), mean_of(one.stress_drop)) for one in (wave, delay))
    return OnBoth(log10_r, ours, exact, min(wave.period.size, delay.period.size))


def finest(orbits: list[GridOrbit]) -> dict[str, float]:
    """Family -> the larger error of period and stress drop on the finest grid."""
    return {one.model: max(one.period, one.stress_drop) for one in orbits}


def orbit_order(family: list[GridOrbit], quantity: str) -> float:
    """Mean order from the coarsest grid to the finest one whose error is above the floor."""
    errors = [(one.cells, getattr(one, quantity)) for one in family]
    above = [pair for pair in errors if pair[1] > _FLOOR[quantity]]
    (coarse, first), (fine, last) = errors[0], above[-1] if len(above) > 1 else errors[1]
    return math.log(first / last) / math.log(fine / coarse)


def orbit_verdicts(orbits: Sequence[GridOrbit], families: Iterable[str]) -> Iterator[Verdict]:
    """Verdicts on the order of the errors of each family, and on the errors on the finest grid."""
    approaches = "The grid’s own orbit approaches the delay system’s at the declared order or faster"
    agree = "Discretisations of the wave agree with the delay system on the orbit’s period and stress drop"
    for model in families:
        members, number = grid_of(model)
        declared, family = members.order_interface(number), [one for one in orbits if one.model == model]
        period, drop = (orbit_order(family, quantity) for quantity in _FLOOR)
        where = f"`{model}`, {family[0].cells} to {family[-1].cells} cells a slab"
        ours = f"{period:.2g} in T, {drop:.2g} in Δμ"
        found = holding(approaches, WITNESS, f"{declared} or more", ours, min(period, drop) >= declared, where)
        yield found.with_margin(declared / min(period, drop), 1.0)
        where = f"`{model}` with {family[-1].cells} cells a slab, log_{{10}} r = −{-_AT:g}"
        before, last = family[-2:]
        for symbol, coarse, fine in zip(("T", "Δμ"), before[2:], last[2:], strict=True):
            limit = error_after(model, coarse, before.cells, last.cells) + _TOLERANCE
            yield claim(agree, WITNESS, fine, limit, f"{symbol}, {where}")


def growth_verdicts(compared: list[OnBoth]) -> Iterator[Verdict]:
    """The full wave as r grows: orbits, and means where the motion is irregular."""
    orbits, means = [one for one in compared if not one.cycles], [one for one in compared if one.cycles]
    if orbits:
        title = "The full wave’s own orbit is the delay system’s as r grows, where it is unstable too"
        off, allowed = (max(getattr(one, name) for one in orbits) for name in ("apart", "allowed"))
        yield claim(title, WITNESS, off, allowed, f"T and Δμ, {_where(orbits)}")
    if means:
        off = max(one.apart for one in means)
        title = "Where the motion is irregular, means of T and Δμ of the full wave are the delay system’s"
        yield claim(title, WITNESS, off, _ERRORS, _where(means), unit="standard errors")


def _where(some: list[OnBoth]) -> str:
    values = ", ".join(f"{one.log10_r:g}" for one in some)
    return f"`{_WAVE}` with {_WAVE_CELLS} cells, log_{{10}} r = {values}".replace("-", "−")


def grid_orbit_table(orbits: list[GridOrbit]) -> Table:
    """Errors of every grid's orbit."""
    caption = (
        "Relative errors of the grid’s own periodic orbit against the delay system’s, both by Newton’s method, at log_{10} r = "
        f"−{-_AT:g} of the paper’s material; the grid is marched exactly in time."
    )
    return table("orbits", caption, "family | cells [a slab] .0f | error of T .0e | error of Δμ .0e", orbits)


def growth_table(compared: list[OnBoth]) -> Table:
    """The full wave and the delay system as r grows."""
    rows = []
    for one in compared:
        (period, drop), (exact_period, exact_drop) = one.wave, one.delay
        apart = f"{one.apart:.1f} standard errors" if one.cycles else plain(one.apart, ".0e")
        rows.append((one.log10_r, period.value, exact_period.value, drop.value, exact_drop.value, apart, one.cycles or None))
    heading = (
        f"log_{{10}} r .3f | T [{_WAVE}] .8g | T [delay] .8g | Δμ [{_WAVE}] .6f | Δμ [delay] .6f | apart | cycles of a run .0f"
    )
    caption = (
        f"The full wave, `{_WAVE}` with {_WAVE_CELLS} cells a slab, against the delay system: periodic orbits, relative "
        "difference of T or Δμ; or, where the motion is irregular, means over so many cycles of runs."
    )
    return table("growth", caption, heading, rows)
