"""A scene: everything about a run except how it is computed. Frozen, dimensionless; `slipwave.read` reads one from TOML.

Doubts about it: values in SI that no laboratory has; a shear modulus of 30 Pa is 30 GPa with its unit left out.
"""

import hashlib
import math
from collections.abc import Iterator, Mapping
from dataclasses import InitVar, dataclass, field, replace
from functools import cached_property
from typing import Any

from slipwave.friction import Law
from slipwave.friction.law import Response, steady_sliding
from slipwave.scene.drive import Drive, Forcing, Start
from slipwave.scene.slab import Slab
from slipwave.scene.units import Units


@dataclass(frozen=True)
class Scene:
    """Two slabs, the interface's law, the drive, the start, the length of the run and what to record.

    Units: length L, velocity V*, stress sigma, friction clock L/V*. "transit" is the round trip of the upper slab; `until` is in
    transits; None: the length of a run follows from its motion. `units` holds L, V* and sigma when the scene was given in SI.
    `tables`: those of the file that it was read from, passed as `written`; None for a scene made in any other way, also by
    `dataclasses.replace`.
    """

    name: str
    law: Law
    upper: Slab
    lower: Slab
    drive: Drive
    start: Start = field(default_factory=Start)
    until: float | None = None
    record: frozenset[str] = frozenset({"events"})
    units: Units | None = None
    written: InitVar[Mapping[str, Any] | None] = None
    tables: Mapping[str, Any] | None = field(init=False, repr=False, compare=False)

    def __post_init__(self, written: Mapping[str, Any] | None) -> None:
        # not by a field with a default: `replace` would hand the tables on to a scene that they do not describe
        object.__setattr__(self, "tables", written)

    @property
    def alike(self) -> bool:
        """True if both slabs are the same, so that one of them is sufficient (the motion is antisymmetric)."""
        return self.upper == self.lower

    @cached_property
    def equivalent(self) -> Slab | None:
        """One of two alike slabs that answer the interface as both of the scene's; None if there are no such slabs.

        Z_1(s) and Z_2(s) of slabs that differ in epsilon alone (layers and face are relative to it) have a constant ratio, and
        1/Z = 1/Z_1 + 1/Z_2 is that of alike slabs of epsilon = 2/(1/eps_1 + 1/eps_2). That holds for any drive: how a slab that
        carries no stress at the interface follows it does not depend on epsilon."""
        upper, lower = self.upper, self.lower
        if upper == lower:
            return upper
        if replace(lower, epsilon=upper.epsilon) != upper:
            return None
        return replace(upper, epsilon=2.0 / (1.0 / upper.epsilon + 1.0 / lower.epsilon), material=None)

    @property
    def slabs(self) -> tuple[Slab, ...]:
        """The slabs that the interface's motion needs: the `equivalent` one, else the upper and the lower one."""
        return (self.upper, self.lower) if self.equivalent is None else (self.equivalent,)

    @property
    def named_slabs(self) -> list[tuple[str, Slab]]:
        """The slabs under the names of their tables in scene files: one if they are alike."""
        return [("slab", self.upper)] if self.alike else [("upper", self.upper), ("lower", self.lower)]

    @property
    def is_held_rigidly(self) -> bool:
        """Whether both outer faces move with the drive."""
        return self.upper.termination.is_rigid and self.lower.termination.is_rigid

    @property
    def is_plain(self) -> bool:
        """Whether the slabs have an `equivalent` that is plain: one wave and one delay are then sufficient."""
        return self.equivalent is not None and self.equivalent.is_plain

    @property
    def velocity(self) -> float:
        """V at t = 0, in V*: the rate of the steady sliding from which every start departs."""
        return self.drive.initial

    @property
    def transit(self) -> float:
        """One transit of the upper slab on the friction clock L/V*."""
        return self.upper.round_trip

    @property
    def impedance(self) -> float:
        """Z of the interface condition: 1/Z = 1/eps_1 + 1/eps_2 (layers next to the interface)."""
        return 1.0 / (1.0 / self.upper.interface_impedance + 1.0 / self.lower.interface_impedance)

    @cached_property
    def stiffness(self) -> float:
        """Quasi-static stiffness of both slabs in series, per transit: elastic stress y' = stiffness (V - v), t~ clock; equal to
        epsilon for alike plain slabs (41). It includes the spring of a grip; a bare reflection coefficient has no spring."""
        return self.transit / (self.upper.compliance + self.lower.compliance)

    @cached_property
    def _steady(self) -> tuple[float, Response]:
        return steady_sliding(self.law, self.velocity)

    @property
    def steady_psi(self) -> float:
        """psi_ss(V)."""
        return self._steady[0]

    @property
    def steady_response(self) -> Response:
        """What the law answers in steady sliding at V."""
        return self._steady[1]

    @property
    def steady_stress(self) -> float:
        """mu_ss(V)."""
        return float(self.steady_response[2])

    @cached_property
    def forcing(self) -> Forcing:
        """Numbers of the scene for compiled marches."""
        return Forcing(self.transit, self.stiffness, self.steady_stress, self.velocity, self.start.nudge_size)

    @cached_property
    def digest(self) -> str:
        """Twelve hex digits that name this scene's physics (not its name) in logs and stored results."""
        facts = (type(self.law).__qualname__, tuple(self.law), self.upper, self.lower, self.drive, self.start, self.until)
        return hashlib.sha256(repr(facts).encode()).hexdigest()[:12]


_STRESS = {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9}
_LENGTH = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "nm": 1e-9}
_SPEED = {"m/s": 1.0, "mm/s": 1e-3, "um/s": 1e-6}
_STIFFNESS = {"Pa/m": 1.0, "kPa/m": 1e3, "MPa/m": 1e6, "GPa/m": 1e9, "TPa/m": 1e12}

PLAUSIBLE = {
    # from aerogels and cork to osmium (22.6 g/cm3); rock has 2 to 3.3, steel 7.8, PMMA 1.2, gels 1
    "density": ("solids", 100.0, 2.3e4, 2700.0, {"kg/m3": 1.0, "g/cm3": 1e3}),
    # from soft gels (gelatine: kPa) by PMMA (2 GPa), rock (10 to 40 GPa) and steel (80 GPa) to diamond (535 GPa)
    "shear_modulus": ("solids", 1e3, 6e11, 1e10, _STRESS),
    # from soft gels (1 m/s) by PMMA (1.3 km/s) and rock (2 to 4 km/s) to diamond (12 km/s)
    "wave speed": ("shear waves", 0.5, 1.3e4, 3e3, _SPEED),
    # from a centimetre's own weight (a gel: 100 Pa) by shear boxes (1 to 100 MPa) to the pressure in the lower crust (1 GPa)
    "normal_stress": ("sliding samples", 50.0, 5e9, 1e7, _STRESS),
    # from atoms by bare rock and gouge of the laboratory (1 to 100 um) to rough faults in models of earthquakes (centimetres)
    "memory_length": ("interfaces", 1e-9, 0.1, 1e-5, _LENGTH),
    # from films by large blocks of rock (metres) to models of a mine
    "thickness": ("slabs of a laboratory", 1e-4, 1e3, 1.0, _LENGTH),
    # from a thousandth of the rate of plates (1e-9 m/s) to fast rotary shear (metres per second)
    "velocity": ("drives", 1e-12, 10.0, 1e-4, _SPEED),
    # per area: a soft spring on a gel has 1e4 Pa/m, a press of 1e9 N/m on a sample of 10 cm2 1e12 Pa/m
    "stiffness": ("testing machines", 1e3, 1e14, 1e10, _STIFFNESS),
}
"""Key of a scene -> things that have it, its plausible range in a laboratory (SI), what is usual, and units by their size."""


def doubt(key: str, value: float, remark: str = "") -> Iterator[str]:
    """One line if `value` (SI) of the scene's dotted `key` is implausible; none if it is plausible or no range is known."""
    known = PLAUSIBLE.get(key.rpartition(".")[2])
    if known is None or known[1] <= value <= known[2]:
        return
    things, low, high, usual, sizes = known

    def sized(limit: float) -> str:
        """`limit` in the largest unit that is not larger."""
        fitting = [unit for unit, size in sizes.items() if size <= limit] or [min(sizes, key=sizes.__getitem__)]
        unit = max(fitting, key=sizes.__getitem__)
        return f"{limit / sizes[unit]:g} {unit}"

    meant = [unit for unit, size in sizes.items() if low <= value * size <= high]
    meant.sort(key=lambda unit: abs(math.log(value * sizes[unit] / usual)))
    hint = f"; did you mean {value:g} {meant[0]}?" if meant else ""
    yield f"{key} = {value:.4g} {next(iter(sizes))}{remark}: {things} have {sized(low)} to {sized(high)}{hint}"


def doubts(scene: Scene) -> list[str]:
    """One line for each implausible value of `scene` in SI, with the unit that is likely meant; none for scenes without units."""
    units = scene.units
    if units is None:
        return []
    rates = sorted({units.reference_velocity * rate for rate in scene.drive.velocities if rate > 0.0})
    return [
        *doubt("interface.normal_stress", units.normal_stress),
        *doubt("interface.memory_length", units.memory_length),
        *(line for key, slab in scene.named_slabs for line in _of_slab(key, slab, units)),
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
