"""Scenes, outer faces and statistics in words and rows, dimensionless and (where the scene has units) in SI.

Every command first prints the `header`: the scene, its slabs and faces in numbers, its units, and doubts about them.

A face sends a wave of angular frequency omega back by |R(i omega)|. omega is that of the leading root where a command knows it,
else the omega_c of friction, at which every lossless slab loses its stability. Below `Termination.spring_rate` the face is its
spring.
"""

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import fields
from typing import Any

from slipwave.friction.law import friction_slopes, name_of
from slipwave.observe import MotionVerdict, RunStatistics
from slipwave.observe.verdict import REPEATING
from slipwave.scene import Scene
from slipwave.scene.scene import doubts
from slipwave.scene.slab import FACES, VISCOSITIES, Face, Slab, Viscosity
from slipwave.scene.units import Units
from validation.commands.result import rounded
from validation.data.variables import EVENTS, shown_in

ENDED = {
    "cycles": "the run ended here because its second half has the cycles asked for",
    "settled": "the run ended here because its motion is settled; --until makes it longer",
    "limit": "the run ended here, before its motion was settled, because of its limit of work; --until makes it longer",
}
"""Reason of the end of a run without a given length -> text."""

_COUNTED = (*REPEATING, "settling", "too short")  # any other motion has swings, but no cycles of stick-slip


def figure_rows(
    columns: tuple[str, str], known: Mapping[str, tuple[float, float]], scene: Scene
) -> tuple[list[str], list[list[str]]]:
    """Heading and rows of (value, spread) of the five figures of a cycle, with a column in SI if the scene has units."""
    labels = {"period": "period [transits]", "v_max": "v_max [V*]", "v_min": "v_min [V*]"}
    facts = [(labels.get(name, name.replace("_", " ")), *pair) for name, pair in known.items()]
    period, spread = known["period"]
    facts.insert(1, ("period [L/V*]", period * scene.transit, spread * scene.transit))
    heading, rows = ["", *columns], [[label, rounded(value), rounded(spread, 3)] for label, value, spread in facts]
    if scene.units is None:
        return heading, rows
    units = [shown_in(EVENTS[name].unit, scene) for name in known]
    units.insert(1, (units[0][0] / scene.transit, units[0][1]))
    physical = [
        [f"{rounded(value * size, 6)} {unit}", "-" if math.isnan(spread) else f"{rounded(spread * size, 3)} {unit}"]
        for (_, value, spread), (size, unit) in zip(facts, units, strict=True)
    ]
    return [*heading, "SI", f"{columns[1]} in SI"], [row + more for row, more in zip(rows, physical, strict=True)]


def margins_in_words(statistics: RunStatistics, scene: Scene) -> list[str]:
    """Lines with the intervals of the means of cycles that never repeat, and of the median of v_max; none if they do."""
    if math.isnan(statistics.margins["period"]):
        return []
    period, drop, rate = margins = [statistics.margins[name] for name in ("period", "stress_drop", "v_max_median")]
    shown = [shown_in(unit, scene) for unit in ("transit", "normal stress", "V*")]
    seconds, pascals, speed = (
        f" ({rounded(value * size, 3)} {unit})" if scene.units else "" for value, (size, unit) in zip(margins, shown, strict=True)
    )
    known = f"period +- {rounded(period, 3)} transits{seconds}, stress drop +- {rounded(drop, 3)}{pascals}"
    middle = f"the median of v_max is {rounded(statistics.v_max_median)} +- {rounded(rate, 3)} V*{speed}"
    return [f"the mean of an endless run lies within (95 %): {known}", middle]


def events_in_words(count: int | None, verdict: MotionVerdict | None, longer: str) -> str:
    """The number of slip events of a run and its verdict, in one line; `longer`: the length of a run that is not too short."""
    if count is None or verdict is None:
        return "events were not watched (run.record is empty)"
    return f"{count} slip event{'s' if count != 1 else ''}; {_verdict_in_words(verdict, longer)}"


def longer_in_words(needed: float, scene: Scene) -> str:
    """What to try if a run of `needed` transits has enough cycles, with the time if `scene` has units."""
    if math.isinf(needed):
        return "one takes longer than a run can be"
    size, unit = shown_in("transit", scene)
    return f"try --until {float(f'{needed:.2g}'):g}{f' ({needed * size:.2g} {unit})' if scene.units else ''}"


def _verdict_in_words(verdict: MotionVerdict, longer: str) -> str:
    """The verdict on the second half of a run, with the reason; `longer`: see `events_in_words`."""
    change = f"{abs(verdict.change):.2g}"
    falls = f"the drop of elastic stress falls by {change} of itself from the first of its events to the last"
    reasons = {
        "steady": "v is V within 1e-6",
        "decaying": "it has waves only, which friction damps" if math.isnan(verdict.change) else falls,
        "growing": f"the drop of elastic stress grows by {change} of itself from the first of its events to the last",
        "settling": f"its cycles still change, the last by {change} of itself",
        "periodic": f"{verdict.multiplicity} event{'s' if verdict.multiplicity != 1 else ''} in a period",
        "torus": f"its cycles never repeat but follow one phase, {verdict.rotation or 0.0:.4f} of a turn in each",
        "irregular": "its cycles do not repeat",
        "driven": "V changes or is zero there",
        "too short": f"too few cycles to judge; {longer}",
    }
    if verdict.kind == "protocol":
        return "a protocol"
    reason = reasons[verdict.kind]
    counted = f", {verdict.cycles} complete cycle{'s' if verdict.cycles != 1 else ''}," if verdict.kind in _COUNTED else ""
    kind = f"a {verdict.kind}" if verdict.kind == "torus" else verdict.kind
    return f"the second half{counted} is {kind}: {reason}"


def header(scene: Scene, notes: Iterable[str] = (), root: complex = 0j) -> list[str]:
    """A few lines: name, law, drive; each slab, with what its face does at the frequency of the leading `root`, if known; the
    units, if the scene has them; a note for each doubt, and further `notes`."""
    parameters = ", ".join(f"{key} {value:g}" for key, value in zip(scene.law._fields, scene.law, strict=True))
    drive = scene.drive
    changes = "" if drive.is_constant else f" at first, then {len(drive.knots)} knots up to t = {drive.times[-1]:g} transits"
    law = f"{name_of(scene.law)} law ({parameters})"
    lines = [f"scene {scene.name}: {law}, V = {drive.initial:g}{changes}, digest {scene.digest}"]
    for name, slab in scene.named_slabs:
        lines += [f"{name}{'s' * scene.alike}: {line}" for line in _slab(slab, scene, root)]
    if scene.equivalent and not scene.alike:
        marching = "delay and full waves march one" if scene.drive.is_constant else "delay marches one"
        lines.append(f"both: to the interface as alike slabs of epsilon {rounded(scene.equivalent.epsilon)}; {marching}")
    if scene.units:
        lines += _units(scene, scene.units)
    return lines + [f"note: {line}" for line in (*doubts(scene), *notes)]


def _slab(slab: Slab, scene: Scene, root: complex) -> list[str]:
    """Numbers of a slab, with SI values in a scene with units. The round trip of alike slabs is the transit, which is printed
    below."""
    units = scene.units
    lines = [f"epsilon {rounded(slab.epsilon)}, r {rounded(slab.round_trip)} = 10^{math.log10(slab.round_trip):.6g}"]
    if units:
        lines.append(_in_si(slab, units, scene.alike))
    written = [(scene.tables or {}).get(name, {}).get("face", {}).get("kind", "rigid") for name in ("slab", "upper", "lower")]
    if not scene.is_held_rigidly or any(kind != "rigid" for kind in written):  # one of another kind may be rigid in the limit
        lines += _face_in_words(slab, units, watched(scene, root))
    if slab.viscosity:
        time = f" ({rounded((slab.rheology.relaxation or slab.rheology.retardation) * units.time, 6)} s)" if units else ""
        lines.append(f"{_kind_of(slab.viscosity)}: {_fields_in_words(slab.viscosity)}{time}")
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


def _units(scene: Scene, units: Units) -> list[str]:
    stiffness = scene.stiffness / scene.transit * units.face["stiffness"]
    velocity = scene.velocity * units.reference_velocity
    yields = any(slab.termination.has_dead_load for slab in scene.slabs)  # then the drive's displacement does not last as a load
    of_what = "0, since a face has no spring, without that face " if yields else ""
    return [
        f"units: L = {units.memory_length:g} m, V* = {units.reference_velocity:g} m/s, sigma = {units.normal_stress:g} Pa",
        f"one transit = {rounded(scene.transit * units.time, 6)} s; V = {rounded(velocity, 6)} m/s; "
        f"stiffness of slabs and faces in series {of_what}{rounded(stiffness, 6)} Pa/m, "
        f"over the normal stress {rounded(1e-6 * stiffness / units.normal_stress, 6)} /um",
    ]


def watched(scene: Scene, root: complex = 0j) -> float:
    """The angular frequency (V*/L) at which faces are judged: that of the leading `root`, or omega_c of friction if it is real;
    NaN without both, where friction strengthens."""
    return abs(root.imag) or friction_slopes(scene.law, scene.velocity).omega_c


def face_figures(scene: Scene, omega: float) -> list[dict[str, Any]]:
    """For each face that is not rigid: |R| at `omega`, R of fast waves with its sign, and the rate below which it is its spring;
    rates in V*/L, and in 1/s for a scene with units."""
    rows = []
    for name, slab in ((name, slab) for name, slab in scene.named_slabs if not slab.termination.is_rigid):
        reflections = {"reflection": _reflected(slab, omega), "fast_reflection": slab.fast_reflection}
        rates = {"omega": omega, "spring_rate": slab.termination.spring_rate}
        in_si = {f"{rate}_per_s": value / scene.units.time for rate, value in rates.items()} if scene.units else {}
        rows.append({"slab": name, "kind": _kind_of(slab.face), "omega": omega, **reflections, **rates, **in_si})
    return rows


def _reflected(slab: Slab, omega: float) -> float:
    return float(abs(slab.reflection(1j * omega))) if omega > 0.0 else math.nan


def _face_in_words(slab: Slab, units: Units | None, omega: float) -> Iterator[str]:
    """The keys of a face, what it does to fast waves and to those of `omega`, and where it is its spring."""
    held = slab.termination
    if held.is_rigid:
        yield "rigid face: R = 1 for all waves"
        return
    values = f"{_kind_of(slab.face)}: {_fields_in_words(slab.face)}{_sizes(slab, units)}"
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


def _kind_of(part: Face | Viscosity) -> str:
    """The name of the kind of a face or a viscosity in scene files."""
    return next(name for name, kind in (FACES | VISCOSITIES).items() if kind is type(part))


def _fields_in_words(part: Any) -> str:
    """The numbers of a dataclass as in "stiffness 2, impedance 0.5"."""
    return ", ".join(f"{field.name} {getattr(part, field.name):g}" for field in fields(part) if field.compare)
