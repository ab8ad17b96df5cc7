"""Values that were given with a unit, in the units of the scene (15)."""

from fractions import Fraction

from slipwave.errors import SceneError
from slipwave.input.number import TIME, Range
from slipwave.input.quantity import Quantity, looks_measured, quantity
from slipwave.input.schema import UNIT_KEYS
from slipwave.scene import Scene
from slipwave.scene.units import Units


def require_units(key: str, given: str, units: Units | None, instead: str) -> Units:
    """`units`, if the scene has them. Raises SceneError for `key`, which is in SI, if it has none."""
    if units is None:
        keys = f"interface.{', '.join(UNIT_KEYS[:-1])} and {UNIT_KEYS[-1]}"
        raise SceneError(f"{key} = {given}: must come with {keys} (SI), or be {instead}")
    return units


def quotient(value: float, unit: float) -> float:
    """value/unit, correctly rounded, for the decimal numbers that they print as: 1e-5/1e-6 is 10, not 10.000000000000002."""
    return float(Fraction(repr(value)) / Fraction(repr(unit)))


def in_scene(key: str, given: float | Quantity, units: Units | None, allowed: Range, transit: float = 1.0) -> float:
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
