"""Outer faces that reflect a part of each wave: grips, which keep the load, and bare coefficients, which leak it."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

import slipwave
from slipwave.friction.ageing import Ageing
from slipwave.solve import follow
from validation.chart import BLUE, DASHED, DOTTED, GUIDE, Chart, Look, Panel, Scale, Trace
from validation.measure import memo
from validation.models.build import build
from validation.models.by_name import explicit_time
from validation.models.settle import NoCycle
from validation.report import Budget, Figure, Number, StudyAnswer, StudyResult
from validation.report.text import plain
from validation.report.verdict import ASYMPTOTIC, EXACT, WITNESS, Verdict, claim, every, holding

NAME = "partial-reflection"
QUESTION = "What do outer faces that reflect only a part of each wave do to stick-slip?"
SCENES = ("paper",)
SECONDS = (5.0, 12.0)

LOG10_R, LOG10_R_BARE = -2.6, -2.66
"""log10 r of the runs with grips alone, and of those with bare coefficients."""
HELD = 10.0
"""Stiffness of the grips compared with bare coefficients."""
UNTIL = 900.0
"""Transits after which the two models are compared."""
WAVE = "dg:7"
RESTLESS = 1e-2
"""Largest relative change from cycle to cycle of an orbit."""

_TOLERANCE, _MOST = 1e-9, 5000.0
_CELLS, _PROMISED = 8, 5e-10  # of the full wave
_OUTLIVES = 3.0  # the threshold, times the period, may lie between 1/3 and this


class Point(NamedTuple):
    """Period, stress drop and largest rate; NaN where there is no cycle."""

    period: float = math.nan
    drop: float = math.nan
    v_max: float = math.nan


Pairs = Mapping[tuple[float, float], tuple[float, float]]
"""Stiffness and impedance of grips -> psi at UNTIL by the delay system and by the full wave."""

STIFFNESSES = (1.0, 10.0)
_LEAKS = {
    True: (1e-5, 1e-3, 3e-3, 6e-3, 0.02, 0.1, 0.5),
    False: (1e-5, 1e-4, 3e-4, *(1e-3 * n for n in range(1, 9)), 0.01, 0.02, 0.05, 0.1, 0.15, 0.25, 0.5, 1.0),
}
"""Quick report -> values of 1 - R."""
_SLOW_LEAKS = (0.05, 0.1, 0.15, 0.25, 0.5)  # 1 - R on both sides of locking


def run(budget: Budget) -> StudyResult:
    """Settle over the grip's impedance, compare with the full wave, then lower a bare coefficient from 1."""
    grid = np.geomspace(0.01, 100.0, 9 if budget.quick else 17)
    orbits = {stiff: [settled_cycle_of(grip_scene(stiff, z, LOG10_R)) for z in grid] for stiff in STIFFNESSES}
    budget.report(0.4)
    few = (0.01, 1.0, 100.0) if budget.quick else tuple(grid[::4].tolist())
    pairs = {(k, z): states_in_grips(k, z) for k in STIFFNESSES for z in few}
    budget.report(0.6)
    leaks = _LEAKS[budget.quick]
    bare = [settled_cycle_of(bare_scene(leak)) for leak in leaks]
    held = [settled_cycle_of(grip_scene(HELD, 2.0 / leak - 1.0, LOG10_R_BARE)) for leak in leaks]
    ends = [
        end_of(bare_scene(leak)) if math.isnan(point.period) else "stick-slip" for leak, point in zip(leaks, bare, strict=True)
    ]
    scene = slipwave.read("paper")
    law: Ageing = scene.law
    # beyond this 1 - R the leak, a dashpot (eps/2)(1 + R)/(1 - R), is weaker than friction's weakening (b - a)/V
    edge = 2.0 / (1.0 + 2.0 * (law.b - law.a) / (scene.velocity * scene.upper.epsilon))
    slow = {leak: end_of(bare_scene(leak, nudge=0.01)) for leak in _SLOW_LEAKS}
    return StudyResult(
        answers=_answers(leaks, ends, held),
        figures=(
            Figure("grip", _GRIP, lambda: over_grip(grid, orbits)),
            Figure("bare", _BARE, lambda: bare_and_grip(np.array(leaks), bare, held, edge)),
        ),
        verdicts=(
            *agreement(pairs),
            dies(leaks, ends, bare[0].period),
            keeps(leaks, held),
            locks(slow, edge),
        ),
        notes=(
            "A locked interface returns each wave whole, the outer face returns the share R of it. Behind a bare coefficient the "
            "load therefore falls by the factor R every transit, to 1/e in about 1/(1 − R) transits. Stick-slip needs a load "
            "that lasts for a period.",
        ),
        numbers={f"grip {k:g}, Z_{{g}}/ε = 1: T": Number(orbits[k][len(grid) // 2].period, _TOLERANCE) for k in STIFFNESSES},
    )


def _answers(leaks: tuple[float, ...], ends: list[str], held: list[Point]) -> tuple[StudyAnswer, ...]:
    alive, dead = last_alive(leaks, ends)
    kept = sum(not math.isnan(point.period) for point in held)
    return (
        StudyAnswer(
            f"Grips keep the cycle at {kept} of {len(held)} reflections tried, down to R = {1.0 - max(leaks):g}; bare "
            f"coefficients, which leak the load, end it between 1 − R = {plain(alive, '.0e')} and {plain(dead, '.0e')}.",
            ("Slabs in grips", "Grips of the same reflection", "Behind bare coefficients", "A face that leaks faster"),
        ),
    )


_GRIP = (
    "Period and stress drop over the impedance of grips of two stiffnesses K (in ε a transit), log_{10} r = −2.6, delay system, "
    "settled (a gap: no cycle). Z_{g} = ε absorbs every wave."
)
_BARE = (
    "Period, stress drop and largest rate over 1 − R, log_{10} r = −2.66: bare coefficients, which leak the load, and grips of "
    "the same high-frequency reflection, which keep it. Dotted: 1 − R beyond which the interface locks instead of sliding on."
)

_LOOKS = (Look(), Look(BLUE, DASHED))


def over_grip(grid: np.ndarray, orbits: Mapping[float, Sequence[Point]]) -> Chart:
    """`orbits`: stiffness -> points over `grid`."""
    panels = []
    for name, label in (("period", "period $T$ (transits)"), ("drop", r"stress drop $\Delta\mu$")):
        traces = [
            Trace(f"grips of stiffness $K = {k:g}$", grid, [getattr(point, name) for point in points], look.but(marker="."))
            for (k, points), look in zip(orbits.items(), _LOOKS, strict=True)
        ]
        panels.append(Panel("", Scale(r"$Z_g/\epsilon$", "log"), Scale(label, limits=(0.0, None)), traces, grid=True))
    return Chart(panels, 3.8, 2, legend="outside upper left", legend_columns=2)


def bare_and_grip(leaks: np.ndarray, bare: Sequence[Point], held: Sequence[Point], edge: float) -> Chart:
    """Points over `leaks` = 1 - R; the interface locks beyond `edge`."""
    panels, names = [], ("bare coefficient $R$", "grip of the same reflection")
    guide = Trace("", (edge, edge), (-np.inf, np.inf), GUIDE.but(dashes=DOTTED))
    for which, label in enumerate(("period $T$ (transits)", r"stress drop $\Delta\mu$", r"$v_{max}/V^*$")):
        each = zip(names, (bare, held), _LOOKS, ("o", "^"), strict=True)
        traces = [
            Trace(name, leaks, [point[which] for point in points], look.but(marker=marker, size=4.0))
            for name, points, look, marker in each
        ]
        panels.append(Panel("", Scale("$1 - R$", "log"), Scale(label, limits=(0.0, None)), [guide, *traces], grid=True))
    return Chart(panels, 3.4, 3, legend="outside upper left", legend_columns=2)


def grip_scene(stiffness: float, impedance: float, log10_r: float) -> slipwave.Scene:
    """The paper's slabs in grips, relative to epsilon a transit and epsilon."""
    face = {"slab.face.kind": "grip", "slab.face.stiffness": stiffness, "slab.face.impedance": float(impedance)}
    return slipwave.read("paper", {"slab.log10_r": log10_r, **face})


def bare_scene(leak: float, nudge: float = 0.5) -> slipwave.Scene:
    """The paper's slabs behind faces of R = 1 - `leak`."""
    face = {"slab.face.kind": "reflection", "slab.face.coefficient": 1.0 - leak}
    return slipwave.read("paper", {"slab.log10_r": LOG10_R_BARE, "start.size": nudge, **face})


def settled_cycle_of(scene: slipwave.Scene) -> Point:
    """The settled cycle of the delay system, NaN if there is none."""
    try:
        found = memo.settled("delay", scene, _TOLERANCE, most=_MOST)
    except NoCycle:
        return Point()
    orbit = found.orbit
    return Point(orbit.period.value, orbit.stress_drop.value, orbit.v_max.value) if found.unrest < RESTLESS else Point()


def states_in_grips(stiffness: float, impedance: float) -> tuple[float, float]:
    """psi = ln phi at UNTIL by the delay system and by the full wave."""
    scene = grip_scene(stiffness, impedance, LOG10_R)
    wave = build(WAVE, scene, cells=_CELLS, time=explicit_time(WAVE))
    return follow(build("delay", scene, tolerance=1e-11), UNTIL).psi, follow(wave, UNTIL).psi


def end_of(scene: slipwave.Scene) -> str:
    """How a run without a cycle ends: `steady` if v has returned to V, `locks` if it has fallen far below."""
    behind = follow(build("delay", scene), _MOST).ln_v - math.log(scene.velocity)
    return "steady" if abs(behind) < 0.1 else "locks" if behind < -1.0 else "still decaying"


def last_alive(leaks: tuple[float, ...], ends: list[str]) -> tuple[float, float]:
    """Largest 1 - R that still sticks and slips (0 if none does), and the next one (infinite if there is none)."""
    alive = max((i for i, end in enumerate(ends) if end == "stick-slip"), default=-1)
    around = (0.0, *leaks, math.inf)
    return around[alive + 1], around[alive + 2]


def agreement(pairs: Pairs) -> Iterator[Verdict]:
    """Delay system and full wave on grips."""
    title = f"Slabs in grips: ψ({UNTIL:.0f}) of the delay system and of the full wave, `{WAVE}`, agree"
    for (stiffness, impedance), (exact, wave) in pairs.items():
        remark = f"K = {stiffness:g} ε a transit, Z_{{g}}/ε = {impedance:.3g}"
        yield claim(title, WITNESS, wave - exact, _PROMISED, remark)


def dies(leaks: tuple[float, ...], ends: list[str], period: float) -> Verdict:
    """Where bare coefficients end the cycle, whose `period` (transits) is that of the least leak."""
    alive, dead = last_alive(leaks, ends)
    lives = math.sqrt(alive * dead) * period
    return holding(
        "Behind bare coefficients stick-slip lasts only while the load outlives the cycle",
        ASYMPTOTIC,
        f"ends at (1 − R) T between 1/{_OUTLIVES:g} and {_OUTLIVES:g}",
        f"{lives:.2f}",
        1.0 / _OUTLIVES < lives < _OUTLIVES,
        f"1 − R between {alive:g} and {dead:g}, T = {period:.1f} transits with almost no leak; delay system",
    ).with_margin(abs(math.log(lives)) if lives > 0.0 else math.inf, math.log(_OUTLIVES))


def keeps(leaks: tuple[float, ...], held: list[Point]) -> Verdict:
    """Whether grips of the same reflection keep it."""
    lost = [f"{leak:g}" for leak, point in zip(leaks, held, strict=True) if math.isnan(point.period)]
    title = "Grips of the same reflection keep the stick-slip that bare coefficients lose"
    remark = f"stiffness {HELD:g} ε a transit, Z_{{g}}/ε = (1 + R)/(1 − R); delay system"
    remark += f"; none at 1 − R = {', '.join(lost)}" if lost else ""
    return every(title, WITNESS, len(held) - len(lost), len(held), remark, "R")


def locks(slow: dict[float, str], edge: float) -> Verdict:
    """Whether runs behind bare coefficients lock beyond the `edge` and only there."""
    right = sum(end == ("locks" if leak > edge else "steady") for leak, end in slow.items())
    return every(
        "A face that leaks faster than friction weakens lets the interface lock",
        EXACT,
        right,
        len(slow),
        f"beyond 1 − R = {edge:.4f}; {', '.join(f'{leak:g}: {end}' for leak, end in slow.items())}; "
        "(ε/2)(1 + R)/(1 − R) = (b − a)/V there. Start: a nudge of 0.01; a large one locks the interface at a somewhat smaller 1 "
        "− R",
    )
