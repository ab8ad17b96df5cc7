"""Scenes and statistics in words and rows, dimensionless and (where the scene has units) in SI.

Every command first prints the `header`: the scene, its slabs and faces in numbers, its units, and doubts about them.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import fields

from slipwave.friction.law import name_of
from slipwave.observe import MotionVerdict, RunStatistics
from slipwave.observe.statistics import Orbit
from slipwave.observe.verdict import REPEATING
from slipwave.scene import Scene
from slipwave.scene.doubts import doubts
from slipwave.scene.drive import Drive
from slipwave.scene.slab import VISCOSITIES, Slab, Viscosity
from slipwave.scene.units import Units
from slipwave.solve.lyapunov import Exponent
from validation.commands.faces import face_in_words, fields_in_words, watched
from validation.commands.result import rounded
from validation.data.variables import EVENTS, shown_in

ENDED = {
    "cycles": "the run ended here because its second half has the cycles asked for",
    "settled": "the run ended here because its motion is settled; --until makes it longer",
    "limit": "the run ended here, before its motion was settled, because of its limit of work; --until makes it longer",
}
"""Reason of the end of a run without a given length -> text."""

_COUNTED = (*REPEATING, "settling", "too short")  # any other motion has swings, but no cycles of stick-slip


def statistics_rows(found: RunStatistics, scene: Scene) -> tuple[list[str], list[list[str]]]:
    """Heading and rows of mean and spread of a run's cycles, with a column in SI if the scene has units."""
    means = {name: (one.mean, one.std) for name, one in found.spreads.items()}
    rates = {name: (getattr(found, name), math.nan) for name in ("v_max", "v_min")}
    return _with_units(("mean", "std"), means | rates, scene)


def orbit_rows(found: Orbit, scene: Scene) -> tuple[list[str], list[list[str]]]:
    """Heading and rows of an orbit's figures and their errors, with a column in SI if the scene has units."""
    values = {field.name: getattr(found, field.name) for field in fields(found)}
    return _with_units(("value", "error"), {name: (one.value, one.error) for name, one in values.items()}, scene)


def _with_units(
    columns: tuple[str, str], known: Mapping[str, tuple[float, float]], scene: Scene
) -> tuple[list[str], list[list[str]]]:
    """Heading and rows of (value, spread) of the five figures of a cycle."""
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
        [f"{rounded(value * size, 6)} {unit}", _sized(spread * size, unit)]
        for (_, value, spread), (size, unit) in zip(facts, units, strict=True)
    ]
    return [*heading, "SI", f"{columns[1]} in SI"], [row + more for row, more in zip(rows, physical, strict=True)]


def _sized(spread: float, unit: str) -> str:
    return "-" if math.isnan(spread) else f"{rounded(spread, 3)} {unit}"


def margins_in_words(found: RunStatistics, scene: Scene) -> list[str]:
    """Lines with the intervals of the means of cycles that never repeat, and of the median of v_max; none if they do."""
    if math.isnan(found.margins.period):
        return []
    period, drop, rate = found.margins.period, found.margins.stress_drop, found.margins.v_max_median
    sizes = [shown_in(unit, scene)[0] for unit in ("transit", "normal stress")]
    seconds, pascals = (
        f" ({rounded(value * size, 3)} {unit})" if scene.units else ""
        for value, size, unit in zip((period, drop), sizes, ("s", "Pa"), strict=True)
    )
    known = f"period +- {rounded(period, 3)} transits{seconds}, stress drop +- {rounded(drop, 3)}{pascals}"
    middle = f"the median of v_max is {rounded(found.v_max_median)} +- {rounded(rate, 3)} V*"
    return [f"the mean of an endless run lies within (95 %): {known}", middle]


def spreads_in_words(found: RunStatistics) -> list[str]:
    """A remark on every figure of cycles whose spread exceeds its mean."""
    wide = [name.replace("_", " ") for name, one in found.spreads.items() if one.std > one.mean]
    return [f"the std of {' and '.join(wide)} exceeds the mean: cycles differ so much that a mean says little"] if wide else []


def exponent_in_words(found: Exponent) -> str:
    """A line with the largest Lyapunov exponent, and whether it differs from zero."""
    known = f"largest Lyapunov exponent {rounded(found.rate, 3)} +- {rounded(found.margin, 2)} per transit (95 %)"
    if abs(found.rate) <= found.margin:
        return f"{known}: the exponent is zero within its error"
    word = "diverge" if found.rate > 0.0 else "converge"
    return f"{known}: nearby motions {word} by a factor e in {1.0 / abs(found.rate):.3g} transits"


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
    lines = [f"scene {scene.name}: {name_of(scene.law)} law ({parameters}), {_drive(scene.drive)}, digest {scene.digest}"]
    for name, slab in scene.named_slabs:
        lines += [f"{name}{'s' * scene.alike}: {line}" for line in _slab(slab, scene, root)]
    if scene.equivalent and not scene.alike:
        one = "delay and full waves march one" if scene.drive.is_constant else "delay marches one"
        lines.append(f"both: to the interface as alike slabs of epsilon {rounded(scene.equivalent.epsilon)}; {one}")
    if scene.units:
        lines += _units(scene, scene.units)
    return lines + [f"note: {line}" for line in (*doubts(scene), *notes)]


def _drive(drive: Drive) -> str:
    changes = "" if drive.is_constant else f" at first, then {len(drive.knots)} knots up to t = {drive.times[-1]:g} transits"
    return f"V = {drive.initial:g}{changes}"


def _slab(slab: Slab, scene: Scene, root: complex) -> list[str]:
    """Numbers of a slab, with SI values in a scene with units. The round trip of alike slabs is the transit, which is printed
    below."""
    units = scene.units
    lines = [f"epsilon {rounded(slab.epsilon)}, r {rounded(slab.round_trip)} = 10^{math.log10(slab.round_trip):.6g}"]
    if units:
        lines.append(_in_si(slab, units, scene.alike))
    if not scene.is_held_rigidly or _writes_a_face(scene):
        lines += face_in_words(slab, units, watched(scene, root))
    if slab.viscosity:
        lines.append(_viscosity(slab.viscosity, units))
    if len(slab.layers) > 1:
        layers = ", ".join(f"{layer.fraction:g} of impedance {layer.impedance:g}" for layer in slab.layers)
        lines.append(f"layers from the interface outwards: {layers}")
    return lines


def _writes_a_face(scene: Scene) -> bool:
    """Whether a rigid face is written as one of another kind, in the limit."""
    kinds = ((scene.tables or {}).get(name, {}).get("face", {}).get("kind", "rigid") for name in ("slab", "upper", "lower"))
    return any(kind != "rigid" for kind in kinds)


def _in_si(slab: Slab, units: Units, alike: bool) -> str:
    facts = [f"impedance {rounded(slab.epsilon * units.face['impedance'], 6)} Pa s/m"]
    facts += [] if alike else [f"round trip {rounded(slab.round_trip * units.time, 6)} s"]
    if slab.material:
        speed = slab.material.wave_speed
        thickness = 0.5 * slab.round_trip * units.time * speed
        facts = [f"thickness {rounded(thickness, 6)} m", f"wave speed {rounded(speed, 6)} m/s", *facts]
    return ", ".join(facts)


def _viscosity(viscosity: Viscosity, units: Units | None) -> str:
    (kind,) = (name for name, one in VISCOSITIES.items() if one is type(viscosity))
    return f"{kind}: {fields_in_words(viscosity)}" + (f" ({rounded(viscosity.time * units.time, 6)} s)" if units else "")


def _units(scene: Scene, units: Units) -> list[str]:
    stiffness = scene.stiffness / scene.transit * units.face["stiffness"]
    velocity = scene.velocity * units.reference_velocity
    return [
        f"units: L = {units.memory_length:g} m, V* = {units.reference_velocity:g} m/s, sigma = {units.normal_stress:g} Pa",
        f"one transit = {rounded(scene.transit * units.time, 6)} s; V = {rounded(velocity, 6)} m/s; "
        f"stiffness of slabs and faces in series {rounded(stiffness, 6)} Pa/m, "
        f"over the normal stress {rounded(1e-6 * stiffness / units.normal_stress, 6)} /um",
    ]
