"""What outer faces do to waves and load: in words for the head of every command, and as figures for the JSON.

A face sends a wave of angular frequency omega back by |R(i omega)|. omega is that of the leading root where a command knows it,
else the omega_c of friction, at which every lossless slab loses its stability. Below `Termination.spring_rate` the face is its
spring.
"""

import math
from collections.abc import Iterator
from dataclasses import fields
from typing import Any

from slipwave.friction.law import friction_slopes
from slipwave.scene import Scene
from slipwave.scene.slab import FACES, Face, Slab
from slipwave.scene.units import Units
from validation.commands.result import rounded


def watched(scene: Scene, root: complex = 0j) -> float:
    """The angular frequency (V*/L) at which faces are judged: that of the leading `root`, or omega_c of friction if it is real;
    NaN without both, where friction strengthens."""
    return abs(root.imag) or friction_slopes(scene.law, scene.velocity).omega_c


def face_figures(scene: Scene, omega: float) -> list[dict[str, Any]]:
    """For each face that is not rigid: |R| at `omega`, R of fast waves with its sign, and the rate below which it is its spring;
    rates in V*/L, and in 1/s for a scene with units."""
    found = []
    for name, slab in ((name, slab) for name, slab in scene.named_slabs if not slab.termination.is_rigid):
        reflections = {"reflection": _reflected(slab, omega), "fast_reflection": slab.fast_reflection}
        rates = {"omega": omega, "spring_rate": slab.termination.spring_rate}
        in_si = {f"{rate}_per_s": value / scene.units.time for rate, value in rates.items()} if scene.units else {}
        found.append({"slab": name, "kind": _kind_of(slab.face), "omega": omega, **reflections, **rates, **in_si})
    return found


def _reflected(slab: Slab, omega: float) -> float:
    return float(abs(slab.reflection(1j * omega))) if omega > 0.0 else math.nan


def face_in_words(slab: Slab, units: Units | None, omega: float) -> Iterator[str]:
    """The keys of a face, what it does to fast waves and to those of `omega`, and where it is its spring."""
    held = slab.termination
    if held.is_rigid:
        yield "rigid face: R = 1 for all waves"
        return
    values = f"{_kind_of(slab.face)}: {fields_in_words(slab.face)}{_sizes(slab, units)}"
    yield f"{values}, R = {slab.fast_reflection:.4g} for fast waves"
    facts = []
    if omega > 0.0:
        facts.append(f"at omega = {_rate(omega, units)} it reflects |R| = {rounded(_reflected(slab, omega), 6)}")
    if 0.0 < held.spring_rate < math.inf:
        name = "K/Z_g" if held.dashpot * held.spring_rate >= held.mass * held.spring_rate**2 else "sqrt(K/m)"
        facts.append(f"below {name} = {_rate(held.spring_rate, units)} it is its spring")
    if facts:
        yield "; ".join(facts)


def _rate(value: float, units: Units | None) -> str:
    return f"{value:.4g} V*/L" + (f" ({value / units.time:.4g} rad/s)" if units else "")


def _sizes(slab: Slab, units: Units | None) -> str:
    """Spring, dashpot and mass in SI."""
    if units is None:
        return ""
    held, size = slab.termination, units.face
    facts = [f"{rounded(held.spring * size['stiffness'], 6)} Pa/m", f"{rounded(held.dashpot * size['impedance'], 6)} Pa s/m"]
    facts += [f"{rounded(held.mass * size['mass'], 6)} kg/m2"] if held.mass > 0.0 else []
    return f" ({', '.join(facts)})"


def _kind_of(face: Face) -> str:
    """The name of a face's kind in scene files."""
    (kind,) = (name for name, one in FACES.items() if one is type(face))
    return kind


def fields_in_words(part: Any) -> str:
    """The fields of a dataclass as in "stiffness 2, impedance 0.5"."""
    return ", ".join(f"{field.name} {getattr(part, field.name):g}" for field in fields(part))
