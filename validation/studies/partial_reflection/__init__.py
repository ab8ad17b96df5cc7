"""Outer faces that reflect a part of each wave: grips, which keep the load, and bare coefficients, which leak it."""

import math

import numpy as np

from validation.studies.partial_reflection.runs import (
    HELD,
    LOG10_R,
    LOG10_R_BARE,
    UNTIL,
    Point,
    bare_scene,
    end_of,
    grip_scene,
    locking_leak,
    orbit_of,
    pair_of,
)
from validation.studies.partial_reflection.shown import bare_and_grip, bare_table, over_grip, wave_table
from validation.studies.partial_reflection.verdicts import agreement, dies, keeps, last_alive, locks
from validation.study import Budget, Figure, Number, StudyResult
from validation.study.text import plain

NAME = "partial-reflection"
QUESTION = "What do outer faces that reflect only a part of each wave do to stick-slip?"
SCENES = ("paper",)
SECONDS = (5.0, 12.0)

STIFFNESSES = (1.0, 10.0)
_SLOW_LEAKS = (0.05, 0.1, 0.15, 0.25, 0.5)  # 1 - R on both sides of locking


def run(budget: Budget) -> StudyResult:
    """Settle over the grip's impedance, lay the full wave over it, then lower a bare coefficient from 1."""
    grid = np.geomspace(0.01, 100.0, 9 if budget.quick else 17)
    orbits = {stiff: [orbit_of(grip_scene(stiff, z, LOG10_R)) for z in grid] for stiff in STIFFNESSES}
    budget.report(0.4)
    few = (0.1, 1.0, 10.0) if budget.quick else tuple(grid[::4])
    pairs = [pair_of(k, z, budget.quick) for k in STIFFNESSES for z in few]
    budget.report(0.6)
    leaks = _leaks(budget.quick)
    bare = [orbit_of(bare_scene(leak)) for leak in leaks]
    held = [orbit_of(grip_scene(HELD, 2.0 / leak - 1.0, LOG10_R_BARE)) for leak in leaks]
    ends = [
        end_of(bare_scene(leak)) if math.isnan(point.period) else "stick-slip" for leak, point in zip(leaks, bare, strict=True)
    ]
    edge = locking_leak()
    slow = {leak: end_of(bare_scene(leak, nudge=0.01)) for leak in _SLOW_LEAKS}
    return StudyResult(
        answer=_answer(leaks, ends, held),
        figures=(
            Figure("grip", _GRIP, lambda: over_grip(grid, orbits, pairs)),
            Figure("bare", _BARE, lambda: bare_and_grip(np.array(leaks), bare, held, edge)),
        ),
        tables=(wave_table(pairs), bare_table(leaks, bare, held, ends)),
        verdicts=(agreement(pairs, budget.quick), dies(leaks, ends, bare[0].period), keeps(leaks, held), locks(slow, edge)),
        notes=(
            "A locked interface returns each wave whole, the outer face returns the share R of it. Behind a bare coefficient the "
            "load therefore falls by the factor R every transit, to 1/e in about 1/(1 − R) transits. Stick-slip needs a load "
            "that lasts for a period.",
        ),
        numbers={f"grip {k:g}, Z_{{g}}/ε = 1: T": Number(orbits[k][len(grid) // 2].period, 1e-7) for k in STIFFNESSES},
    )


def _leaks(quick: bool) -> tuple[float, ...]:
    """Values of 1 - R."""
    if quick:
        return 1e-5, 1e-3, 3e-3, 6e-3, 0.02, 0.1, 0.5
    return 1e-5, 1e-4, 3e-4, 1e-3, 2e-3, 3e-3, 4e-3, 5e-3, 6e-3, 7e-3, 8e-3, 0.01, 0.02, 0.05, 0.1, 0.15, 0.25, 0.5, 1.0


def _answer(leaks: tuple[float, ...], ends: list[str], held: list[Point]) -> str:
    alive, dead = last_alive(leaks, ends)
    kept = sum(not math.isnan(point.period) for point in held)
    return (
        f"Grips keep the cycle at {kept} of {len(held)} reflections tried, down to R = {1.0 - max(leaks):g}; bare coefficients, "
        f"which leak the load, end it between 1 − R = {plain(alive, '.0e')} and {plain(dead, '.0e')}."
    )


_GRIP = (
    "Period and stress drop over the impedance of grips of two stiffnesses K (in ε a transit), log_{10} r = −2.6. Z_{g} = ε "
    "absorbs every wave. Lines: delay system, settled (a gap: no cycle). Circles: full wave (discontinuous "
    f"Galerkin), crosses: delay system, both in the last complete cycle before {UNTIL:.0f} transits, which is not settled "
    "where cycles are long."
)
_BARE = (
    "Period, stress drop and largest rate over 1 − R, log_{10} r = −2.66: bare coefficients, which leak the load, and grips of "
    "the same high-frequency reflection, which keep it. Dotted: 1 − R beyond which the interface locks instead of sliding on."
)
