"""The runs of the study: a block under double direct shear, with and without waves in the steel blocks, and a metre of gabbro."""

import math
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np

import slipwave as sw
from validation.measure.cycle import history_of
from validation.references.published import laboratory

DENSITY, SHEAR_MODULUS, THICKNESS = 7850.0, 79e9, 0.05  # of the steel forcing blocks
STIFFNESS_SPREAD = 0.05  # of k', for which no uncertainty is printed: our assumption
_TOLERANCE = 1e-6
_CYCLES = 12.0
_START = 2.0


class FrictionFit(NamedTuple):
    """Parameters of friction: a, b and L in um."""

    a: float
    b: float
    length: float


class MeasuredCycle(NamedTuple):
    """A cycle: period (s), drop of friction, peak slip rate (mm/s)."""

    period: float
    drop: float
    peak: float


def leeman_runs() -> list[Mapping[str, Any]]:
    """The seven runs of Leeman et al. (2016)."""
    return list(laboratory()["leeman-2016"]["rows"])


def printed_fits() -> list[tuple[FrictionFit, FrictionFit]]:
    """The printed fits of a, b and L: values and standard deviations."""
    found = laboratory()["leeman-2016"]["rate_and_state"]["fits"]
    return [
        (FrictionFit(*(one[key][0] for key in ("a", "b", "Dc_um"))), FrictionFit(*(one[key][1] for key in ("a", "b", "Dc_um"))))
        for one in found
    ]


def samples(count: int) -> list[tuple[FrictionFit, float]]:
    """Parameters within the printed uncertainty, with a factor of k': the three fits in turn, a, b and L normal and independent
    of each other (no correlation is printed)."""
    random, fits = np.random.default_rng(20160331), printed_fits()
    drawn = random.standard_normal((count, 4))
    return [
        (
            FrictionFit(*(m + s * x for m, s, x in zip(*fits[n % len(fits)], row[:3], strict=True))),
            math.exp(STIFFNESS_SPREAD * row[3]),
        )
        for n, row in enumerate(drawn)
    ]


def plain_block(row: Mapping[str, Any], fit: FrictionFit, law: str, factor: float = 1.0) -> sw.Scene:
    """Spring, `factor` times k', and radiation damping, rho c/2 of steel: alike slabs whose elasticity is the spring, for a model
    without waves and inertia."""
    stiffness = factor * row["k_per_um"] * row["sigma_MPa"] * 1e12  # Pa/m
    slab = {"density": DENSITY, "shear_modulus": SHEAR_MODULUS, "thickness": SHEAR_MODULUS / (2.0 * stiffness)}
    return _scene(row, fit, law, slab)


def steel_blocks(row: Mapping[str, Any], fit: FrictionFit, dashpot: float, mass: float = 0.0) -> sw.Scene:
    """Two blocks of steel, each behind a spring with a dashpot (of `dashpot` times rho c) and a mass (kg/m2)."""
    stiffness = row["k_per_um"] * row["sigma_MPa"] * 1e12
    spring = 1.0 / (1.0 / (2.0 * stiffness) - THICKNESS / SHEAR_MODULUS)
    impedance = dashpot * math.sqrt(DENSITY * SHEAR_MODULUS)
    face = {"kind": "machine", "stiffness": spring, "impedance": impedance, "mass": mass}
    slab = {"density": DENSITY, "shear_modulus": SHEAR_MODULUS, "thickness": THICKNESS, "face": face}
    return _scene(row, fit, "ageing", slab)


def _scene(row: Mapping[str, Any], fit: FrictionFit, law: str, slab: Mapping[str, Any]) -> sw.Scene:
    """A run between alike slabs."""
    interface = {"law": law, "a_star": 0.6, "a": fit.a, "b": fit.b, "memory_length": fit.length * 1e-6}
    interface |= {"normal_stress": row["sigma_MPa"] * 1e6, "reference_velocity": 1e-6}
    drive, start = {"velocity": 10.0}, {"size": _START}
    return sw.read_scene({"name": "laboratory", "interface": interface, "slab": slab, "drive": drive, "start": start})


def cycle_in_run(
    scene: sw.Scene, model: str, seconds: float, after: float = 0.5, tolerance: float = _TOLERANCE
) -> MeasuredCycle | None:
    """The last complete cycle, beginning `after` this share, of a run of `seconds`; None if there is none, or if the slip rate
    stays below twice V: steady sliding, now or later."""
    assert scene.units
    transit = scene.units.size("transit", scene.transit)
    until = seconds / transit
    events = sw.run(scene, model, until=until, tol=tolerance).records.watch.events(after * until)
    if events.time.size == 0 or events.v_max[-1] <= 2.0 * scene.velocity:
        return None
    peak = 1e3 * float(events.v_max[-1]) * scene.units.reference_velocity
    return MeasuredCycle(float(events.period[-1]) * transit, float(events.stress_drop[-1]), peak)


def cycles_of_samples(row: Mapping[str, Any], law: str, drawn: Iterable[tuple[FrictionFit, float]]) -> list[MeasuredCycle | None]:
    """A cycle of the plain block for each of the samples; None where it slides steadily."""
    return [
        cycle_in_run(plain_block(row, fit, law, factor), "quasidynamic", _CYCLES * row["T_s"]) if fit.b > fit.a > 0.0 else None
        for fit, factor in drawn
    ]


def cycle_without_tuning(row: Mapping[str, Any], fit: FrictionFit) -> MeasuredCycle | None:
    """The cycle of the plain block with a printed fit, ageing law."""
    return cycle_in_run(plain_block(row, fit, "ageing"), "quasidynamic", 2.0 * _CYCLES * row["T_s"], after=0.7)


class Rise(NamedTuple):
    """A slip event of the gabbro: its drop (MPa) and rise time (ms)."""

    drop: float
    time: float


def rise_of(normal_stress: float, weakening: float, velocity: float) -> Rise:
    """The last slip event of a metre of gabbro on the machine of Togo et al. (2015), exact waves. `normal_stress` in MPa, b - a,
    V in mm/s."""
    togo = laboratory()["togo-2015"]
    stiffness, mass = 153e6, float(togo["mass_kg_per_m2"])
    slab = {"density": 2980.0, "shear_modulus": 3.9e10, "thickness": 0.2}
    face = {"kind": "machine", "stiffness": stiffness, "impedance": 0.0, "mass": mass}
    interface = {"law": "ageing", "a_star": 0.7, "a": 0.01, "b": 0.01 + weakening}
    interface |= {"normal_stress": normal_stress * 1e6, "memory_length": 1e-6, "reference_velocity": 1e-6}
    tables = {"interface": interface, "upper": slab | {"face": face}, "lower": slab, "drive": {"velocity": 1e3 * velocity}}
    scene = sw.read_scene({"name": "gabbro", "start": {"size": _START}, **tables})
    assert scene.units
    transit = scene.units.size("transit", scene.transit)
    until = 120.0 * weakening * normal_stress * 1e6 / stiffness / (1e-3 * velocity) / transit  # some periods
    run = sw.run(scene, "delay", until=until, tol=1e-6, window=(0.4 * until, until))
    history, date = history_of(run), float(run.done.events.time[-1])
    near = np.abs(transit * (history["time"] - date)) <= 0.1  # s
    drop = float(run.done.events.elastic_stress_drop[-1]) * normal_stress
    return Rise(drop, 1e3 * transit * rise_time(history["time"][near], history["elastic_stress"][near]))


def rise_time(time: np.ndarray, elastic: np.ndarray) -> float:
    """The time in which the elastic stress falls from 90 % to 10 % of its drop, over 0.590, the share of this time in half a
    period of free vibration."""
    top = int(np.argmax(elastic))
    bottom = top + int(np.argmin(elastic[top:]))
    share = (elastic[top:bottom] - elastic[bottom]) / (elastic[top] - elastic[bottom])
    begin, end = (top + int(np.flatnonzero(share > level)[-1]) for level in (0.9, 0.1))
    return float(time[end] - time[begin]) / ((math.acos(-0.8) - math.acos(0.8)) / math.pi)
