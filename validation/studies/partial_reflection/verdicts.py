"""What cycles behind grips and bare coefficients must show."""

import math

from validation.studies.partial_reflection.runs import HELD, Pair, Point
from validation.study import Evidence, Verdict, judge
from validation.study.bounds import bounded

_PROMISED = {True: 5e-9, False: 5e-10}  # quick report or full; 3e-10 with 8 cells and 2e-11 with 12 were measured
_OUTLIVES = 3.0  # the threshold, times the period, may lie between 1/3 and this; 0.6 was measured


def last_alive(leaks: tuple[float, ...], ends: list[str]) -> tuple[float, float]:
    """Largest 1 - R that still sticks and slips (0 if none does), and the next one (infinite if there is none)."""
    alive = max((i for i, end in enumerate(ends) if end == "stick-slip"), default=-1)
    around = (0.0, *leaks, math.inf)
    return around[alive + 1], around[alive + 2]


def agreement(pairs: list[Pair], quick: bool) -> Verdict:
    """Delay system and full wave on grips."""
    off = max(abs(off) for pair in pairs for off in pair.differences)
    claim = "Slabs in grips: delay system and full wave agree"
    remark = "period, drop and largest rate of the last complete cycle; `dg:7`"
    return bounded(claim, Evidence.WITNESS, off, _PROMISED[quick], remark)


def dies(leaks: tuple[float, ...], ends: list[str], period: float) -> Verdict:
    """Where bare coefficients end the cycle, whose `period` (transits) is that of the least leak."""
    alive, dead = last_alive(leaks, ends)
    lives = math.sqrt(alive * dead) * period
    return Verdict(
        "Behind bare coefficients stick-slip lasts only while the load outlives the cycle",
        Evidence.ASYMPTOTIC,
        f"ends at (1 − R) T between 1/{_OUTLIVES:g} and {_OUTLIVES:g}",
        f"{lives:.2f}",
        judge(1.0 / _OUTLIVES < lives < _OUTLIVES),
        f"1 − R between {alive:g} and {dead:g}, T = {period:.1f} transits with almost no leak; delay system",
    )


def keeps(leaks: tuple[float, ...], held: list[Point]) -> Verdict:
    """Whether grips of the same reflection keep it."""
    lost = [leak for leak, point in zip(leaks, held, strict=True) if math.isnan(point.period)]
    return Verdict(
        "Grips of the same reflection keep the stick-slip that bare coefficients lose",
        Evidence.WITNESS,
        "cycles at every R",
        "cycles at every R" if not lost else f"none at 1 − R = {', '.join(f'{x:g}' for x in lost)}",
        judge(not lost),
        f"stiffness {HELD:g} ε a transit, Z_{{g}}/ε = (1 + R)/(1 − R); delay system",
    )


def locks(slow: dict[float, str], edge: float) -> Verdict:
    """Whether runs behind bare coefficients lock beyond the `edge` and only there."""
    wrong = [leak for leak, end in slow.items() if end != ("locks" if leak > edge else "steady")]
    return Verdict(
        "A face that leaks faster than friction weakens lets the interface lock",
        Evidence.EXACT,
        f"beyond 1 − R = {edge:.4f}",
        ", ".join(f"{leak:g}: {end}" for leak, end in slow.items()),
        judge(not wrong),
        "(ε/2)(1 + R)/(1 − R) = (b − a)/V there. Start: a nudge of 0.01; a large one locks the interface at a somewhat smaller 1 "
        "− R",
    )
