"""The ODE's unstable orbit beside its doubled one (the paper's Fig 7), and the bubble of doubled orbits between two doublings."""

import math
from collections.abc import Iterable

import numpy as np

from reduced.continuation.point import OrbitPoint
from reduced.orbit import PeriodicOrbit
from slipwave.observe.pieces import Array
from validation.studies.period_doubling import measured
from validation.studies.period_doubling.measured import AT, NEAR, TOLERANCE, Bubble, Doubled
from validation.study import Budget, Cell, Figure, Number, Omission, StudyResult, Table, stated, table
from validation.study.branch_drawing import MARKS
from validation.study.drawing import WIDTH, Drawing, canvas, line, ruled
from validation.study.text import places, plain, power

NAME = "period-doubling"
QUESTION = "What becomes of the paper’s ODE where its orbit loses stability by period doubling?"
SCENES = ("paper",)
SECONDS = (10.0, 24.0)

_PAIRS = ((-2.571, -2.535), (-2.5375, -2.47))
"""log10 r on both sides of the other pairs of period doublings."""


def run(budget: Budget) -> StudyResult:
    """Find both orbits, and follow both branches to the period doublings; then the other pairs."""
    found = measured.doubled()
    budget.report(0.3)
    others = [] if budget.quick else [measured.bubble(*ends) for ends in _PAIRS]
    return StudyResult(
        answer=_answer(found),
        figures=(Figure("planes", _CAPTION, lambda: planes(found, others), paper="Fig 7", carries=("P10 ",)),),
        tables=(orbit_table(found), *([bubble_table(others)] if others else [])),
        verdicts=(*measured.all_verdicts(found), *map(measured.ends_simple, others)),
        notes=(_HOW,),
        numbers={
            "T": stated(found.single.orbit.period.value, found.single.orbit.period.error),
            "doubled T": stated(found.double.orbit.period.value, found.double.orbit.period.error),
            "multiplier": Number(float(found.single.multipliers.values[0].real), 1e-7),
            "doubled multiplier": Number(float(found.double.multipliers.values[0].real), 1e-6),
        },
        omissions=(_OTHERS,) if budget.quick else (),
    )


def _answer(found: Doubled) -> str:
    low, high = sorted(one.point.parameter for one in found.special)
    return (
        f"Its orbit is unstable from log_{{10}} r = {low:.7f} to {high:.7f}. A stable orbit of twice the period is born at "
        "one end and vanishes at the other."
    ).replace("-", "−")


_CAPTION = (
    f"The ODE’s orbits at log_{{10}} r = {AT:.6f}, the paper’s Fig 7: the unstable one of T = 79.09 transits (dotted) and the "
    "stable one of twice the period. Above: slip rate over time, each over its own period, as in the paper; middle: two planes; "
    "below: periods of the single orbits over r and, between the two period doublings, half the "
    "periods of the doubled ones; in the full report those of the other two pairs too."
).replace("= -", "= −")
_HOW = (
    "Both orbits come from Newton’s method on the motion over one or two cycles; it began from a run that passes the unstable "
    "orbit and settles on the doubled one. The branch of doubled orbits is followed in both directions until their largest "
    f"multiplier exceeds {NEAR:g}; a straight line takes it to 1."
)
_OTHERS = Omission("The other two pairs of period doublings.", "The quick report does not follow their doubled orbits.", ("P9 ",))


_DOUBLE = "#d55e00"
_THIN = (0, (1.5, 1.2))
_TEN = math.log(10.0)
_EVERY = 4  # nodes of a step, of which one is drawn


def orbit_table(found: Doubled) -> Table:
    """Figures and leading multipliers of both orbits."""
    rows: list[tuple[Cell, ...]] = [
        (name, *orbit.orbit.values().values(), ", ".join(plain(float(one.real), ".5f") for one in orbit.multipliers.values[:2]))
        for name, orbit in (("single", found.single), ("doubled", found.double))
    ]
    heading = "orbit | T [transits] .9f | Δμ [σ] .10f | Δy [σ] .10f | v_{max} [V*] .4f | v_{min} [V*] .8f | multipliers"
    caption = f"Both orbits of the ODE at log_{{10}} r = {places([AT], '.6f')}; relative errors are below {power(TOLERANCE)}."
    return table("orbits", caption, heading, rows)


def bubble_table(bubbles: Iterable[Bubble]) -> Table:
    """The other bubbles, with the special points of their doubled orbits."""
    rows = [(one.born, one.ends, _places(one, "PD"), _places(one, "LP")) for one in bubbles]
    heading = "born at [log_{10} r] .9f | ends at [log_{10} r] .6f | doubles again at [log_{10} r] | turns at [log_{10} r]"
    return table("bubbles", "Branches of doubled orbits of the other two pairs of period doublings.", heading, rows)


def _places(bubble: Bubble, kind: str) -> str:
    return ", ".join(f"{place:.7f}" for name, place in bubble.special if name == kind).replace("-", "−") or "–"


def planes(found: Doubled, others: Iterable[Bubble] = ()) -> Drawing:
    """The paper's Fig 7: both orbits in two planes; below, T and half the doubled period over r."""
    figure = canvas(WIDTH, 8.4)
    grid = figure.subplot_mosaic([["rate", "rate"], ["stress", "state"], ["branch", "branch"]], height_ratios=(0.8, 1.2, 1.0))
    single = line("kelvin-voigt", linestyle=_THIN, linewidth=1.2, label="T = 79.09, unstable")
    double = line("kelvin-voigt", color=_DOUBLE, linestyle="-", linewidth=0.9, label="doubled orbit, stable")
    for orbit, look in ((found.double, double), (found.single, single)):
        time, rate, stress, state = _curves(orbit)
        grid["rate"].plot(time / time[-1], rate, **look)
        grid["stress"].plot(rate, stress, **look)
        grid["state"].plot(rate, state, **look)
    grid["rate"].set(xlabel="time over the period of each orbit", ylabel=r"$\log_{10} v$")
    grid["stress"].set(xlabel=r"$\log_{10} v$", ylabel=r"$\mu$")
    grid["state"].set(xlabel=r"$\log_{10} v$", ylabel=r"$\log_{10}\phi$")
    axes = grid["branch"]
    ends = sorted(one.point.parameter for one in found.special)
    for stable in (True, False):
        r, period = _periods(found.primary, 1.0)
        period[(r > ends[0]) & (r < ends[-1]) if stable else (r < ends[0]) | (r > ends[-1])] = np.nan
        axes.plot(r, period, color=single["color"], linestyle="-" if stable else _THIN, linewidth=1.3)
    axes.plot(*_periods(found.bubble, 0.5), color=_DOUBLE, linewidth=1.3)
    for other in others:
        axes.plot(*np.array(other.points).T, color=_DOUBLE, linewidth=1.3)
    places = [[one.point.parameter, one.point.closed.cycle.period] for one in found.special]
    axes.plot(*np.array(places).T, MARKS["PD"], color=single["color"], markerfacecolor="white", label="period doubling")
    axes.set(xlabel=r"$\log_{10} r$", ylabel="$T$, half of the doubled $T$")
    ruled(*grid.values())
    handles = [*grid["stress"].get_lines(), axes.get_lines()[-1]]
    figure.legend(handles=handles, loc="outside upper left", ncols=3, handlelength=2.6)
    return figure


def _periods(points: list[OrbitPoint], share: float) -> tuple[Array, Array]:
    """log10 r and a share of the period along a branch."""
    return np.array([point.parameter for point in points]), share * np.array([point.closed.cycle.period for point in points])


def _curves(orbit: PeriodicOrbit) -> list[Array]:
    """Time from the event's fastest moment on, log10 v, mu and log10 phi at some nodes of an orbit's steps, over one period."""
    pieces, nodes = orbit.closed.cycle.pieces, orbit.closed.flow.nodes
    time = pieces.time[:, None] + pieces.length[:, None] * nodes
    columns = [values[:, _EVERY - 1 :: _EVERY].ravel() for values in (time, pieces.z / _TEN, pieces.mu, pieces.psi / _TEN)]
    return [columns[0] - columns[0][0], *columns[1:]]
