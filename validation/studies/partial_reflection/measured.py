"""Cycles behind grips and bare coefficients: settled, by two models, or how a run without one ends; what they must show."""

import math
from typing import NamedTuple

import slipwave
from slipwave.friction.ageing import Ageing
from slipwave.scene import Scene
from slipwave.solve import follow
from validation.measure.cycle import watch
from validation.measure.settle import NoCycle
from validation.registry.build import build
from validation.registry.families import explicit_time
from validation.study import ASYMPTOTIC, EXACT, WITNESS, Verdict, claim, every, holding, memo

LOG10_R, LOG10_R_BARE = -2.6, -2.66
"""log10 r of the runs with grips alone, and of those with bare coefficients."""
HELD = 10.0
"""Stiffness of the grips beside bare coefficients."""
UNTIL = 900.0
"""Transits before which the two models' last complete cycle is compared."""
RESTLESS = 1e-2
"""More than this from cycle to cycle, relative, is not an orbit."""

_MOST = 5000.0
_PROMISED = {True: 5e-9, False: 5e-10}  # quick report (8 cells) or full (12)
_OUTLIVES = 3.0  # the threshold, times the period, may lie between 1/3 and this


class Point(NamedTuple):
    """Period, stress drop and largest rate; NaN where there is no cycle."""

    period: float = math.nan
    drop: float = math.nan
    v_max: float = math.nan


class Pair(NamedTuple):
    """The last complete cycle before `UNTIL` by the delay system and by the full wave."""

    stiffness: float
    impedance: float
    exact: Point
    wave: Point

    @property
    def differences(self) -> list[float]:
        """Relative differences of the three figures."""
        return [ours / theirs - 1.0 for ours, theirs in zip(self.wave, self.exact, strict=True)]


def grip_scene(stiffness: float, impedance: float, log10_r: float) -> Scene:
    """The paper's slabs in grips, relative to epsilon a transit and epsilon."""
    face = {"slab.face.kind": "grip", "slab.face.stiffness": stiffness, "slab.face.impedance": float(impedance)}
    return slipwave.read("paper", {"slab.log10_r": log10_r, **face})


def bare_scene(leak: float, nudge: float = 0.5) -> Scene:
    """The paper's slabs behind faces of R = 1 - `leak`."""
    face = {"slab.face.kind": "reflection", "slab.face.coefficient": 1.0 - leak}
    return slipwave.read("paper", {"slab.log10_r": LOG10_R_BARE, "start.size": nudge, **face})


def orbit_of(scene: Scene) -> Point:
    """The settled cycle of the delay system, NaN if there is none."""
    try:
        found = memo.settled("delay", scene, most=_MOST)
    except NoCycle:
        return Point()
    orbit = found.orbit
    return Point(orbit.period.value, orbit.stress_drop.value, orbit.v_max.value) if found.unrest < RESTLESS else Point()


def pair_of(stiffness: float, impedance: float, quick: bool) -> Pair:
    """The same cycle by the delay system and by the full wave."""
    scene = grip_scene(stiffness, impedance, LOG10_R)
    exact = last_cycle(scene, "delay", None, 1e-11)
    return Pair(stiffness, float(impedance), exact, last_cycle(scene, "dg:7", 8 if quick else 12, None))


def last_cycle(scene: Scene, model: str, cells: int | None, tolerance: float | None) -> Point:
    """The last complete cycle of a run to `UNTIL`."""
    march = None if model == "delay" else explicit_time(model)
    events = watch(build(model, scene, cells=cells, tolerance=tolerance, time=march), UNTIL).events()
    return Point(float(events.period[-1]), float(events.stress_drop[-1]), float(events.v_max[-1]))


def end_of(scene: Scene) -> str:
    """How a run without a cycle ends: `steady` if v is back at V, `locks` if it has fallen far below."""
    behind = follow(build("delay", scene), _MOST).ln_v - math.log(scene.velocity)
    return "steady" if abs(behind) < 0.1 else "locks" if behind < -1.0 else "still decaying"


def locking_leak() -> float:
    """1 - R beyond which the leak, a dashpot (eps/2)(1 + R)/(1 - R), is weaker than friction's weakening (b - a)/V."""
    scene = slipwave.read("paper")
    law: Ageing = scene.law
    return 2.0 / (1.0 + 2.0 * (law.b - law.a) / (scene.velocity * scene.upper.epsilon))


def last_alive(leaks: tuple[float, ...], ends: list[str]) -> tuple[float, float]:
    """Largest 1 - R that still sticks and slips (0 if none does), and the next one (infinite if there is none)."""
    alive = max((i for i, end in enumerate(ends) if end == "stick-slip"), default=-1)
    around = (0.0, *leaks, math.inf)
    return around[alive + 1], around[alive + 2]


def agreement(pairs: list[Pair], quick: bool) -> Verdict:
    """Delay system and full wave on grips."""
    off = max(abs(off) for pair in pairs for off in pair.differences)
    remark = "period, drop and largest rate of the last complete cycle; `dg:7`"
    return claim("Slabs in grips: delay system and full wave agree", WITNESS, off, _PROMISED[quick], remark)


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
