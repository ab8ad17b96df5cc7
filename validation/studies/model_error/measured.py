"""Orbits of every reduction and of the delay system, means where no orbit is stable, and what the errors of both must show."""

import math
from collections.abc import Callable, Iterator
from itertools import pairwise, product
from typing import Any, NamedTuple, cast

import numpy as np

from reduced.impedance import reduction_of
from reduced.impedance.fit import exact_impedance
from slipwave.errors import NumericsError
from slipwave.observe.pieces import Array
from slipwave.observe.statistics import Estimate
from validation.measure.cycle import watch
from validation.references.onset import onset_of
from validation.registry.build import build
from validation.run.timing import timed
from validation.study import EXACT, PAPER, WITNESS, Verdict, claim, holding, memo
from validation.study.known import as_known, error_of
from validation.study.over_r import begun_at, scene_at
from validation.study.text import places, plain

MODELS = ("block12", "block8", "kelvin-voigt", "modal:1", "modal:2", "modal:4", "modal:8")
DAMPED = "quasidynamic"
"""Slides steadily up to an onset of its own, and has a stable orbit beyond."""
SHOWN = (-2.69, -2.68, -2.66)
"""log10 r of the table of orbits."""
TARGETS = {"modal:1": 1e-3, "modal:2": 1e-5}
"""Model -> largest error of the period of the paper's scene."""
SHORT = (0.35, 0.6)
"""Least and largest share by which the quasi-dynamic period is short beyond its onset."""
RUN_AT = -2.5
"""log10 r of a direct run of the quasi-dynamic model."""
TOLERANCE = 1e-9
TRANSITS, TIMED_AT = 1000.0, -2.68
"""Transits that are timed, and log10 r there."""

_LADDER = ("modal:1", "modal:2", "modal:4", "modal:8")
_REPEATING = ("block12", "block8", "kelvin-voigt", "modal:1")
_PRINTED = 1.0 - 70.73 / 73.5
_HALF_DIGITS = 0.05 / 73.5 + 0.005 / 70.73
_SHIFT, _SAMPLES = 0.2, 400  # of the line on which the impedance is sampled, per transit
_FITTED = 5e-12
_ERRORS = 4.0  # standard errors
_KNOWN = 1e-10  # relative: the error of the other programs' periods
_REPEATS = 1e-6  # relative


class Figures(NamedTuple):
    """Period and stress drop with their errors: of an orbit those of its computation, of a mean its standard error."""

    period: Estimate
    drop: Estimate


Runs = dict[str, dict[float, Figures | None]]
"""model -> log10 r -> its orbit, or its mean; None where it found none."""


def orbit_of(model: str, log10_r: float) -> Figures | None:
    """The model's own orbit by Newton's method; None if it has none."""
    try:
        orbit = memo.own_orbit(model, begun_at(log10_r), TOLERANCE).orbit
    except NumericsError:
        return None
    return Figures(orbit.period, orbit.stress_drop)


def mean_at(model: str, log10_r: float, until: float) -> Figures:
    """Means over the cycles of a run of so many transits, its transient left out."""
    return Figures(*memo.means(model, scene_at(log10_r), until)[:2])


def run_of_damped() -> Figures:
    """Where a direct run of the quasi-dynamic model settles."""
    orbit = memo.settled(DAMPED, scene_at(RUN_AT), TOLERANCE, 1e-9).orbit
    return Figures(orbit.period, orbit.stress_drop)


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


def column(runs: Runs, model: str, quantity: str, part: Callable[[Estimate], float] = lambda one: abs(one.value)) -> Array:
    """A part of the errors of `model` at every r of the delay system, or their sizes."""
    return np.array([part(error(runs, model, log10_r, quantity)) for log10_r in runs["delay"]])


def states(model: str) -> int:
    """Dynamical variables: psi, the elastic stress, v if there is mass, and two for each mode."""
    scene = reduction_of(scene_at(TIMED_AT), model)
    return 2 + (not scene.is_algebraic) + 2 * len(scene.frequencies) + len(scene.relaxations)


def apart(one: Figures | None, other: Figures | None) -> float:
    """The larger relative difference of period and drop; NaN where one is missing."""
    return max(abs(a.value / b.value - 1.0) for a, b in zip(one, other, strict=True)) if one and other else math.nan


def orbit_claims(orbits: Runs) -> Iterator[Verdict]:
    """What the errors of the orbits are at log10 r = -2.68, and that more modes reduce them."""
    for model, limit in TARGETS.items():
        off = abs(error(orbits, model, -2.68, "period").value)
        where = f"`{model}` at log_{{10}} r = −2.68, against the delay system"
        title = "The slabs’ exact modes give the period of the paper’s scene"
        yield holding(title, WITNESS, f"below {plain(limit, '.0e')}", plain(off, ".1e"), off < limit, where)
    short = -error(orbits, "kelvin-voigt", -2.68, "period").value
    yield holding(
        "The paper’s ODE falls short of the exact period by some 4 %",
        PAPER,
        f"{100 * _PRINTED:.1f} %",
        f"{100 * short:.2f} %",
        abs(short - _PRINTED) < _HALF_DIGITS,
        "printed: 70.73 against 73.5 transits, log_{10} r = −2.68; half of the last printed digits is allowed",
    )
    largest = [[float(np.nanmax(column(orbits, model, name))) for model in _LADDER] for name in Figures._fields]
    yield holding(
        "Every doubling of the number of modes reduces the largest error over the range of r",
        WITNESS,
        "falling",
        ", ".join(plain(value, ".0e") for value in largest[0]),
        all(later < sooner for series in largest for sooner, later in pairwise(series)),
        "period (shown) and drop; 1, 2, 4, 8 modes. At a single r the error need not fall, since it changes sign along r",
    )


def mean_claims(means: Runs, orbits_there: dict[str, Figures | None]) -> Iterator[Verdict]:
    """Means of irregular motions against the delay system's, and of cycles that repeat against `orbits_there`, at the least r:
    the figures of an orbit, which Newton's method finds without the run's end."""
    found = [error(means, *one) for one in product(("modal:4", "modal:8"), means["delay"], Figures._fields)]
    off = max(abs(one.value) / one.error for one in found)
    yield holding(
        "Where no orbit is stable, four and eight modes give the delay system’s mean period and mean stress drop",
        WITNESS,
        f"within {_ERRORS:g} standard errors",
        f"within {off:.1f}",
        off < _ERRORS,
        f"the largest of {len(found)} differences, at {places(means['delay'])}",
    )
    first = min(means["delay"])
    differ = {model: apart(means[model][first], orbit) for model, orbit in orbits_there.items()}
    worst = max(differ, key=differ.__getitem__)
    title = "Runs whose cycles repeat have the period and the stress drop of the model’s orbit"
    where = f"{', '.join(f'`{model}`' for model in differ)} at log_{{10}} r = {places([first])}; shown: `{worst}`"
    yield claim(title, WITNESS, differ[worst], _REPEATS, where)


def damped_claims(orbits: Runs, means: Runs, run: Figures) -> Iterator[Verdict]:
    """Where the quasi-dynamic model slides steadily, how short its period is beyond, and that a direct run has it too."""
    onset, every = onset_of_damped(), orbits[DAMPED] | means[DAMPED]
    right = all((found is not None) == (log10_r > onset) for log10_r, found in every.items())
    short = [-error(means, DAMPED, log10_r, "period").value for log10_r in means["delay"]]
    low, high = SHORT
    yield holding(
        "The quasi-dynamic model slides steadily up to its own onset; beyond, its period is about half of the exact one",
        WITNESS,
        f"cycles from log_{{10}} r = {places([onset], '.3f')} on, {100 * low:.0f} to {100 * high:.0f} % short",
        f"{'so it is' if right else 'not so'}; {100 * min(short):.0f} to {100 * max(short):.0f} % short",
        right and low < min(short) and max(short) < high,
        f"onset by the closed form; orbits at {places(every)}, against the delay system’s means",
    )
    title = "A direct run of the quasi-dynamic model settles on the orbit that Newton’s method finds"
    orbit = every[RUN_AT]
    limit = max(map(error_of, run, orbit)) if orbit else math.nan
    yield claim(title, WITNESS, apart(run, orbit), limit, f"T and Δμ at log_{{10}} r = {places([RUN_AT])}")


def known_claims(periods: dict[str, Estimate]) -> Iterator[Verdict]:
    """Periods at log10 r = -2.68 against those of other programs, and of a fit against those of as many modes."""
    yield as_known(periods, -2.68, _KNOWN)
    fit, modes = (periods.get(model, Estimate(math.nan, 0.0)).value for model in ("fitted:4", "modal:4"))
    title = "A fit of the impedance of alike slabs has the orbit of as many exact modes"
    yield claim(title, WITNESS, fit / modes, _KNOWN, "T of `fitted:4` and `modal:4` at log_{10} r = −2.68", near=1.0)


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
    title = "A rational fit of the exact impedance of alike slabs finds their modes"
    remark = f"poles (per transit) and residues of AAA against spring and modes of `{model}`, which knows them in closed form"
    return claim(title, EXACT, float(off), _FITTED, remark)


def no_modes() -> Verdict:
    """A reduction without modes is the block that stands for a slab at low frequency."""
    none, block = (reduction_of(scene_at(-2.68), model) for model in ("modal:0", "block12"))
    same = none.mass == block.mass and not none.frequencies and none.damping == block.damping
    return holding("No mode at all is the ρh/12 block", EXACT, "the same equations", "same" if same else "not", same)


def all_verdicts(orbits: Runs, means: Runs) -> tuple[Verdict, ...]:
    """In the order of the page."""
    periods = {model: orbit.period for model, by_r in orbits.items() if (orbit := by_r.get(-2.68))}
    repeating = {model: orbit_of(model, min(means["delay"])) for model in _REPEATING}
    of_means = (*mean_claims(means, repeating), *damped_claims(orbits, means, run_of_damped()))
    return (*orbit_claims(orbits), *of_means, *known_claims(periods), fitted_modes("fitted:4"), no_modes())
