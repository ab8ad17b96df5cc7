"""Turns validated tables into a frozen `Scene`: combines keys that depend on each other and converts SI (15)."""

import math
from itertools import pairwise
from typing import Any

from slipwave.errors import SceneError
from slipwave.friction import LAWS
from slipwave.input.number import EPSILON, LATER_VELOCITY, RELAXATION, ROUND_TRIP, TIME, UNTIL, VELOCITY, Range
from slipwave.input.outer_face import outer_face
from slipwave.input.relate import in_scene, require_units
from slipwave.input.schema import UNIT_KEYS, DriveTable, KelvinVoigtTable, LayerTable, SceneTable, SlabTable, StartTable
from slipwave.input.wording import shorten
from slipwave.scene import Scene
from slipwave.scene.doubts import doubt
from slipwave.scene.drive import Drive
from slipwave.scene.material import Material
from slipwave.scene.slab import KelvinVoigtViscosity, Layer, Slab, StandardLinearViscosity, Viscosity
from slipwave.scene.start import Start, StartKind
from slipwave.scene.units import Units

_DEFAULT_SIZES = {"nudge": 0.5, "jump": 0.05, "orbit": 0.5}


def assemble(data: dict[str, Any], tables: SceneTable, name: str) -> Scene:
    """The scene of the raw tables `data`, which are `tables` once validated, called `name` if they give no name. Raises
    SceneError for keys that do not fit together."""
    run = tables.run
    interface = dict(tables.interface)
    units = _units({key: interface[key] for key in UNIT_KEYS if interface[key] is not None})
    law = LAWS[tables.interface.law].parameters
    upper, lower = _slabs(tables, units)
    filled = {
        key: {name: value for name, value in table if value is not None} | data.get(key, {})
        for key, table in (("start", tables.start), ("run", run))
    }
    return Scene(
        name=tables.name or name,
        law=law(**{key: interface[key] for key in law._fields}),
        upper=upper,
        lower=lower,
        drive=_drive(tables.drive, units, upper.round_trip),
        start=_start(tables.start),
        until=None if run.until is None else in_scene("run.until", run.until, units, UNTIL, upper.round_trip),
        record=frozenset(run.record),
        units=units,
        written={"name": tables.name or name} | data | filled,
    )


def _units(given: dict[str, float]) -> Units | None:
    if not given:
        return None
    for key in UNIT_KEYS:
        if key not in given:
            raise SceneError(f"interface.{key}: missing; must be given with {' and '.join(sorted(given))} (all three or none)")
    return Units(**given)


def _slabs(tables: SceneTable, units: Units | None) -> tuple[Slab, Slab]:
    if tables.slab is not None:
        for key in ("upper", "lower"):
            if getattr(tables, key) is not None:
                raise SceneError(f"{key}: must not be given together with slab: either [slab] or both [upper] and [lower]")
        slab = _slab("slab", tables.slab, units)
        return slab, slab
    if tables.upper is None and tables.lower is None:
        raise SceneError("slab: missing; must be [slab] (both alike) or both [upper] and [lower]")
    if tables.upper is None or tables.lower is None:
        absent, present = ("upper", "lower") if tables.upper is None else ("lower", "upper")
        raise SceneError(f"{absent}: missing; [{present}] needs [{absent}] too (or use [slab] for both)")
    return _slab("upper", tables.upper, units), _slab("lower", tables.lower, units)


def _slab(key: str, table: SlabTable, units: Units | None) -> Slab:
    _require_units(key, table, units)
    epsilon = _epsilon(key, table, units)
    round_trip = _round_trip(key, table, units)
    face = outer_face(f"{key}.face", table.face, units, epsilon, round_trip)
    viscosity = _viscosity(f"{key}.viscosity", table.viscosity, units)
    return Slab(epsilon, round_trip, face, viscosity, _layers(key, table.layers), _material(table))


def _require_units(key: str, table: SlabTable, units: Units | None) -> None:
    for name in ("density", "shear_modulus", "thickness"):
        value = getattr(table, name)
        if value is not None:
            require_units(f"{key}.{name}", f"{value:g}", units, "replaced by epsilon and r")


def _material(table: SlabTable) -> Material | None:
    if table.density is None or table.shear_modulus is None:
        return None
    return Material(table.density, table.shear_modulus)


def _epsilon(key: str, table: SlabTable, units: Units | None) -> float:
    density, modulus = table.density, table.shear_modulus
    if table.epsilon is not None:
        for name in ("density", "shear_modulus"):
            if getattr(table, name) is not None:
                raise SceneError(f"{key}.{name} = {getattr(table, name):g}: must not be given together with {key}.epsilon")
        return table.epsilon
    if units is None or (density is None and modulus is None):
        raise SceneError(f"{key}.epsilon: missing; must be {EPSILON}, or give density and shear_modulus in SI")
    if density is None or modulus is None:
        absent = "density" if density is None else "shear_modulus"
        raise SceneError(f"{key}.{absent}: missing; density and shear_modulus [SI] must both be given")
    sources = {f"{key}.density": density, f"{key}.shear_modulus": modulus} | _named(units, "normal_stress", "reference_velocity")
    return _in_range("epsilon", units.epsilon(density, modulus), EPSILON, sources)


def _round_trip(key: str, table: SlabTable, units: Units | None) -> float:
    given = [name for name in ("r", "log10_r", "thickness") if getattr(table, name) is not None]
    if not given:
        raise SceneError(f"{key}.r: missing; must be r ({ROUND_TRIP}), log10_r, or in SI thickness")
    if len(given) > 1:
        raise SceneError(f"{key}.{given[1]} = {getattr(table, given[1]):g}: must not be given together with {key}.{given[0]}")
    if table.thickness is None:
        return table.r if table.r is not None else float(10.0 ** (table.log10_r or 0.0))
    if units is None or table.density is None or table.shear_modulus is None:
        raise SceneError(f"{key}.thickness = {table.thickness:g}: must come with density and shear_modulus, or be replaced by r")
    sources = {f"{key}.{name}": getattr(table, name) for name in ("thickness", "density", "shear_modulus")}
    round_trip = units.round_trip(table.density, table.shear_modulus, table.thickness)
    return _in_range("r", round_trip, ROUND_TRIP, sources | _named(units, "memory_length", "reference_velocity"))


def _named(units: Units, *keys: str) -> dict[str, float]:
    return {f"interface.{key}": getattr(units, key) for key in keys}


def _in_range(quantity: str, result: float, allowed: Range, sources: dict[str, float]) -> float:
    """`result`, derived from the keys `sources`. The SceneError for a result outside `allowed` names all of them, because any of
    them may be the wrong one, and what is doubtful about them."""
    if not allowed.low <= result <= allowed.high:
        given = ", ".join(f"{key} = {value:g}" for key, value in sources.items())
        odd = "".join(f"; {line}" for key, value in sources.items() for line in doubt(key, value))
        raise SceneError(f"{given}: result in {quantity} = {result:.9g}, which must be {allowed}{odd}")
    return result


def _viscosity(key: str, table: Any, units: Units | None) -> Viscosity | None:
    if table is None:
        return None
    time = in_scene(f"{key}.time", table.time, units, RELAXATION)
    is_kelvin_voigt = isinstance(table, KelvinVoigtTable)
    return KelvinVoigtViscosity(time) if is_kelvin_voigt else StandardLinearViscosity(time, table.ratio)


def _layers(key: str, tables: list[LayerTable] | None) -> tuple[Layer, ...]:
    if tables is None:
        return (Layer(1.0, 1.0),)
    total = math.fsum(table.fraction for table in tables)
    if abs(total - 1.0) > 1e-9:
        fractions = shorten([table.fraction for table in tables])
        raise SceneError(f"{key}.layers = {fractions}: must be fractions of the round trip that add up to 1, not {total:.10g}")
    return tuple(Layer(table.fraction / total, table.impedance) for table in tables)


def _drive(table: DriveTable, units: Units | None, transit: float) -> Drive:
    key, given = "drive.velocity", table.velocity
    times = [in_scene(key, time, units, TIME, transit) for time, _ in given]
    velocities = [in_scene(key, v, units, LATER_VELOCITY if k else VELOCITY) for k, (_, v) in enumerate(given)]
    is_rising = all(earlier <= later for earlier, later in pairwise(times))
    if not is_rising or any(times[k] == times[k - 2] for k in range(2, len(times))):
        given_times = f"{key}: times = {shorten(times)} (transits of the upper slab)"
        raise SceneError(f"{given_times}: must be rising; the same time twice is a step")
    return Drive(tuple(times), tuple(velocities))


def _start(table: StartTable) -> Start:
    size = _DEFAULT_SIZES[table.kind] if table.size is None else table.size
    return Start(StartKind(table.kind), size)
