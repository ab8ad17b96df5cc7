"""Orbits of every reduction and of the delay system, means where no orbit is stable, and what the errors of both must show."""

import math
from collections.abc import Callable, Mapping
from itertools import pairwise, product
from typing import Any, NamedTuple, cast

import numpy as np

from reduced.impedance import reduction_of
from reduced.impedance.fit import exact_impedance
from slipwave.errors import NumericsError
from slipwave.observe.pieces import Array
from slipwave.observe.statistics import Estimate
from validation.measure.correlated import mean_of
from validation.measure.cycle import watch
from validation.measure.settle import settle
from validation.references.onset import onset_of
from validation.registry.build import build
from validation.run.timing import timed
from validation.study import Evidence, Verdict, judge
from validation.study.bounds import bounded
from validation.study.known import as_known
from validation.study.memo import late_cycles, own_orbit
from validation.study.over_r import begun_at, scene_at
from validation.study.text import places, plain

MODELS = ("block12", "block8", "kelvin-voigt", "modal:1", "modal:2", "modal:4", "modal:8")
DAMPED = "quasidynamic"
"""Slides steadily up to an onset of its own, and has a stable orbit beyond."""
SHOWN = (-2.69, -2.68, -2.66)
"""log10 r of the table of orbits."""

TOLERANCE = 1e-9
TRANSITS, TIMED_AT = 1000.0, -2.68
"""Transits that are timed, and log10 r there."""


class Figures(NamedTuple):
    """Period and stress drop with their errors: of an orbit those of its computation, of a mean its standard error."""

    period: Estimate
    drop: Estimate


Runs = dict[str, dict[float, Figures | None]]
"""model -> log10 r -> its orbit, or its mean; None where it found none."""


def orbit_of(model: str, log10_r: float) -> Figures | None:
    """The model's own orbit by Newton's method; None if it has none."""
    try:
        orbit = own_orbit(model, begun_at(log10_r), TOLERANCE).orbit
    except NumericsError:
        return None
    return Figures(orbit.period, orbit.stress_drop)


def mean_at(model: str, log10_r: float, until: float) -> Figures:
    """Means over the cycles of a run of so many transits, its transient left out."""
    cycles = late_cycles(model, scene_at(log10_r), until)
    return Figures(mean_of(cycles.period), mean_of(cycles.stress_drop))


def onset_of_damped() -> float:
    """log10 r from which on the quasi-dynamic model sticks and slips, by its closed form."""
    scene = scene_at(SHOWN[0])
    return math.log10(onset_of(scene.law, scene.upper.epsilon, scene.velocity).r_quasidynamic)


def milliseconds_of(model: str) -> float:
    """Processor time of the transits that are timed."""
    return 1e3 * timed(lambda: watch(build(model, scene_at(TIMED_AT), tolerance=TOLERANCE), TRANSITS))[0]


def error(runs: Runs, model: str, log10_r: float, quantity: str) -> Estimate:
    """Signed relative error of `period` or `drop` against the delay system; NaN where either has none."""
    ours, exact = runs[model].get(log10_r), runs["delay"].get(log10_r)
    if ours is None or exact is None:
        return Estimate(math.nan, math.nan)
    one, other = getattr(ours, quantity), getattr(exact, quantity)
    ratio = one.value / other.value
    return Estimate(ratio - 1.0, ratio * math.hypot(one.error / one.value, other.error / other.value))


def column(runs: Runs, model: str, quantity: str, part: Callable[[Estimate], float]) -> Array:
    """A part of the errors of `model` at every r of the delay system."""
    return np.array([part(error(runs, model, log10_r, quantity)) for log10_r in runs["delay"]])


def sizes(runs: Runs, model: str, quantity: str) -> Array:
    """Absolute errors of `model` at every r of the delay system."""
    return np.abs(column(runs, model, quantity, lambda one: one.value))


def states(model: str) -> int:
    """Dynamical variables: psi, the elastic stress, v if there is mass, and two for each mode."""
    scene = reduction_of(scene_at(TIMED_AT), model)
    return 2 + (not scene.is_algebraic) + 2 * len(scene.frequencies) + len(scene.relaxations)


TARGETS = {"modal:1": 1e-3, "modal:2": 1e-5}
"""Model -> largest error of the period of the paper's scene."""

_LADDER = ("modal:1", "modal:2", "modal:4", "modal:8")
_PRINTED = 1.0 - 70.73 / 73.5
_HALF_DIGITS = 0.05 / 73.5 + 0.005 / 70.73
_SHIFT, _SAMPLES = 0.2, 400  # of the line on which the impedance is sampled, per transit
_FITTED = 5e-12  # 3e-13 was measured
SHORT = (0.35, 0.6)
"""Least and largest share by which the quasi-dynamic period is short beyond its onset; 0.39 to 0.55 were measured."""
RUN_AT = -2.5
"""log10 r of a direct run of the quasi-dynamic model."""
_DAMPED = 2e-9  # relative; 9e-11 was measured
_ERRORS = 4.0  # standard errors; 2.9 were measured, the largest of 24 differences
_KNOWN = 1e-10  # relative; 6e-11 was measured
_REPEATING = ("block12", "block8", "kelvin-voigt", "modal:1")
_REPEATS = 1e-6  # relative


def all_verdicts(orbits: Runs, means: Runs) -> tuple[Verdict, ...]:
    """In the order of the page."""
    periods = {model: orbit.period.value for model, by_r in orbits.items() if (orbit := by_r.get(-2.68))}
    of_runs = (_paper(orbits), _modes(orbits), irregular(means), repeats(means), *damped(orbits, means))
    known = (as_known(periods, -2.68, _KNOWN), _fit(periods))
    return (*(target(orbits, model) for model in TARGETS), *of_runs, *known, fitted_modes("fitted:4"), _no_modes())


def target(runs: Runs, model: str) -> Verdict:
    """Whether `model` keeps its promise at log10 r = -2.68."""
    off, limit = abs(error(runs, model, -2.68, "period").value), TARGETS[model]
    claim = "The slabs’ exact modes give the period of the paper’s scene"
    remark = f"`{model}` at log_{{10}} r = −2.68, against the delay system"
    return Verdict(claim, Evidence.WITNESS, f"below {plain(limit, '.0e')}", plain(off, ".1e"), judge(off < limit), remark)


def _paper(runs: Runs) -> Verdict:
    ours = -error(runs, "kelvin-voigt", -2.68, "period").value
    return Verdict(
        "The paper’s ODE falls short of the exact period by some 4 %",
        Evidence.PAPER,
        f"{100 * _PRINTED:.1f} %",
        f"{100 * ours:.2f} %",
        judge(abs(ours - _PRINTED) < _HALF_DIGITS),
        "printed: 70.73 against 73.5 transits, log_{10} r = −2.68; half of the last printed digits is allowed",
    )


def _modes(runs: Runs) -> Verdict:
    """The largest error over the range of r, for 1, 2, 4 and 8 modes."""
    largest = [[float(np.nanmax(sizes(runs, model, name))) for model in _LADDER] for name in ("period", "drop")]
    falls = all(later < sooner for series in largest for sooner, later in pairwise(series))
    return Verdict(
        "Every doubling of the number of modes reduces the largest error over the range of r",
        Evidence.WITNESS,
        "falling",
        ", ".join(plain(value, ".0e") for value in largest[0]),
        judge(falls),
        "period (shown) and drop; 1, 2, 4, 8 modes. At a single r the error need not fall, since it changes sign along r",
    )


def irregular(means: Runs) -> Verdict:
    """The largest difference of the means with four and with eight modes from the delay system's."""
    pairs = product(("modal:4", "modal:8"), means["delay"], ("period", "drop"))
    found = [error(means, model, log10_r, name) for model, log10_r, name in pairs]
    off = max(abs(one.value) / one.error for one in found)
    return Verdict(
        "Where no orbit is stable, four and eight modes give the delay system’s mean period and mean stress drop",
        Evidence.WITNESS,
        f"within {_ERRORS:g} standard errors",
        f"within {off:.1f}",
        judge(off < _ERRORS),
        f"the largest of {len(found)} differences, at {places(means['delay'])}",
    )


def repeats(means: Runs) -> Verdict:
    """Means of cycles that repeat are the figures of an orbit, which Newton's method finds without the run's end."""
    first = min(means["delay"])
    off = {}
    for model in _REPEATING:
        run, orbit = means[model][first], orbit_of(model, first)
        pairs = ((run.period, orbit.period), (run.drop, orbit.drop)) if run and orbit else ()
        off[model] = max((abs(one.value / other.value - 1.0) for one, other in pairs), default=math.nan)
    worst = max(off, key=off.__getitem__)
    claim = "Runs whose cycles repeat have the period and the stress drop of the model’s orbit"
    remark = f"{', '.join(f'`{model}`' for model in off)} at log_{{10}} r = {places([first])}; shown: `{worst}`"
    return bounded(claim, Evidence.WITNESS, off[worst], _REPEATS, remark)


def _fit(periods: Mapping[str, float]) -> Verdict:
    claim = "A fit of the impedance of alike slabs has the orbit of as many exact modes"
    off = abs(periods["fitted:4"] / periods["modal:4"] - 1.0) if "fitted:4" in periods else math.nan
    return bounded(claim, Evidence.WITNESS, off, _KNOWN, "T of `fitted:4` and `modal:4` at log_{10} r = −2.68")


def damped(orbits: Runs, means: Runs) -> tuple[Verdict, Verdict]:
    """Where the quasi-dynamic model slides steadily, how short its period is beyond, and that a direct run has it too."""
    onset, every = onset_of_damped(), orbits[DAMPED] | means[DAMPED]
    right = all((found is not None) == (log10_r > onset) for log10_r, found in every.items())
    short = [-error(means, DAMPED, log10_r, "period").value for log10_r in means["delay"]]
    orbit, run = every[RUN_AT], settle(build(DAMPED, scene_at(RUN_AT), tolerance=TOLERANCE)).orbit
    pairs = ((run.period, orbit.period), (run.stress_drop, orbit.drop)) if orbit else ()
    off = max((abs(one.value / other.value - 1.0) for one, other in pairs), default=math.nan)
    low, high = SHORT
    return (
        Verdict(
            "The quasi-dynamic model slides steadily up to its own onset; beyond, its period is about half of the exact one",
            Evidence.WITNESS,
            f"cycles from log_{{10}} r = {places([onset], '.3f')} on, {100 * low:.0f} to {100 * high:.0f} % short",
            f"{'so it is' if right else 'not so'}; {100 * min(short):.0f} to {100 * max(short):.0f} % short",
            judge(right and low < min(short) and max(short) < high),
            f"onset by the closed form; orbits at {places(every)}, against the delay system’s means",
        ),
        bounded(
            "A direct run of the quasi-dynamic model settles on the orbit that Newton’s method finds",
            Evidence.WITNESS,
            off,
            _DAMPED,
            f"T and Δμ at log_{{10}} r = {places([RUN_AT])}",
        ),
    )


def fitted_modes(model: str) -> Verdict:
    """The modes of a reduction of alike slabs against the poles and residues of a rational fit of their exact impedance.

    The fit (AAA, Nakatsukasa, Sete and Trefethen 2018) does not know of modes. Its input is Z(s)/epsilon on a line to the right
    of the imaginary axis.
    """
    from scipy import interpolate

    known = reduction_of(scene_at(-2.68), model)
    reach = 2.0 * np.pi * (len(known.frequencies) + 0.5)
    s = np.asarray(_SHIFT + 1j * np.linspace(-reach, reach, _SAMPLES), dtype=np.complex128)
    fit = cast(Any, interpolate).AAA(s, exact_impedance(scene_at(-2.68), s), rtol=1e-12)
    poles, residues = fit.poles(), fit.residues()
    modes = [(0.0, known.spring), *((w, 0.5 * residue) for w, residue in zip(known.frequencies, known.residues, strict=True))]
    nearest = [(int(np.argmin(np.abs(poles - 1j * w))), w, residue) for w, residue in modes]
    off = max(max(abs(poles[k] - 1j * w), abs(residues[k] / residue - 1.0)) for k, w, residue in nearest)
    claim = "A rational fit of the exact impedance of alike slabs finds their modes"
    remark = f"poles (per transit) and residues of AAA against spring and modes of `{model}`, which knows them in closed form"
    return bounded(claim, Evidence.EXACT, float(off), _FITTED, remark)


def _no_modes() -> Verdict:
    none, block = (reduction_of(scene_at(-2.68), model) for model in ("modal:0", "block12"))
    same = none.mass == block.mass and not none.frequencies and none.damping == block.damping
    return Verdict(
        "No mode at all is the ρh/12 block", Evidence.EXACT, "the same equations", "same" if same else "not", judge(same)
    )
