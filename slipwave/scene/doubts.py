"""Doubts about values in SI that no laboratory has: a shear modulus of 30 Pa is 30 GPa with its unit left out."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

from slipwave.scene.scene import Scene
from slipwave.scene.slab import Slab
from slipwave.scene.units import Units


@dataclass(frozen=True)
class Plausible:
    """Plausible range of `things`, `low` to `high` (SI). `sizes`: units by their size, for the message; the unit that gives a
    value near `usual` is suggested."""

    things: str
    low: float
    high: float
    usual: float
    sizes: dict[str, float]

    def sized(self, value: float) -> str:
        """`value` in the largest unit that is not larger."""
        fitting = [unit for unit, size in self.sizes.items() if size <= value] or [min(self.sizes, key=self.sizes.__getitem__)]
        unit = max(fitting, key=self.sizes.__getitem__)
        return f"{value / self.sizes[unit]:g} {unit}"


_STRESS = {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9}
_LENGTH = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "nm": 1e-9}
_SPEED = {"m/s": 1.0, "mm/s": 1e-3, "um/s": 1e-6}
_STIFFNESS = {"Pa/m": 1.0, "kPa/m": 1e3, "MPa/m": 1e6, "GPa/m": 1e9, "TPa/m": 1e12}

PLAUSIBLE = {
    # from aerogels and cork to osmium (22.6 g/cm3); rock has 2 to 3.3, steel 7.8, PMMA 1.2, gels 1
    "density": Plausible("solids", 100.0, 2.3e4, 2700.0, {"kg/m3": 1.0, "g/cm3": 1e3}),
    # from soft gels (gelatine: kPa) by PMMA (2 GPa), rock (10 to 40 GPa) and steel (80 GPa) to diamond (535 GPa)
    "shear_modulus": Plausible("solids", 1e3, 6e11, 1e10, _STRESS),
    # from soft gels (1 m/s) by PMMA (1.3 km/s) and rock (2 to 4 km/s) to diamond (12 km/s)
    "wave speed": Plausible("shear waves", 0.5, 1.3e4, 3e3, _SPEED),
    # from a centimetre's own weight (a gel: 100 Pa) by shear boxes (1 to 100 MPa) to the pressure in the lower crust (1 GPa)
    "normal_stress": Plausible("sliding samples", 50.0, 5e9, 1e7, _STRESS),
    # from atoms by bare rock and gouge of the laboratory (1 to 100 um) to rough faults in models of earthquakes (centimetres)
    "memory_length": Plausible("interfaces", 1e-9, 0.1, 1e-5, _LENGTH),
    # from films by large blocks of rock (metres) to models of a mine
    "thickness": Plausible("slabs of a laboratory", 1e-4, 1e3, 1.0, _LENGTH),
    # from a thousandth of the rate of plates (1e-9 m/s) to fast rotary shear (metres per second)
    "velocity": Plausible("drives", 1e-12, 10.0, 1e-4, _SPEED),
    # per area: a soft spring on a gel has 1e4 Pa/m, a press of 1e9 N/m on a sample of 10 cm2 1e12 Pa/m
    "stiffness": Plausible("testing machines", 1e3, 1e14, 1e10, _STIFFNESS),
}
"""Key of a scene -> plausible range in a laboratory, in SI."""


def doubt(key: str, value: float, remark: str = "") -> Iterator[str]:
    """One line if `value` (SI) of the scene's dotted `key` is implausible; none if it is plausible or no range is known."""
    known = PLAUSIBLE.get(key.rpartition(".")[2])
    if known is None or known.low <= value <= known.high:
        return
    meant = [unit for unit, size in known.sizes.items() if known.low <= value * size <= known.high]
    meant.sort(key=lambda unit: abs(math.log(value * known.sizes[unit] / known.usual)))
    hint = f"; did you mean {value:g} {meant[0]}?" if meant else ""
    have = f"{known.things} have {known.sized(known.low)} to {known.sized(known.high)}"
    yield f"{key} = {value:.4g} {next(iter(known.sizes))}{remark}: {have}{hint}"


def doubts(scene: Scene) -> list[str]:
    """One line for each implausible value of `scene` in SI, with the unit that is likely meant; none for scenes without units."""
    units = scene.units
    if units is None:
        return []
    slabs = [("slab", scene.upper)] if scene.alike else [("upper", scene.upper), ("lower", scene.lower)]
    rates = sorted({units.reference_velocity * rate for rate in scene.drive.velocities if rate > 0.0})
    return [
        *doubt("interface.normal_stress", units.normal_stress),
        *doubt("interface.memory_length", units.memory_length),
        *(line for key, slab in slabs for line in _of_slab(key, slab, units)),
        *(line for rate in {rates[0], rates[-1]} for line in doubt("drive.velocity", rate)),
    ]


def _of_slab(key: str, slab: Slab, units: Units) -> Iterator[str]:
    spring = slab.termination.spring * units.face["stiffness"]
    if spring > 0.0:
        yield from doubt(f"{key}.face.stiffness", spring)
    if slab.material is None:
        return
    speed = slab.material.wave_speed
    remark = f" (wave speed {speed:.3g} m/s)"
    lines = [
        *doubt(f"{key}.density", slab.material.density, remark),
        *doubt(f"{key}.shear_modulus", slab.material.shear_modulus, remark),
    ]
    yield from lines or doubt(f"{key}.wave speed", speed)
    yield from doubt(f"{key}.thickness", 0.5 * slab.round_trip * units.time * speed)
