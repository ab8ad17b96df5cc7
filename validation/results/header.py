"""What a command prints first: the scene in numbers, those of its slabs and faces, its units, and what is doubtful about them."""

import math
from collections.abc import Iterable
from dataclasses import fields

from slipwave.friction.law import name_of
from slipwave.scene import Scene
from slipwave.scene.doubts import doubts
from slipwave.scene.drive import Drive
from slipwave.scene.slab import FACES, Face, KelvinVoigtViscosity, RigidFace, Slab, Viscosity
from slipwave.scene.units import Units
from validation.output import rounded


def header(scene: Scene, notes: Iterable[str] = ()) -> list[str]:
    """A few lines: name, law, drive; each slab; the units, if the scene has them; a note for each doubt, and further `notes`."""
    parameters = ", ".join(f"{key} {value:g}" for key, value in zip(scene.law._fields, scene.law, strict=True))
    lines = [f"scene {scene.name}: {name_of(scene.law)} law ({parameters}), {_drive(scene.drive)}, digest {scene.digest}"]
    pairs = [("slabs", scene.upper)] if scene.alike else [("upper", scene.upper), ("lower", scene.lower)]
    lines += [f"{label}: {line}" for label, slab in pairs for line in _slab(slab, scene.units, scene.alike)]
    if scene.units:
        lines += _units(scene, scene.units)
    return lines + [f"note: {line}" for line in (*doubts(scene), *notes)]


def _drive(drive: Drive) -> str:
    changes = "" if drive.is_constant else f" at first, then {len(drive.knots)} knots up to t = {drive.times[-1]:g} transits"
    return f"V = {drive.initial:g}{changes}"


def _slab(slab: Slab, units: Units | None, alike: bool) -> list[str]:
    """Its numbers, and in a scene with units the same in SI. The round trip of `alike` slabs is the transit, told once below."""
    lines = [f"epsilon {rounded(slab.epsilon)}, r {rounded(slab.round_trip)} = 10^{math.log10(slab.round_trip):.6g}"]
    if units:
        lines.append(_in_si(slab, units, alike))
    if not isinstance(slab.face, RigidFace):
        lines.append(_face(slab.face) + (_face_in_si(slab, units) if units and not slab.termination.is_rigid else ""))
    if slab.viscosity:
        lines.append(_viscosity(slab.viscosity, units))
    if len(slab.layers) > 1:
        layers = ", ".join(f"{layer.fraction:g} of impedance {layer.impedance:g}" for layer in slab.layers)
        lines.append(f"layers from the interface outwards: {layers}")
    return lines


def _in_si(slab: Slab, units: Units, alike: bool) -> str:
    facts = [f"impedance {rounded(slab.epsilon * units.face['impedance'], 6)} Pa s/m"]
    facts += [] if alike else [f"round trip {rounded(slab.round_trip * units.time, 6)} s"]
    if slab.material:
        speed = slab.material.wave_speed
        thickness = 0.5 * slab.round_trip * units.time * speed
        facts = [f"thickness {rounded(thickness, 6)} m", f"wave speed {rounded(speed, 6)} m/s", *facts]
    return ", ".join(facts)


def _face(face: Face) -> str:
    (kind,) = (name for name, one in FACES.items() if one is type(face))
    return f"{kind}: {_values(face)}"


def _face_in_si(slab: Slab, units: Units) -> str:
    held, size = slab.termination, units.face
    facts = [
        f"{rounded(held.spring * size['stiffness'], 6)} Pa/m",
        f"{rounded(held.dashpot * size['impedance'], 6)} Pa s/m",
    ]
    facts += [f"{rounded(held.mass * size['mass'], 6)} kg/m2"] if held.mass > 0.0 else []
    return f" ({', '.join(facts)})"


def _viscosity(viscosity: Viscosity, units: Units | None) -> str:
    kind = "kelvin-voigt" if isinstance(viscosity, KelvinVoigtViscosity) else "standard-linear"
    return f"{kind}: {_values(viscosity)}" + (f" ({rounded(viscosity.time * units.time, 6)} s)" if units else "")


def _values(part: Face | Viscosity) -> str:
    """The fields of a dataclass as in "stiffness 2, impedance 0.5"."""
    return ", ".join(f"{field.name} {getattr(part, field.name):g}" for field in fields(part))


def _units(scene: Scene, units: Units) -> list[str]:
    stiffness = scene.stiffness / scene.transit * units.face["stiffness"]
    velocity = scene.velocity * units.reference_velocity
    return [
        f"units: L = {units.memory_length:g} m, V* = {units.reference_velocity:g} m/s, sigma = {units.normal_stress:g} Pa",
        f"one transit = {rounded(scene.transit * units.time, 6)} s; V = {rounded(velocity, 6)} m/s; "
        f"stiffness of slabs and faces in series {rounded(stiffness, 6)} Pa/m",
    ]
