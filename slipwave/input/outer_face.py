"""Outer faces from their tables: springs, dashpots and masses in SI or in newtons become relative to the slab."""

from slipwave.errors import SceneError
from slipwave.input.number import Range
from slipwave.input.quantity import KINDS, Quantity
from slipwave.input.relate import require_units
from slipwave.input.schema import FaceTable
from slipwave.input.validate import allowed_in
from slipwave.scene.slab import FACES, Face, face_sizes
from slipwave.scene.units import Units

_PER_AREA = {"N/m": "Pa/m", "N s/m": "Pa s/m", "kg": "kg/m2"}
_LARGEST = 1e9  # relative to the slab


def outer_face(key: str, table: FaceTable, units: Units | None, epsilon: float, round_trip: float) -> Face:
    """The face of the table at `key` on a slab of `epsilon` and `round_trip`. Raises SceneError for a value out of range and for
    units that the scene lacks."""
    kind = FACES[table.kind]
    given = {name: value for name, value in table if name != "kind"}
    area = given.pop("area", None)
    if area is not None:
        require_units(f"{key}.area", f"{area:g}", units, "left out")
    slab = face_sizes(epsilon, round_trip)
    for name, value in given.items():
        if isinstance(value, Quantity):
            require_units(f"{key}.{name}", _as_given(value), units, "relative to the slab")
        if isinstance(value, Quantity) or (kind.is_own and name in slab):
            one = slab[name] * units.face[name] if units else 1.0
            result = _per_area(key, name, value, area) / one
            allowed = next(item for item in allowed_in(type(table).model_fields[name]) if isinstance(item, Range))
            given[name] = _relative(f"{key}.{name}", value, result, Range(allowed.low, min(allowed.high, _LARGEST)))
    return kind(**given)


def _per_area(key: str, name: str, given: float | Quantity, area: float | None) -> float:
    """`given` per area: it is of the whole face if it is in newtons or kilograms, or a number beside an `area`."""
    if not isinstance(given, Quantity):
        return given if area is None else given / area
    if given.unit not in _PER_AREA:
        return given.value
    if area is None:
        example = KINDS[_PER_AREA[given.unit]][1]
        raise SceneError(f'{key}.{name} = {_as_given(given)}: must come with {key}.area, or be per area, as in "{example}"')
    return given.value / area


def _relative(key: str, given: float | Quantity, result: float, allowed: Range) -> float:
    """`result`, which follows from `given`. Raises SceneError naming `key` if it is not `allowed`."""
    if not allowed.low <= result <= allowed.high:
        relative = "" if result == given else f" is {result:.9g} relative to the slab, which"
        raise SceneError(f"{key} = {_as_given(given)}:{relative} must be {allowed}")
    return result


def _as_given(given: float | Quantity) -> str:
    return f'"{given.text}"' if isinstance(given, Quantity) else f"{given:g}"
