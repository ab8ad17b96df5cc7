"""Outer faces that reflect a part of each wave: grips, which keep the load, and bare coefficients, which leak it."""

import math
from typing import NamedTuple

import numpy as np

import scene
from scene.friction.ageing import Ageing
from scene.observe import EventObserver, follow
from scene.scene import Scene
from validation.models import build
from validation.orbits import NoCycle, settle
from validation.report.text import plain
from validation.studies.partial_reflection_figures import bare_and_grip, over_grip
from validation.study import Budget, Cell, Column, Evidence, Figure, Number, StudyResult, Table, Verdict, judge

NAME = "partial-reflection"
QUESTION = "What do outer faces that reflect only a part of each wave do to stick-slip?"
SCENES = ("paper",)
SECONDS = (5.0, 12.0)

STIFFNESSES = (1.0, 10.0)
_LOG10_R, _LOG10_R_BARE = -2.6, -2.66
_HELD = 10.0  # the grip's stiffness beside bare coefficients
_SLOW_LEAKS = (0.05, 0.1, 0.15, 0.25, 0.5)  # 1 - R on both sides of locking
_UNTIL = 900.0
_PROMISED = 1e-8
_MOST = 5000.0
_RESTLESS = 1e-2  # more than this from cycle to cycle is not an orbit


class Point(NamedTuple):
    """Period, stress drop and largest rate; NaN where there is no cycle."""

    period: float = math.nan
    drop: float = math.nan
    v_max: float = math.nan


class Pair(NamedTuple):
    """The last complete cycle before _UNTIL by the delay system and by the full wave."""

    stiffness: float
    impedance: float
    exact: Point
    wave: Point

    @property
    def difference(self) -> float:
        """Largest relative difference of the three figures."""
        return max(abs(ours / theirs - 1.0) for ours, theirs in zip(self.wave, self.exact, strict=True))


def run(budget: Budget) -> StudyResult:
    """Settle over the grip's impedance, lay the full wave over it, then lower a bare coefficient from 1."""
    grid = np.geomspace(0.01, 100.0, 9 if budget.quick else 17)
    orbits = {stiff: [_orbit(_grip(stiff, z, _LOG10_R)) for z in grid] for stiff in STIFFNESSES}
    budget.report(0.4)
    few = (0.1, 1.0, 10.0) if budget.quick else tuple(grid[::4])
    pairs = [_pair(k, z, budget.quick) for k in STIFFNESSES for z in few]
    budget.report(0.6)
    leaks = _leaks(budget.quick)
    bare = [_orbit(_bare(leak)) for leak in leaks]
    held = [_orbit(_grip(_HELD, 2.0 / leak - 1.0, _LOG10_R_BARE)) for leak in leaks]
    ends = [_end(_bare(leak)) if math.isnan(one.period) else "stick-slip" for leak, one in zip(leaks, bare, strict=True)]
    edge = _locking_leak()
    slow = {leak: _end(_bare(leak, nudge=0.01)) for leak in _SLOW_LEAKS}
    return StudyResult(
        answer=_answer(leaks, ends),
        figures=(
            Figure("grip", _GRIP, lambda: over_grip(grid, orbits, pairs)),
            Figure("bare", _BARE, lambda: bare_and_grip(np.array(leaks), bare, held, edge)),
        ),
        tables=(_wave_table(pairs), _bare_table(leaks, bare, held, ends)),
        verdicts=(_agreement(pairs), _dies(leaks, ends), _keeps(leaks, held), _locks(slow, edge)),
        notes=(
            "A held interface returns each wave whole, the outer face returns R of it: a load behind a bare coefficient falls to "
            "R of itself every transit, to 1/e in 1/(1 − R) transits. Stick-slip needs it to last for several periods.",
        ),
        numbers={f"grip {k:g}, Z_{{g}}/ε = 1: T": Number(orbits[k][len(grid) // 2].period, 1e-7) for k in STIFFNESSES},
    )


def _leaks(quick: bool) -> tuple[float, ...]:
    """Values of 1 - R."""
    if quick:
        return 1e-5, 1e-3, 3e-3, 6e-3, 0.02, 0.1, 0.5
    return 1e-5, 1e-4, 3e-4, 1e-3, 2e-3, 3e-3, 4e-3, 5e-3, 6e-3, 7e-3, 8e-3, 0.01, 0.02, 0.05, 0.1, 0.15, 0.25, 0.5, 1.0


def _grip(stiffness: float, impedance: float, log10_r: float) -> Scene:
    face = {"slab.face.kind": "grip", "slab.face.stiffness": stiffness, "slab.face.impedance": float(impedance)}
    return scene.read("paper", {"slab.log10_r": log10_r, **face})


def _bare(leak: float, nudge: float = 0.5) -> Scene:
    face = {"slab.face.kind": "reflection", "slab.face.coefficient": 1.0 - leak}
    return scene.read("paper", {"slab.log10_r": _LOG10_R_BARE, "start.size": nudge, **face})


def _orbit(what: Scene) -> Point:
    try:
        found = settle(build("delay", what, tolerance=1e-9), tolerance=1e-8, most=_MOST)
    except NoCycle:
        return Point()
    orbit = found.orbit
    return Point(orbit.period.value, orbit.stress_drop.value, orbit.v_max.value) if found.unrest < _RESTLESS else Point()


def _pair(stiffness: float, impedance: float, quick: bool) -> Pair:
    what = _grip(stiffness, impedance, _LOG10_R)
    exact = _last(what, "delay", None, 1e-11)
    return Pair(stiffness, float(impedance), exact, _last(what, "dg:7", 8 if quick else 12, None))


def _last(what: Scene, model: str, cells: int | None, tolerance: float | None) -> Point:
    solver = build(model, what, cells=cells, tolerance=tolerance)
    observer = EventObserver(what, solver.nodes)
    follow(solver, _UNTIL, [observer])
    events = observer.events
    return Point(float(events.period[-1]), float(events.stress_drop[-1]), float(events.v_max[-1]))


def _end(what: Scene) -> str:
    """How a run without a cycle ends: `steady` if v is back at V, `locks` if it has fallen far below."""
    behind = follow(build("delay", what), _MOST).ln_v - math.log(what.velocity)
    return "steady" if abs(behind) < 0.1 else "locks" if behind < -1.0 else "still decaying"


def _locking_leak() -> float:
    """1 - R beyond which the leak, a dashpot (eps/2)(1 + R)/(1 - R), is weaker than friction's weakening (b - a)/V."""
    what = scene.read("paper")
    law: Ageing = what.law
    return 2.0 / (1.0 + 2.0 * (law.b - law.a) / (what.velocity * what.upper.epsilon))


def _last_alive(leaks: tuple[float, ...], ends: list[str]) -> tuple[float, float]:
    """Largest 1 - R that still sticks and slips, and the next one."""
    alive = max(i for i, end in enumerate(ends) if end == "stick-slip")
    return leaks[alive], leaks[alive + 1]


def _answer(leaks: tuple[float, ...], ends: list[str]) -> str:
    alive, dead = _last_alive(leaks, ends)
    return (
        "Grips keep the cycle even where they swallow every wave; bare coefficients end it as soon as the load leaks within a "
        f"few cycles: between 1 − R = {plain(alive, '.0e')} and {plain(dead, '.0e')}."
    )


def _agreement(pairs: list[Pair]) -> Verdict:
    off = max(pair.difference for pair in pairs)
    return Verdict(
        "Slabs in grips: delay system and full wave agree",
        Evidence.WITNESS,
        plain(_PROMISED, ".0e"),
        plain(off, ".0e"),
        judge(off < _PROMISED),
        "period, drop and largest rate of the last complete cycle; `dg:7`",
    )


def _dies(leaks: tuple[float, ...], ends: list[str]) -> Verdict:
    alive, dead = _last_alive(leaks, ends)
    period = 77.0
    return Verdict(
        "Behind bare coefficients stick-slip lasts only while the load outlives the cycle",
        Evidence.ASYMPTOTIC,
        f"dies near or below 1 − R = 1/T = {1.0 / period:.3f}",
        f"between {alive:g} and {dead:g}",
        judge(alive < 1.0 / period and dead < 3.0 / period),
        "T = 77 transits behind rigid faces; delay system",
    )


def _keeps(leaks: tuple[float, ...], held: list[Point]) -> Verdict:
    lost = [leak for leak, one in zip(leaks, held, strict=True) if math.isnan(one.period)]
    return Verdict(
        "Grips of the same reflection keep the stick-slip that bare coefficients lose",
        Evidence.WITNESS,
        "cycles at every R",
        "cycles at every R" if not lost else f"none at 1 − R = {', '.join(f'{x:g}' for x in lost)}",
        judge(not lost),
        f"stiffness {_HELD:g} ε a transit, Z_{{g}}/ε = (1 + R)/(1 − R); delay system",
    )


def _locks(slow: dict[float, str], edge: float) -> Verdict:
    wrong = [leak for leak, end in slow.items() if end != ("locks" if leak > edge else "steady")]
    return Verdict(
        "A face that leaks faster than friction weakens lets the interface lock",
        Evidence.EXACT,
        f"beyond 1 − R = {edge:.4f}",
        ", ".join(f"{leak:g}: {end}" for leak, end in slow.items()),
        judge(not wrong),
        "(ε/2)(1 + R)/(1 − R) = (b − a)/V there. From a nudge of 0.01; a large one locks the interface somewhat sooner",
    )


def _wave_table(pairs: list[Pair]) -> Table:
    rows: list[tuple[Cell, ...]] = []
    for pair in pairs:
        off = (ours / theirs - 1.0 for ours, theirs in zip(pair.wave, pair.exact, strict=True))
        rows.append((pair.stiffness, pair.impedance, *pair.exact, *off))
    figures = (Column("T", "transits", ".9g"), Column("Δμ", "σ", ".7f"), Column("v_{max}", "V*", ".7g"))
    columns = (Column("K", "ε a transit", ".0f"), Column("Z_{g}/ε", "", ".3g"), *figures)
    differences = tuple(Column(f"difference in {name}", "relative", ".0e") for name in ("T", "Δμ", "v_{max}"))
    caption = (
        f"Slabs in grips of stiffness K and impedance Z_{{g}}, log_{{10}} r = −2.6: last complete cycle before {_UNTIL:.0f} "
        "transits by the delay system, and how far discontinuous Galerkin is from it in the same cycle."
    )
    return Table("grips", caption, (*columns, *differences), tuple(rows))


def _bare_table(leaks: tuple[float, ...], bare: list[Point], held: list[Point], ends: list[str]) -> Table:
    rows = tuple((q, end, *one, 2.0 / q - 1.0, *grip) for q, end, one, grip in zip(leaks, ends, bare, held, strict=True))
    figures = (Column("T", "transits", ".6g"), Column("Δμ", "σ", ".5f"), Column("v_{max}", "V*", ".0f"))
    columns = (Column("1 − R", "", ".0e"), Column("bare: ends as"), *figures, Column("grip: Z_{g}/ε", "", ".5g"), *figures)
    caption = (
        "Left: faces with a bare coefficient R, right: grips that reflect the same share of a fast wave, stiffness 10 ε a "
        f"transit; log_{{10}} r = −2.66, delay system. A dash: no cycle that repeats to {plain(_RESTLESS, '.0e')}."
    )
    return Table("bare", caption, columns, rows)


_GRIP = (
    "Period and stress drop over the impedance of grips of two stiffnesses K (in ε a transit), log_{10} r = −2.6. Z_{g} = ε "
    "swallows every wave. Lines: delay system, settled (a gap: no cycle). Circles: full wave (discontinuous "
    f"Galerkin), crosses: delay system, both in the last complete cycle before {_UNTIL:.0f} transits, not settled where it is "
    "long."
)
_BARE = (
    "Period, stress drop and largest rate over 1 − R, log_{10} r = −2.66: bare coefficients, which leak the load, and grips of "
    "the same high-frequency reflection, which keep it. Dotted: 1 − R beyond which the interface locks instead of sliding on."
)
