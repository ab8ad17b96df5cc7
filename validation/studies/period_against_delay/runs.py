"""Periods over the delay: orbits of branches, of Newton's method from runs, and means over the cycles of long runs."""

from typing import NamedTuple

from reduced.orbit.approach import approach
from reduced.orbit.closing import Closed, close
from reduced.orbit.multipliers import count_unstable
from slipwave.observe.statistics import Estimate
from validation.measure.correlated import mean_of
from validation.measure.cycle import watch
from validation.measure.settle import settle
from validation.registry.build import build
from validation.registry.orbits import moving
from validation.studies.period_against_delay.law import MASSES
from validation.study.over_r import Branch, scene_at

WAVES = ("kelvin-voigt", "delay")
"""Models with reverberations; their orbits lose stability."""

_TOLERANCE = 1e-8
_TRANSIENT = 1500.0


class Periods(NamedTuple):
    """At one r, by model (transits): periods of all `orbits` found, with the least number of unstable multipliers among them; and
    where none of these is stable, the mean over the cycles of a run, with the number of its cycles."""

    log10_r: float
    orbits: dict[str, list[float]]
    unstable: dict[str, int]
    means: dict[str, Estimate]
    cycles: dict[str, int]

    def range_of(self, model: str) -> tuple[float, float]:
        """Lowest and highest period, two standard errors of a mean included."""
        mean = self.means.get(model)
        ends = [mean.value - 2.0 * mean.error, mean.value + 2.0 * mean.error] if mean else []
        values = [*self.orbits.get(model, []), *ends]
        return min(values), max(values)


def periods_at(log10_r: float, branches: dict[str, Branch], until: float) -> Periods:
    """All models at one r; runs last `until` (transits)."""
    closed = {model: branches[model].orbits_at(log10_r) for model in WAVES} | {model: [orbit(model, log10_r)] for model in MASSES}
    orbits = {model: [one.cycle.period for one in found] for model, found in closed.items() if found}
    unstable = {model: min(count_unstable(one) for one in found) for model, found in closed.items() if found}
    runs = {model: run(model, log10_r, until) for model in WAVES if unstable.get(model, 1)}
    means, cycles = {model: mean for model, (mean, _) in runs.items()}, {model: count for model, (_, count) in runs.items()}
    return Periods(log10_r, orbits, unstable, means, cycles)


def orbit(model: str, log10_r: float) -> Closed:
    """The orbit that a run comes near to, by Newton's method."""
    known = moving(model, scene_at(log10_r), _TOLERANCE)
    return close(*approach(known.solver, known.freeze)[:3])


def run(model: str, log10_r: float, until: float) -> tuple[Estimate, int]:
    """Mean period of the cycles of a run after its transient, and their number."""
    periods = watch(build(model, scene_at(log10_r), tolerance=1e-7), until).events(_TRANSIENT).period
    return mean_of(periods), periods.size


def settled_period(model: str, log10_r: float) -> float:
    """The period on which a direct run settles."""
    return settle(build(model, scene_at(log10_r), tolerance=1e-10), tolerance=1e-9).orbit.period.value
