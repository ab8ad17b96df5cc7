"""Periods over the delay: orbits of branches, of Newton's method from runs, and means over the cycles of long runs; the paper's
order, the known periods, runs on the orbits, the law of thick slabs."""

import math
from collections.abc import Iterator
from typing import NamedTuple

import slipwave
from reduced.orbit.closing import Closed
from reduced.orbit.multipliers import count_unstable
from validation.references.onset import onset_of
from validation.references.published import half_digit, reference
from validation.studies.period_against_delay.law import MASSES
from validation.study import ASYMPTOTIC, EXACT, PAPER, WITNESS, Verdict, claim, holding, memo
from validation.study.known import PeriodRanges, order_of_periods
from validation.study.over_r import Branch, scene_at
from validation.study.text import minus

WAVES = ("kelvin-voigt", "delay")
"""Models with reverberations; their orbits lose stability."""

_TOLERANCE = 1e-8
_ONSET = 1e-12  # the onset is bracketed to 1e-13
_KNOWN = 1e-9  # the error of the other programs' periods
_SETTLED = 1e-9  # orbits of branches to their own tolerance
_THICK = 0.025


class Periods(NamedTuple):
    """At one r, by model (transits): periods of all `orbits` found, and where none of these is stable, the mean over the cycles
    of a run, with the number of its cycles."""

    log10_r: float
    orbits: dict[str, list[float]]
    means: dict[str, memo.Means]

    @property
    def ranges(self) -> PeriodRanges:
        """Lowest and highest period, two standard errors of a mean included."""
        ode, delay, *blocks = map(self._range, (*WAVES, *MASSES))
        return PeriodRanges(self.log10_r, ode, delay, (min(low for low, _ in blocks), max(high for _, high in blocks)))

    def _range(self, model: str) -> tuple[float, float]:
        mean = self.means.get(model)
        ends = [mean.period.value + share * mean.period.error for share in (-2.0, 2.0)] if mean else []
        values = [*self.orbits.get(model, []), *ends]
        return min(values), max(values)


def periods_at(log10_r: float, branches: dict[str, Branch], until: float) -> Periods:
    """All models at one r; runs last `until` (transits)."""
    closed = {model: branches[model].orbits_at(log10_r) for model in WAVES} | {model: [orbit(model, log10_r)] for model in MASSES}
    orbits = {model: [one.cycle.period for one in found] for model, found in closed.items() if found}
    unstable = [model for model in WAVES if all(count_unstable(one) for one in closed[model])]
    return Periods(log10_r, orbits, {model: memo.means(model, scene_at(log10_r), until) for model in unstable})


def orbit(model: str, log10_r: float) -> Closed:
    """The orbit that a run comes near to, by Newton's method."""
    return memo.own_orbit(model, scene_at(log10_r), _TOLERANCE).closed


def settled_period(model: str, log10_r: float) -> float:
    """The period on which a direct run settles."""
    return memo.settled(model, scene_at(log10_r), 1e-10, 1e-9).orbit.period.value


def order(listed: list[Periods]) -> Verdict:
    """P7 over the whole range of r."""
    means = sum(bool(one.means) for one in listed)
    remark = (
        f"all orbits that are known at an r, stable or not; at {means} r, where no orbit of a model is stable, also the mean "
        "over a long run, with two standard errors"
    )
    return order_of_periods([one.ranges for one in listed], remark)


def known(listed: list[Periods]) -> Iterator[Verdict]:
    """The periods that the paper prints at log10 r = -2.68, and those that other programs found."""
    paper, here = reference()["paper"], next(one for one in listed if one.log10_r == -2.68)
    pairs = {model: (here.orbits[model][0], paper[name]) for model, name in (("kelvin-voigt", "T_ode"), ("delay", "T_dde"))}
    yield holding(
        "The paper’s periods at log_{10} r = −2.68 lie on the curves",
        PAPER,
        ", ".join(f"{printed:g} ({model})" for model, (_, printed) in pairs.items()),
        ", ".join(f"{ours:.4f}" for ours, _ in pairs.values()),
        all(abs(ours - printed) <= half_digit(printed) for ours, printed in pairs.values()),
        "half of the last printed digit is allowed",
    ).with_margin(max(abs(ours - printed) / half_digit(printed) for ours, printed in pairs.values()), 1.0)
    off = [
        abs(one.orbits[model][0] / entry["period"] - 1.0)
        for model in (*WAVES, *MASSES)
        for entry in reference()["orbits"][model]
        for one in listed
        if one.log10_r == entry["log10_r"] and model in one.orbits
    ]
    remark = f"{len(off)} orbits of four models, against AUTO-07p, variational shooting and lifted shooting"
    yield claim("Periods are those of other programs", WITNESS, max(off), _KNOWN, remark)


def settled(listed: list[Periods], runs: dict[tuple[str, float], float]) -> Verdict:
    """Direct runs where orbits are stable."""
    at = {one.log10_r: one for one in listed}
    off = max(abs(period / at[log10_r].orbits[model][0] - 1.0) for (model, log10_r), period in runs.items())
    places = ", ".join(f"{model} at {log10_r:g}".replace(" -", " −") for model, log10_r in runs)
    return claim("Direct runs settle on these periods", WITNESS, off, _SETTLED, f"relative difference of T; {places}")


def at_onset(branches: dict[str, Branch]) -> Verdict:
    """Where the curves begin, against the closed forms."""
    scene = slipwave.read("paper")
    closed = onset_of(scene.law, scene.upper.epsilon, scene.velocity)
    critical = {"delay": closed.r_delay, "kelvin-voigt": closed.r_kelvin_voigt}
    off = [abs(branches[model].onset.period * closed.omega_c * r / (2.0 * math.pi) - 1.0) for model, r in critical.items()]
    remark = "relative; roots of the characteristic equation against ω_{c} (20) and r_{c} (27), (39)"
    return claim("The curves begin with T = 2π/(ω_{c} r_{c})", EXACT, max(off), _ONSET, remark)


def thick(ratios: dict[str, dict[float, float]]) -> Verdict:
    """The law for thick slabs: T over it, by model and log10 r."""
    places = list(ratios["block8"])
    began, ended = (max(abs(found[place] - 1.0) for found in ratios.values()) for place in (places[0], places[-1]))
    where = minus(f"relative difference at log_{{10}} r = {places[-1]:g}; it is {began:.3f} at {places[0]:g}")
    title = "The blocks’ periods approach the law T = Δy/(εV) with the full overshoot as the slabs become thick"
    return claim(title, ASYMPTOTIC, ended, _THICK, f"{where}. No number of the law is fitted")
