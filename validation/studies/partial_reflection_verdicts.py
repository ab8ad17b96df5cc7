"""What cycles behind grips and bare coefficients must show."""

import math

from validation.report.text import plain
from validation.studies.partial_reflection_runs import HELD, Pair, Point
from validation.study import Evidence, Verdict, judge

_PROMISED = 1e-8


def last_alive(leaks: tuple[float, ...], ends: list[str]) -> tuple[float, float]:
    """Largest 1 - R that still sticks and slips, and the next one."""
    alive = max(i for i, end in enumerate(ends) if end == "stick-slip")
    return leaks[alive], leaks[alive + 1]


def agreement(pairs: list[Pair]) -> Verdict:
    """Delay system and full wave on grips."""
    off = max(pair.difference for pair in pairs)
    return Verdict(
        "Slabs in grips: delay system and full wave agree",
        Evidence.WITNESS,
        plain(_PROMISED, ".0e"),
        plain(off, ".0e"),
        judge(off < _PROMISED),
        "period, drop and largest rate of the last complete cycle; `dg:7`",
    )


def dies(leaks: tuple[float, ...], ends: list[str]) -> Verdict:
    """Where bare coefficients end the cycle."""
    alive, dead = last_alive(leaks, ends)
    period = 77.0
    return Verdict(
        "Behind bare coefficients stick-slip lasts only while the load outlives the cycle",
        Evidence.ASYMPTOTIC,
        f"dies near or below 1 − R = 1/T = {1.0 / period:.3f}",
        f"between {alive:g} and {dead:g}",
        judge(alive < 1.0 / period and dead < 3.0 / period),
        "T = 77 transits behind rigid faces; delay system",
    )


def keeps(leaks: tuple[float, ...], held: list[Point]) -> Verdict:
    """Whether grips of the same reflection keep it."""
    lost = [leak for leak, one in zip(leaks, held, strict=True) if math.isnan(one.period)]
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
        "(ε/2)(1 + R)/(1 − R) = (b − a)/V there. From a nudge of 0.01; a large one locks the interface somewhat sooner",
    )
