"""Explains a run's motion, and what would change it, by the stability of steady sliding."""

import math
from typing import TYPE_CHECKING

from reduced.parameters import scaled
from slipwave.friction.law import friction_slopes
from slipwave.observe.verdict import REPEATING
from slipwave.scene import Scene
from validation.models.outlook import expected_period
from validation.models.run import Run

if TYPE_CHECKING:
    from reduced.stability import Stability

_TOGETHER = ", both slabs scaled together,"
PREFIXES = {9: "G", 6: "M", 3: "k", 0: "", -3: "m", -6: "u", -9: "n"}


def reasons(run: Run, model: str) -> list[str]:
    """Lines on the verdict of a run whose motion does not repeat: why it slides steadily, decays, grows or has no cycles.
    `model`: one with the one-port of the model that ran."""
    verdict, scene = run.verdict, run.solver.scene
    if verdict is None or verdict.kind in ("driven", "protocol", *REPEATING) or scene.drive.velocities[-1] == 0.0:
        return []
    from reduced.stability.analyse import analyse  # imported here to keep the start of other runs fast

    final = scene if scene.drive.is_constant else scaled(scene, velocity=scene.drive.velocities[-1])
    analysis = analyse(final, model)
    changes = [f"it changes by a factor e in {_time(1.0 / abs(verdict.rate), scene)}"] if math.isfinite(verdict.rate) else []
    cycles = list[str]()
    if verdict.kind == "too short" and not analysis.stable:
        period = expected_period(scene)
        endless = math.isinf(period)
        hardly = "no cycle is expected: the drive hardly loads the interface"
        cycles = [hardly if endless else f"a cycle is expected to take about {_time(period, scene)}"]
    return [
        *changes,
        *cycles,
        on_stability(final, analysis),
    ]


def on_stability(scene: Scene, analysis: "Stability") -> str:
    """Text: whether steady sliding of `scene`, of stability `analysis`, is stable, and what would change that."""
    if not friction_slopes(scene.law, scene.velocity).weakening:
        known = scene.law._asdict()
        equal = " (a >= b)" if "a" in known and "b" in known and known["a"] >= known["b"] else ""
        return f"steady sliding is always stable: friction does not weaken with the slip rate{equal}"
    word = {True: "stable", False: "unstable", None: "neutral"}[analysis.stable]
    if analysis.stable is None:
        return f"steady sliding is {word}"
    within = 1.0 / abs(analysis.rate * scene.transit)
    change = f"a disturbance {'decays' if analysis.stable else 'grows'} by a factor e in {_time(within, scene)}"
    return "; ".join(filter(None, [f"steady sliding is {word}", change, _what_would_change(scene, analysis)]))


def _what_would_change(scene: Scene, analysis: "Stability") -> str:
    """Text: the thickness or normal stress, or r or epsilon, beyond which the stability changes; empty if there is none, or at
    neutral stability."""
    from reduced.stability.analyse import stability_in_si

    physical = stability_in_si(scene, analysis)
    if physical is not None and scene.units is not None:
        slabs = "slabs" if scene.alike else f"an upper slab{_TOGETHER}"
        limits = [
            (slabs, physical.thickness, physical.critical_thickness, "m", 1),
            ("a normal stress", scene.units.normal_stress, physical.critical_normal_stress, "Pa", 1),
        ]
    else:
        together = "" if scene.alike else f" of the upper slab{_TOGETHER}"
        limits = [
            (f"r{together}", scene.transit, 10.0**analysis.log10_r_c, "", 1),
            (f"epsilon{together}", scene.upper.epsilon, analysis.epsilon_c, "", -1),
        ]
    wanted = [
        f"{name} {'over' if here < critical else 'under'} {_engineering(critical, unit)} (here {_engineering(here, unit)})"
        for name, here, critical, unit, sign in limits
        if math.isfinite(critical)
        and (sign * (here - critical) < 0.0) == analysis.stable  # what destabilises is below it if stable
    ]
    return f"{'it would slip' if analysis.stable else 'it would slide steadily'} with {' or '.join(wanted)}" if wanted else ""


def _engineering(value: float, unit: str) -> str:
    """Three figures, with a prefix to a unit: 150 MPa, 6 m."""
    if not unit or value == 0.0:
        return f"{value:.3g}"
    power = power_of(value)
    return f"{value / 10.0**power:.3g} {PREFIXES[power]}{unit}"


def power_of(value: float) -> int:
    """Power of ten of the SI prefix for a nonzero value: 6 for 150e6."""
    return min(9, max(-9, 3 * math.floor(math.log10(abs(float(f"{value:.3g}"))) / 3.0)))


def _time(transits: float, scene: Scene) -> str:
    """A time in transits and, for a scene with units, in seconds."""
    seconds = f" ({_engineering(transits * scene.transit * scene.units.time, 's')})" if scene.units else ""
    return f"{transits:.3g} transits{seconds}"
