"""Values that were given with a unit, in the units of the scene (15)."""

from fractions import Fraction

from slipwave.errors import SceneError
from slipwave.input.number import TIME, Numbers
from slipwave.input.quantity import KINDS, Quantity, looks_measured, quantity
from slipwave.input.schema import UNIT_KEYS, FaceTable
from slipwave.input.validate import allowed_in
from slipwave.scene import Scene
from slipwave.scene.slab import FACES, Face, face_sizes
from slipwave.scene.units import Units

_PER_AREA = {"N/m": "Pa/m", "N s/m": "Pa s/m", "kg": "kg/m2"}
_LARGEST_RATIO = 1e9


def require_units(key: str, given: str, units: Units | None, instead: str) -> Units:
    """`units`, if the scene has them. Raises SceneError for `key`, which is in SI, if it has none."""
    if units is None:
        keys = f"interface.{', '.join(UNIT_KEYS[:-1])} and {UNIT_KEYS[-1]}"
        raise SceneError(f"{key} = {given}: must come with {keys} (SI), or be {instead}")
    return units


def quotient(value: float, unit: float) -> float:
    """value/unit, correctly rounded, for the decimal numbers that they print as: 1e-5/1e-6 is 10, not 10.000000000000002."""
    return float(Fraction(repr(value)) / Fraction(repr(unit)))


def in_scene(key: str, given: float | Quantity, units: Units | None, allowed: Numbers, transit: float = 1.0) -> float:
    """A time or a velocity as the bare numbers of `allowed` are: in transits of `transit` L/V*, in L/V* or in V*. A number is so
    already. Raises SceneError naming `key` if the result is not `allowed`, or the scene has no units."""
    if not isinstance(given, Quantity):
        return given
    known = require_units(key, f'"{given.text}"', units, f"a number {allowed.bare}")
    per_second = 1.0 / (known.time * transit)
    result = given.value * per_second if given.unit == "s" else quotient(given.value, known.reference_velocity)
    if not allowed.low <= result <= allowed.high:
        unit, limits = allowed.bare.partition(" ")[2], f"from {allowed.low:g} to {allowed.high:g}"
        raise SceneError(f'{key} = "{given.text}": is {result:.9g} {unit}, which must be {limits}')
    return result


def moment(key: str, given: float | str, scene: Scene) -> float:
    """A time given to a command, a number or a text with or without a unit, in transits. Raises ValueError for what is no time,
    SceneError for a unit in a scene without units."""
    if isinstance(given, str) and looks_measured(given):
        return in_scene(key, quantity(given, "s"), scene.units, TIME, scene.transit)
    return float(given)


def outer_face(key: str, table: FaceTable, units: Units | None, epsilon: float, round_trip: float) -> Face:
    """The face of the table at `key` on a slab of `epsilon` and `round_trip`: springs, dashpots and masses in SI or in newtons
    become relative to the slab. Raises SceneError for a value out of range and for units that the scene lacks."""
    kind, slab = FACES[table.kind], face_sizes(epsilon, round_trip)
    given = {name: value for name, value in table if name != "kind"}
    area = given.pop("area", None)
    if area is not None:
        require_units(f"{key}.area", f"{area:g}", units, "left out")
    for name, value in given.items():
        is_measured = isinstance(value, Quantity)
        text = f'"{value.text}"' if is_measured else f"{value:g}"
        if is_measured:
            require_units(f"{key}.{name}", text, units, "relative to the slab")
        if is_measured or (kind.is_own and name in slab):
            per_area = _per_area(key, name, value, area)
            result = per_area / (slab[name] * units.face[name] if units else 1.0)
            own = next(item for item in allowed_in(type(table).model_fields[name]) if isinstance(item, Numbers))
            allowed = Numbers(own.low, min(own.high, _LARGEST_RATIO))
            if not allowed.low <= result <= allowed.high:
                relative = "" if result == value else f" is {result:.9g} relative to the slab, which"
                raise SceneError(f"{key}.{name} = {text}:{relative} must be {allowed}")
            given[name] = result
    return kind(**given)


def _per_area(key: str, name: str, given: float | Quantity, area: float | None) -> float:
    """`given` per area: it is of the whole face if it is in newtons or kilograms, or a number beside an `area`."""
    if not isinstance(given, Quantity):
        return given if area is None else given / area
    if given.unit not in _PER_AREA:
        return given.value
    if area is None:
        example = KINDS[_PER_AREA[given.unit]][1]
        raise SceneError(f'{key}.{name} = "{given.text}": must come with {key}.area, or be per area, as in "{example}"')
    return given.value / area
